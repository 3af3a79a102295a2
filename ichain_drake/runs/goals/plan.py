"""A goal from its text, and a plan for it from what is measured."""

from __future__ import annotations

from collections.abc import Sequence

from threadpoolctl import threadpool_limits

from ichain_drake.control.planning.goals import parse_goal, stay
from ichain_drake.control.planning.plan import Goal, NoPlan, Plan, States
from ichain_drake.learning import InteractionModel
from ichain_drake.runs.goals.knowledge import Knowledge


def make_goal(expressions: Sequence[str], model: InteractionModel, start: States) -> Goal:
    """Read a goal; `keep object.variable within value` holds a variable where it is at the start.

    Raises:
        InputError: on an expression that can't be read.
    """
    kept, plain = [], []
    for text in expressions:
        words_of = text.split()
        if len(words_of) == 4 and words_of[0] == "keep" and words_of[2] == "within" and "." in words_of[1]:  # noqa: PLR2004
            obj, _, variable = words_of[1].rpartition(".")
            parse_goal([f"{words_of[1]} >= {words_of[3]}"], model, start)  # refuses unknown names and numbers
            kept += list(stay(start, obj, [variable], model, float(words_of[3])))
        else:
            plain.append(text)
    goal = parse_goal(plain, model, start) if plain or not kept else Goal(())
    return Goal((*goal.conditions, *kept), goal.inactive)


def make_plan(knowledge: Knowledge, expressions: Sequence[str], start: States) -> tuple[Goal, Plan | NoPlan]:
    """A plan for a goal from measured states; `ichain plan` prints it with `format_plan`.

    Raises:
        InputError: on an expression that can't be read.
    """
    with threadpool_limits(limits=1):
        goal = make_goal(expressions, knowledge.model, start)
        return goal, knowledge.planner.plan(start, goal)
