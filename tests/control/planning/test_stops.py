"""Where a predicted drive may end."""

from types import SimpleNamespace
from typing import Any

import numpy as np

from ichain_drake.control.planning.borders import Border
from ichain_drake.control.planning.plan import Condition
from ichain_drake.control.planning.stops import Stop, find_stops
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.state import StateSpace, Variable

EDGE = Interaction("robot", "a")
SPACE = StateSpace("a", (Variable("x"), Variable("y")))


def run(*lost: Interaction | None) -> Any:
    """One drive goes up by one a step until it ends after four, another by a half once and ends after two."""
    x = np.array([[0.0, 0.0], [1.0, 0.5], [2.0, 0.5], [3.0, 0.5], [4.0, 0.5]])
    history = [{"a": np.column_stack([now, np.zeros(2)]), "robot": np.zeros((2, 1))} for now in x]
    graph = InteractionGraph({"robot": StateSpace("robot", (Variable("x"),)), "a": SPACE}, ["robot->a"])
    return SimpleNamespace(
        model=SimpleNamespace(graph=graph), history=history, last=np.array([4, 2]), lost=lost or (None, None)
    )


def of(lower: float, upper: float) -> Condition:
    return Condition("a", "x", lower, upper)


FULL = [Stop(0, 4), Stop(1, 2)]


def test_without_a_goal_a_drive_ends_at_its_end() -> None:
    assert find_stops(run(), [], []) == FULL


def test_a_drive_may_end_at_the_first_step_in_which_a_condition_holds() -> None:
    assert find_stops(run(), [of(1.5, np.inf)], []) == [Stop(0, 2, condition=0), *FULL]
    assert find_stops(run(), [of(0.4, np.inf)], []) == [
        Stop(0, 1, condition=0),
        FULL[0],
        Stop(1, 1, condition=0),
        FULL[1],
    ]
    assert find_stops(run(), [of(4.0, np.inf)], []) == FULL, "that is where it ends anyway"
    assert find_stops(run(), [of(-np.inf, 0.2)], []) == FULL, "it held from the first"
    assert find_stops(run(), [of(-0.2, 0.6)], []) == FULL, "and so did a narrow one, though its middle is passed"


def test_a_range_that_lies_between_two_steps_is_met_in_its_middle_and_a_wide_one_where_it_begins() -> None:
    assert find_stops(run(), [of(1.4, 1.6)], []) == [Stop(0, 2, 0.5, 0), *FULL]
    assert find_stops(run(), [of(1.0, 4.0)], []) == [Stop(0, 1, condition=0), *FULL]


def test_a_drive_may_end_where_a_variable_passes_a_border() -> None:
    border = Border("a", 0, 0.25, EDGE)
    assert find_stops(run(), [], [border]) == [Stop(0, 1, 0.25), FULL[0], Stop(1, 1, 0.5), FULL[1]]
    assert find_stops(run(), [], [Border("a", 1, 0.25, EDGE), Border("a", 0, 9.0, EDGE)]) == FULL


def test_ends_come_in_the_order_in_which_they_are_passed_and_each_once() -> None:
    conditions = [of(2.9, np.inf), of(1.4, 1.6)]
    borders = [Border("a", 0, 3.5, EDGE), Border("a", 0, 1.5, EDGE)]
    assert find_stops(run(), conditions, borders) == [
        Stop(0, 2, 0.5, 1),
        Stop(0, 3, condition=0),
        Stop(0, 4, 0.5),
        *FULL,
    ]


def test_a_drive_that_never_began_ends_nowhere_but_at_its_end() -> None:
    assert find_stops(run(EDGE, None), [of(0.4, np.inf)], []) == [FULL[0], Stop(1, 1, condition=0), FULL[1]]
