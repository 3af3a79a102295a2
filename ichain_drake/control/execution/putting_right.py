"""What is done first after a step of a plan has failed, before there is a new plan."""

from __future__ import annotations

from collections.abc import Sequence

from ichain_drake.control.execution.laying_out import carry_tasks, indices, way_back
from ichain_drake.control.execution.switching import Switch
from ichain_drake.control.execution.taking_back import TakeBack
from ichain_drake.control.execution.tasks import Failed, Task, View
from ichain_drake.control.planning.plan import PlanStep
from ichain_drake.learning.model import InteractionModel
from ichain_drake.rules import enabled


def put_right(
    model: InteractionModel, view: View, step: PlanStep, failure: Failed, origin: Sequence[float]
) -> list[Task]:
    """Put down what can't be brought where it should go, and let go of what is not carried.

    Args:
        model: the learned graph as the robot that acts sees it.
        view: of the tick in which the step failed.
        step: that failed.
        failure: how.
        origin: where what was carried stood before, values of its variables; empty where nothing was.

    Returns:
        Tasks, in their order; may be none.
    """
    edge = step.chain[0]
    carries = bool(step.after or step.before or step.until is None)
    if carries and failure.cause != "lost" and view.holds(edge):
        if failure.cause == "reach":  # what is held over nothing would fall
            return way_back(model, step, dict(enumerate(origin)))
        if failure.cause != "carry" and step.before:
            return carry_tasks(model, edge, indices(model, step.before, edge), place_first=False)
        return []
    if failure.cause == "deactivation":
        return []
    # Where there was no way to what should be switched, there is nothing to let go of, nor a way away from it.
    back: list[Task] = [Switch(edge, activate=False, forced=failure.cause != "reach")]
    if failure.cause == "lost" and origin and enabled("take_back"):  # it may only be caught on something
        back.insert(0, TakeBack(edge, steps=way_back(model, step, dict(enumerate(origin)))[:-1]))
    return back
