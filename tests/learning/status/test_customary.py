"""Customary conditions: ranges as they were shown, with room at both ends."""

from dataclasses import replace

import numpy as np
import pytest

from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning.data import GraphData, Piece
from ichain_drake.learning.settings import LEARNING
from ichain_drake.learning.status.customary import CautiousStatus, Customary, _shown, learn_customary
from ichain_drake.learning.status.inputs import StatusInput, ValueInput
from ichain_drake.learning.status.status import always_active
from ichain_drake.state import Role, StateSpace, Variable


def test_a_range_has_room_by_its_width_or_by_noise_whichever_is_more() -> None:
    columns = np.array([[2.0, 7.0, -3.0], [4.0, 7.1, -3.0]])
    low, high = _shown(columns, np.array([0.01, 1.0, 0.0]))
    room = np.array([LEARNING.reach * 2.0, LEARNING.surely * 1.0, 0.0])
    assert low == pytest.approx(np.array([2.0, 7.0, -3.0]) - room, abs=1e-8)
    assert high == pytest.approx(np.array([4.0, 7.1, -3.0]) + room, abs=1e-8)
    assert low[2] < -3.0 < high[2], "what never changed is within it"


DOOR = Customary(
    (ValueInput("door", 0, "door.angle"), ValueInput("lamp", 1, "lamp.light")),
    np.array([0.0, -1.0]),
    np.array([4.0, 1.0]),
)


def test_conditions_hold_within_all_ranges_and_most_in_their_middle() -> None:
    states = {
        "door": np.array([[2.0], [3.0], [4.0], [5.0], [2.0]]),
        "lamp": np.array([[9.0, 0.0], [9.0, -0.25], [9.0, 0.0], [9.0, 0.0], [9.0, -1.5]]),
    }
    np.testing.assert_allclose(DOOR.decide(states), [1.0, 0.5, 0.0, -0.5, -0.5])
    assert DOOR.labels == ("door.angle", "lamp.light")
    nothing = Customary((), np.zeros(0), np.zeros(0))
    assert nothing.decide(states).tolist() == [1.0] * 5
    assert nothing.fits(states)


@pytest.mark.parametrize(
    ("low", "high", "fits"),
    [
        ([0.0, -1.0], [4.0, 1.0], True),
        ([0.0], [4.0], False),
        ([0.0, -1.0], [4.0, 1.0, 2.0], False),
        ([0.0, 1.0], [4.0, 1.0], False),
        ([5.0, -1.0], [4.0, 1.0], False),
    ],
)
def test_each_column_has_a_range(low: list[float], high: list[float], *, fits: bool) -> None:
    states = {"door": np.zeros((2, 1)), "lamp": np.zeros((2, 2))}
    assert Customary(DOOR.inputs, np.array(low), np.array(high)).fits(states) is fits


def test_a_cautious_classifier_asks_for_the_conditions_too() -> None:
    status = CautiousStatus.of(always_active(9), DOOR)
    states = {"door": np.array([[1.0], [5.0]]), "lamp": np.zeros((2, 2))}
    np.testing.assert_allclose(status.decide(states), np.minimum(always_active(9).decide(states), [0.5, -0.5]))
    assert (status.samples, status.customary) == (9, DOOR)


HANDLE, SHUT, LIGHT = (Interaction(*e) for e in (("hand", "food"), ("door", "food"), ("hand", "door")))


def kitchen(seed: int = 0) -> GraphData:
    """Food is handled only while a door stands open, and only where the hand is near; all places are in one frame."""
    x = Variable("x", "m", role=Role("position", "room", "x"))
    spaces = {
        "hand": StateSpace("hand", (x,)),
        "door": StateSpace("door", (Variable("angle"),)),
        "food": StateSpace("food", (x,)),
    }
    graph, rng, pieces = InteractionGraph(spaces, [HANDLE, SHUT, LIGHT]), np.random.default_rng(seed), []
    for k in range(5):
        angle = np.repeat(rng.choice([rng.uniform(0.0, 0.2), rng.uniform(1.0, 2.0)], 30), 5)
        hand, food = np.repeat(rng.uniform(-1.0, 1.0, 50), 3), np.repeat(rng.uniform(0.0, 1.0, 15), 10)
        on = (angle > 0.5) & (np.abs(hand - 0.0) < 0.4)
        states = {"hand": hand[:, None], "door": angle[:, None], "food": food[:, None]}
        flags = {HANDLE: on, SHUT: (food > 0.5) & (angle < 0.5), LIGHT: rng.uniform(size=150) < 0.5}
        pieces.append(Piece(f"p{k}", {n: s + 1e-3 * rng.normal(size=s.shape) for n, s in states.items()}, flags))
    return GraphData(
        graph, spaces, tuple(pieces), (HANDLE, SHUT, LIGHT), {n: tuple(range(len(s))) for n, s in spaces.items()}
    )


def conditions(data: GraphData, edge: Interaction, *known: StatusInput) -> Customary:
    status = replace(always_active(9), inputs=known)
    noise = {n: np.full(len(s), 1e-3) for n, s in data.spaces.items()}
    return learn_customary(data, edge, dict.fromkeys(data.edges), status, noise)


def test_what_always_held_of_another_parent_is_customary_unless_the_classifier_looks_at_it() -> None:
    data = kitchen()
    found = conditions(data, HANDLE)
    assert found.labels == ("door.angle",)
    angle = data.stacked("door")[data.flag(HANDLE), 0]
    low, high = _shown(angle[:, None], np.full(1, 1e-3))
    np.testing.assert_allclose([found.low, found.high], [low, high])
    assert found.fits({n: data.stacked(n) for n in data.spaces})
    assert conditions(data, HANDLE, *found.inputs).labels == ()
    always = {e: np.ones(150, dtype=bool) for e in data.edges}
    shown = replace(data, pieces=tuple(replace(p, flags=always) for p in data.pieces))
    assert conditions(shown, HANDLE).labels == (), "what is active in every row has none"


def test_where_the_robot_is_no_end_the_childs_own_place_is_customary() -> None:
    """Of food that is warmed behind the door; where the hand was is nobody's business."""
    data = kitchen()
    found = conditions(data, SHUT)
    assert found.labels == ("position of food",)
    (place,) = found.inputs
    assert conditions(data, SHUT, place).labels == ()
