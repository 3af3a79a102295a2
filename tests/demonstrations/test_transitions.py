"""Transitions: pairs of successive rows while an interaction is active, never across a gap."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ichain_drake.demonstrations import Demonstration, Transitions, collect_commands, collect_transitions
from ichain_drake.errors import InputError
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.state import StateSpace, Variable
from ichain_drake.timing import TICK

SPACE = StateSpace("thing", (Variable("a"),))
GRAPH = InteractionGraph({"r": SPACE, "c": SPACE}, ["r->c"])
EDGE = Interaction("r", "c")


def piece(flags: list[int] | None, first: float = 0.0, rows: int = 5, constant: bool = False) -> Demonstration:
    """The child counts rows from `first` (or stays there); the parent is 100 more."""
    count = rows if flags is None else len(flags)
    child = np.full(count, first) if constant else first + np.arange(count)
    data = {"time": TICK * np.arange(count), "r.a": 100.0 + first + np.arange(count), "c.a": child}
    return Demonstration(pd.DataFrame(data if flags is None else {**data, "r->c": flags}))


def collect(*pieces: Demonstration, limit: int | None = None) -> Transitions:
    return collect_transitions(pieces, GRAPH, EDGE, limit)


def test_rows_pair_a_state_with_the_next_one() -> None:
    data = collect(piece(None))
    assert len(data) == 4
    assert data.child[:, 0].tolist() == [0, 1, 2, 3]
    assert data.child_next[:, 0].tolist() == [1, 2, 3, 4]
    assert data.parent[:, 0].tolist() == [100, 101, 102, 103]
    assert data.parent_next[:, 0].tolist() == [101, 102, 103, 104]


def test_only_ticks_with_the_interaction_active_from_start_to_end() -> None:
    data = collect(piece([1, 1, 0, 1, 1, 1]))
    assert data.child[:, 0].tolist() == [0, 3, 4]
    assert data.row.tolist() == [0, 3, 4]


def test_pieces_are_kept_apart_and_those_without_both_objects_passed_over() -> None:
    lone = Demonstration(piece(None).table.drop(columns="r.a"))
    data = collect(piece(None), lone, piece(None, 50.0))
    assert data.piece.tolist() == [0] * 4 + [2] * 4
    assert collect(piece(None), piece(None, 50.0), limit=5).piece.tolist() == [0] * 4 + [1]


@given(
    flags=st.lists(st.lists(st.integers(0, 1), min_size=2, max_size=12), min_size=1, max_size=4),
    ticks=st.integers(1, 5),
    constant=st.booleans(),
)
def test_looking_ahead_crosses_neither_gaps_nor_pieces(flags: list[list[int]], ticks: int, constant: bool) -> None:
    """Against a plain loop; also for a child that stands still, in the same state on both sides of a gap."""
    pieces = [piece(f, 1000.0 * i, constant=constant) for i, f in enumerate(flags)]
    expected = [
        (i, row, all(f[row : row + ticks + 1]) and row + ticks < len(f))
        for i, f in enumerate(flags)
        for row in range(len(f) - 1)
        if f[row] and f[row + 1]
    ]
    if not expected:
        with pytest.raises(InputError, match="r->c: no demonstration holds r and c with the interaction active"):
            collect(*pieces)
        return
    data = collect(*pieces)
    later, usable = data.child_ahead(ticks)
    assert usable.tolist() == [ok for _, _, ok in expected]
    for i, row, ok in expected:
        if ok:
            k = next(k for k in range(len(data)) if (data.piece[k], data.row[k]) == (i, row))
            assert later[k, 0] == pieces[i].table["c.a"][row + ticks]


def test_rows_that_were_taken_out_leave_gaps() -> None:
    data = collect(piece(None, rows=7)).take(np.array([0, 1, 3, 4]))
    assert data.child_ahead(2)[1].tolist() == [True, False, True, False]


def test_commands_belong_to_the_state_at_the_end_of_their_tick() -> None:
    with_commands = piece(None).table.assign(**{"command.a": [1.0, 2.0, 3.0, 4.0, 9.0]})
    collected = collect_commands([piece(None), Demonstration(with_commands)], GRAPH)
    assert collected is not None
    commands, states = collected
    assert commands[:, 0].tolist() == [1, 2, 3, 4]
    assert states[:, 0].tolist() == [101, 102, 103, 104]
    assert collect_commands([piece(None)], GRAPH) is None
