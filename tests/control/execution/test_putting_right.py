"""What is done after a failed step where the robot holds nothing; what it holds is in `test_laying_out.py`."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from toy_models import TAP_START, tap

from ichain_drake.control.execution.putting_right import put_right
from ichain_drake.control.execution.switching import Switch
from ichain_drake.control.execution.taking_back import TakeBack
from ichain_drake.control.execution.tasks import Failed, Task
from ichain_drake.control.planning.plan import PlanStep
from ichain_drake.graph import Interaction

TAKE = Interaction("robot", "cup")
STEP = PlanStep((TAKE,), {("cup", "x"): 1.0}, after={("cup", "x"): 1.0}, predicted=TAP_START, ticks=5)
ORIGIN = tuple(float(v) for v in np.atleast_1d(TAP_START["cup"]))


def right(cause: str, origin: tuple[float, ...] = ()) -> list[Task]:
    view = SimpleNamespace(holds=lambda edge: False)
    return put_right(tap(), view, STEP, Failed(TAKE, cause, "it did not"), origin)  # type: ignore[arg-type]


@pytest.mark.parametrize(("cause", "forced"), [("reach", False), ("carry", True), ("lost", True)])
def test_what_is_not_held_is_let_go_of_and_surely_unless_there_was_no_way_to_it(cause: str, forced: bool) -> None:
    (task,) = right(cause)
    assert isinstance(task, Switch)
    assert (task.edge, task.activate, task.forced) == (TAKE, False, forced)


def test_what_is_not_let_go_of_is_not_let_go_of_again() -> None:
    assert right("deactivation") == []


def test_what_was_lost_on_the_way_may_be_caught_and_is_taken_back_first() -> None:
    back, task = right("lost", ORIGIN)
    assert isinstance(back, TakeBack)
    assert isinstance(task, Switch)
    assert not any(isinstance(t, Switch) for t in back.steps), "it is not let go of on the way"
