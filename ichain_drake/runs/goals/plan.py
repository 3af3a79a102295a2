"""A plan for a goal from what is measured."""

from __future__ import annotations

from collections.abc import Sequence

from threadpoolctl import threadpool_limits

from ichain_drake.control.planning.goals import parse_goal
from ichain_drake.control.planning.plan import Goal, NoPlan, Plan, States
from ichain_drake.learning import InteractionModel
from ichain_drake.simulation.wiring import make_planner


def make_plan(
    model: InteractionModel, expressions: Sequence[str], start: States, planner: str = "fast"
) -> tuple[Goal, Plan | NoPlan]:
    """A plan for a goal from measured states; `ichain plan` prints it with `format_plan`.

    Raises:
        InputError: on an expression that can't be read.
    """
    with threadpool_limits(limits=1):
        goal = parse_goal(expressions, model, start)
        return goal, make_planner(model, planner).plan(start, goal)
