"""What a step should drive and hardly changed was not acted on, whatever the status model said."""

import numpy as np
import pytest
from toy_models import TAP_START, tap

from ichain_drake.control.execution.monitoring import undriven
from ichain_drake.control.planning.goals import parse_goal
from ichain_drake.control.planning.plan import Plan
from ichain_drake.control.planning.planner import GraphPlanner


@pytest.mark.parametrize(("share", "expected"), [(0.0, True), (0.1, True), (0.5, False), (1.0, False)])
def test_a_drive_that_changed_nothing_is_told_from_one_that_fell_short(share: float, expected: bool) -> None:
    model = tap()
    plan = GraphPlanner(model).plan(TAP_START, parse_goal(["cup.water >= 0.3"], model, TAP_START))
    assert isinstance(plan, Plan)
    step = next(s for s in plan.steps if s.until is not None)
    target, name, _, value = step.until
    i = model.graph.objects[target].observable.index(name)
    now = {n: v.copy() for n, v in TAP_START.items()}
    now[target][i] += share * (value - now[target][i])
    assert undriven(model, step, TAP_START, now) is expected
    assert not undriven(model, step, {}, now)
    carried = next(s for s in plan.steps if s.until is None)
    assert not undriven(model, carried, TAP_START, {n: np.zeros_like(v) for n, v in now.items()})
