"""Where a drive begins: quiet, near the driving pose, and where the object has been before it was turned."""

from types import SimpleNamespace

import numpy as np

from ichain_drake.control.planning.carries import CarryOption
from ichain_drake.control.planning.options import _unseen
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.state import Role, StateSpace, Variable

CARRY = Interaction("robot", "cup")


def model(seen: list[list[float]], *, roles: bool = True) -> SimpleNamespace:
    place = Role("position", "world", "z") if roles else None
    cup = StateSpace("cup", (Variable("z", "m", role=place), Variable("tilt", "rad")))
    graph = InteractionGraph({"robot": StateSpace("robot", (Variable("z", "m"),)), "cup": cup}, ["robot->cup"])
    active = {"robot": np.zeros((len(seen), 1)), "cup": np.array(seen)}
    return SimpleNamespace(graph=graph, edges={CARRY: SimpleNamespace(examples=SimpleNamespace(active=active))})


def carry() -> CarryOption:
    return CarryOption(CARRY, np.array([0, 1]), np.array([[0.1, 0.0], [0.2, 0.02]]))


def test_a_low_place_that_was_only_seen_turned_is_far_from_what_was_seen() -> None:
    # The cup was low when tilted; upright it was never below 0.4.
    seen = model([[0.5, 0.0], *[[0.4, 0.0]] * 3, [0.4, -1.2], *[[0.28, -1.2]] * 3])
    width = np.array([0.5, 2.0])
    away = _unseen(seen, carry(), np.array([[0.4, -0.8], [0.28, -1.2]]), width)  # type: ignore[arg-type]
    np.testing.assert_allclose(away, [0.005, 0.12 / 0.5 + 0.005], atol=1e-9)


def test_what_was_passed_through_once_is_not_taken_for_seen() -> None:
    passed = model([*[[0.5, 0.0]] * 3, [0.28, 0.0]])
    away = _unseen(passed, carry(), np.array([[0.5, 0.0], [0.28, 0.0]]), np.array([0.5, 2.0]))  # type: ignore[arg-type]
    np.testing.assert_allclose(away, [0.005, 0.22 / 0.5 + 0.005], atol=1e-9)
    few = model([[0.5, 0.0], [0.28, 0.0]])
    assert _unseen(few, carry(), np.array([[0.5, 0.0]]), np.array([0.5, 2.0]))[0] > 0.4  # type: ignore[arg-type]


def test_without_positions_every_pose_is_as_good() -> None:
    seen = model([[0.5, 0.0]], roles=False)
    assert not _unseen(seen, carry(), np.array([[0.4, -0.8]]), np.array([0.5, 2.0])).any()  # type: ignore[arg-type]
