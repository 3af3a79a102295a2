"""No plan is made again as it was once execution has contradicted it."""

import numpy as np
import pytest
from toy_models import LAMP_START, TAP_START, lamp, tap
from winding import SHADE_START, shade

from ichain_drake.control.planning.experience import Contradiction, Experience, Record, expected_ticks
from ichain_drake.control.planning.goals import parse_goal
from ichain_drake.control.planning.plan import Plan
from ichain_drake.control.planning.planner import GraphPlanner
from ichain_drake.learning.settings import LEARNING

CASES = {
    "shade": (shade, SHADE_START, "shade.height >= 0.7"),
    "tap": (tap, TAP_START, "cup.water >= 0.5"),
    "lamp": (lamp, LAMP_START, "lamp.light >= 0.5"),
}


def as_it_is(plan: Plan) -> tuple[object, ...]:
    return tuple((s.chain, s.until and s.until[:3], tuple(sorted(s.wanted.items())), s.variant) for s in plan.steps)


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("seed", range(3))
def test_the_same_plan_is_never_made_twice(name: str, seed: int) -> None:
    make, start, text = CASES[name]
    model, rng = make(), np.random.default_rng(seed)
    planner, goal = GraphPlanner(model), parse_goal([text], model, start)
    seen: set[object] = set()
    contradictions: list[Contradiction] = []
    for _ in range(6):
        found = planner.plan(start, goal, Experience(tuple(contradictions)))
        if not isinstance(found, Plan):
            return
        assert as_it_is(found) not in seen
        seen.add(as_it_is(found))
        k = int(rng.integers(len(found.steps)))
        contradictions.append(Contradiction(found.steps[k], start if k == 0 else found.steps[k - 1].predicted))


def test_an_option_that_failed_costs_more_and_is_another_one_until_it_is_given_up() -> None:
    model = tap()
    planner, goal = GraphPlanner(model), parse_goal(["0.3 <= tank.water <= 0.4"], model, TAP_START)
    first = planner.plan(TAP_START, goal)
    assert isinstance(first, Plan)
    failed = Contradiction(first.steps[0], TAP_START)
    again = planner.plan(TAP_START, goal, Experience((failed,)))
    assert isinstance(again, Plan)
    assert again.steps[0].variant == 1
    assert again.ticks == expected_ticks(first.steps[0].ticks, 1) > first.ticks
    given_up = planner.plan(TAP_START, goal, Experience((failed,) * (LEARNING.few + 1)))
    assert not isinstance(given_up, Plan) or given_up.steps[0].chain != first.steps[0].chain or len(given_up.steps) > 1


def test_a_failure_elsewhere_says_nothing() -> None:
    model = tap()
    found = GraphPlanner(model).plan(TAP_START, parse_goal(["cup.x >= 0.9"], model, TAP_START))
    assert isinstance(found, Plan)
    record = Record(model, [Contradiction(found.steps[0], TAP_START)])
    assert record.failures(found.steps[0], TAP_START) == 1
    assert record.failures(found.steps[0], {**TAP_START, "cup": np.array([0.5, 0.05])}) == 0
