"""Ticks that effects are fitted to: both ends active, states read in their own rows, other interactions beside them."""

import numpy as np
import pytest

from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning.data import GraphData, Piece
from ichain_drake.learning.effects.active_ticks import active_ticks
from ichain_drake.state import StateSpace, Variable

PUSH, WIND = Interaction("hand", "box"), Interaction("fan", "box")
SPACES = {n: StateSpace(n, (Variable("x"), Variable("y"))) for n in ("hand", "box", "fan")}


def data(*flags: str, wind: str = "") -> GraphData:
    """Pieces whose states are 100 times their number, and a tenth of it per row; the box's are those plus .5."""
    graph = InteractionGraph(SPACES, [PUSH, Interaction("hand", "fan"), WIND])
    pieces = []
    for k, text in enumerate(flags):
        rows = 100.0 * k + np.arange(len(text)) / 10.0
        states = {n: np.column_stack([rows, -rows]) + 0.5 * (n == "box") for n in SPACES}
        on = {PUSH: text, WIND: wind or "0" * len(text)}
        pieces.append(
            Piece(f"p{k}", states, {e: np.array([c == "1" for c in on.get(e, text)]) for e in graph.interactions})
        )
    return GraphData(graph, SPACES, tuple(pieces), graph.interactions, dict.fromkeys(SPACES, (0, 1)))


def test_ticks_are_those_that_begin_and_end_active() -> None:
    found = active_ticks(data("0111010", "0000000", "1100000"), PUSH)
    assert list(zip(found.piece.tolist(), found.row.tolist(), strict=True)) == [(0, 1), (0, 2), (2, 0)]
    np.testing.assert_allclose(found.parent[:, 0], [0.1, 0.2, 200.0])
    np.testing.assert_allclose(found.parent_next[:, 0], [0.2, 0.3, 200.1])
    np.testing.assert_allclose(found.child[:, 0], [0.6, 0.7, 200.5])
    np.testing.assert_allclose(found.child_next[:, 0], [0.7, 0.8, 200.6])
    np.testing.assert_allclose(found.child_before[:, 0], [0.5, 0.6, 200.5], err_msg="or at the start, where none is")
    np.testing.assert_allclose(found.child[:, 1], 1.0 - found.child[:, 0])


@pytest.mark.parametrize(("flags", "onsets", "rows"), [("0101001", False, [0, 2, 5]), ("0110100", True, [0, 1, 3])])
def test_where_it_never_lasts_or_onsets_are_asked_for_those_count_that_end_active(
    flags: str, onsets: bool, rows: list[int]
) -> None:
    assert active_ticks(data(flags), PUSH, onsets=onsets).row.tolist() == rows
    assert active_ticks(data("0000"), PUSH).row.tolist() == []


def test_others_that_act_on_the_child_stand_beside_it() -> None:
    found = active_ticks(data("0111110", wind="0001100"), PUSH)
    assert list(found.others) == [WIND], "not what the hand does to others"
    before, after, on = found.others[WIND]
    np.testing.assert_allclose(before[:, 0], [0.1, 0.2, 0.3, 0.4])
    np.testing.assert_allclose(after[:, 0], [0.2, 0.3, 0.4, 0.5])
    assert on.tolist() == [False, True, True, False], "as it is at the tick's end"
    assert found.alone.tolist() == [True, False, False, True]
