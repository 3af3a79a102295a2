"""States in any shape as rows, and back; what can't be rows is refused."""

import numpy as np
import pytest
from small_world import GRAPH

from ichain_drake.errors import InputError
from ichain_drake.graph import Interaction
from ichain_drake.learning.batch import flatten, forced_status, shaped

HAND, BOX = (len(GRAPH.objects[n].observable) for n in ("hand", "box"))
CARRY = GRAPH.interactions[0]


def test_leading_dimensions_broadcast_and_come_back() -> None:
    rng = np.random.default_rng(0)
    states = {"hand": rng.normal(size=(3, 1, HAND)), "box": rng.normal(size=(2, BOX)), "other": np.zeros(1)}
    rows, shape = flatten(states, ["hand", "box"], GRAPH)
    assert shape == (3, 2)
    assert set(rows) == {"hand", "box"}
    assert rows["hand"].shape == (6, HAND)
    back, on = shaped(rows, {CARRY: np.arange(6) % 2 == 0}, shape)
    np.testing.assert_array_equal(back["hand"], np.broadcast_to(states["hand"], (3, 2, HAND)))
    np.testing.assert_array_equal(back["box"], np.broadcast_to(states["box"], (3, 2, BOX)))
    np.testing.assert_array_equal(on[CARRY], [[True, False]] * 3)


def test_one_state_is_a_batch_of_one() -> None:
    rows, shape = flatten({"hand": np.zeros(HAND)}, ["hand"], GRAPH)
    assert shape == ()
    assert rows["hand"].shape == (1, HAND)


def test_a_second_state_of_an_object_goes_by_another_name() -> None:
    rows, _ = flatten({"later": np.ones(HAND), "hand": np.zeros(HAND)}, ["hand", "later"], GRAPH, {"later": "hand"})
    np.testing.assert_array_equal(rows["later"], np.ones((1, HAND)))
    with pytest.raises(InputError, match=r"the state of hand is missing; given are box"):
        flatten({"box": np.zeros(BOX)}, ["later"], GRAPH, {"later": "hand"})


@pytest.mark.parametrize("wrong", [np.zeros(HAND + 1), np.zeros((2, HAND - 1)), np.float64(1.0)])
def test_a_wrong_length_is_refused_with_the_variables(wrong: np.ndarray) -> None:
    with pytest.raises(InputError, match=rf"state of hand: shape .* given, {HAND} values needed \(x, "):
        flatten({"hand": wrong}, ["hand"], GRAPH)


def test_a_forced_status_is_one_for_all_rows_or_one_a_row() -> None:
    other = GRAPH.interactions[1]
    found = forced_status({CARRY: True, other: [[True, False, True]]}, GRAPH, (2, 3), 6)
    assert found[CARRY].all()
    assert found[CARRY].shape == (6,)
    np.testing.assert_array_equal(found[other], [True, False, True] * 2)
    assert forced_status(None, GRAPH, (2, 3), 6) == {}
    with pytest.raises(InputError, match=r"box->hand is no interaction of the graph; it has hand->box"):
        forced_status({Interaction("box", "hand"): True}, GRAPH, (), 1)
