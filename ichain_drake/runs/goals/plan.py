"""A goal from its text, and a plan for it from what is measured."""

from __future__ import annotations

from collections.abc import Sequence

from threadpoolctl import threadpool_limits

from ichain_drake.control.planning.goals import parse_goal
from ichain_drake.control.planning.plan import Goal, NoPlan, Plan, States
from ichain_drake.learning import InteractionModel
from ichain_drake.runs.goals.knowledge import Knowledge


def make_goal(expressions: Sequence[str], model: InteractionModel, start: States) -> Goal:
    """Read a goal from its expressions and the states at the start.

    Raises:
        InputError: on an expression that can't be read.
    """
    return parse_goal(expressions, model, start)


def make_plan(knowledge: Knowledge, expressions: Sequence[str], start: States) -> tuple[Goal, Plan | NoPlan]:
    """A plan for a goal from measured states; `ichain plan` prints it with `format_plan`.

    Raises:
        InputError: on an expression that can't be read.
    """
    with threadpool_limits(limits=1):
        goal = make_goal(expressions, knowledge.model, start)
        return goal, knowledge.planner.plan(start, goal)
