"""Whether an object can be held where it is, by the likeliest demonstrated grasp there."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ichain_drake.control.planning.holding import can_hold, hold_margin, hold_probability, taken_as
from ichain_drake.control.settings import PLANNING
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.rules import without
from ichain_drake.state import FloatArray, Role, StateSpace, Variable

HOLD = Interaction("robot", "ball")
RAIL = StateSpace("thing", (Variable("x", "m", role=Role("position", "rail", "x")),))
SHORT = StateSpace("thing", (Variable("x", "m", lower=-1.0, upper=1.0, role=Role("position", "rail", "x")),))


def model(*, relative: bool = True, robot: StateSpace = RAIL) -> Any:
    """A robot holds a ball within 10 cm of it, the more surely the nearer; beyond 2 m a wall is in the way."""

    def decide(edge: Interaction, states: dict[str, FloatArray]) -> FloatArray:
        near = 0.1 - np.abs(states["robot"][..., 0] - states["ball"][..., 0])
        return np.minimum(near, 2.0 - states["ball"][..., 0])

    shown = {"robot": np.array([[0.05], [0.01], [0.3], [-0.08]]), "ball": np.zeros((4, 1))}
    learned = SimpleNamespace(examples=SimpleNamespace(active=shown), alignment=None, relative=relative)
    return SimpleNamespace(
        graph=InteractionGraph({"robot": robot, "ball": RAIL}, ["robot->ball"]),
        edges={HOLD: learned},
        decide=decide,
        probability=lambda edge, states: np.clip(5.0 * decide(edge, states) + 0.5, 0.0, 1.0),
    )


def at(*places: float) -> list[dict[str, FloatArray]]:
    return [{"robot": np.array([9.0]), "ball": np.array([x])} for x in places]


def test_the_likeliest_grasp_goes_along_with_the_object_and_what_is_in_its_way_is_seen() -> None:
    np.testing.assert_allclose(hold_probability(model(), HOLD, at(0.0, 1.0, 1.95, 2.5)), [0.95, 0.95, 0.75, 0.0])
    assert can_hold(model(), HOLD, at(1.0, 2.5)).tolist() == [True, False]
    assert hold_probability(model(), HOLD, []).shape == (0,)
    just = model()
    just.probability = lambda edge, states: np.full(len(states["ball"]), PLANNING.likely)
    assert can_hold(just, HOLD, at(1.0)).tolist() == [True], "as likely as is asked for"


@pytest.mark.parametrize("known", ["place", "grasp", "rule"])
def test_where_nothing_is_known_of_a_grasp_elsewhere_it_holds(known: str) -> None:
    learned = model(relative=known != "place")
    if known == "grasp":
        learned.edges[HOLD].examples.active["robot"] += 1.0
    with without(["can_hold"] if known == "rule" else []):
        np.testing.assert_array_equal(hold_probability(learned, HOLD, at(0.0, 2.5)), [1.0, 1.0])


def test_an_object_is_taken_as_it_was_from_where_it_is_now() -> None:
    motion: Any = SimpleNamespace(edge=HOLD, robot=np.array([[0.0], [0.05]]), child=np.array([[9.0], [0.0]]))
    np.testing.assert_allclose(taken_as(model(), motion, 1, np.array([0.7])), [0.75])
    np.testing.assert_array_equal(taken_as(model(relative=False), motion, 1, np.array([0.7])), [0.05])


def test_beyond_its_bounds_the_robot_takes_nothing() -> None:
    """A grasp goes along with the object, but the robot not beyond what is declared of it."""
    np.testing.assert_allclose(hold_probability(model(robot=SHORT), HOLD, at(0.9, 1.05, 1.3)), [0.95, 0.75, 0.0])
    assert hold_margin(model(robot=SHORT), HOLD, at(1.3)[0]) == pytest.approx(0.1 - 0.3)
    assert hold_margin(model(relative=False), HOLD, at(1.3)[0]) == 0.0
