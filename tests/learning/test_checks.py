"""Data that can't be learned from: one line that names piece, edge and remedy."""

from dataclasses import replace

import numpy as np
import pytest
from small_world import GRAPH

from ichain_drake.demonstrations import Demonstration
from ichain_drake.errors import InputError
from ichain_drake.graph import InteractionGraph
from ichain_drake.learning.checks import check_contradictions, check_flags
from ichain_drake.learning.data import collect
from ichain_drake.state import StateSpace, Variable


def changed(pieces: list[Demonstration], k: int, **columns: object) -> list[Demonstration]:
    """The pieces with columns of one replaced; None drops a column."""
    table = pieces[k].table.copy()
    for name, value in columns.items():
        if value is None:
            table = table.drop(columns=name)
        else:
            table[name] = value
    return [*pieces[:k], replace(pieces[k], table=table), *pieces[k + 1 :]]


def refused(pieces: list[Demonstration], message: str) -> None:
    with pytest.raises(InputError, match=message) as caught:
        collect(pieces, GRAPH)
    assert "\n" not in str(caught.value)


def test_no_pieces() -> None:
    refused([], "no demonstration piece")


def test_two_pieces_of_one_name(demonstrations: list[Demonstration]) -> None:
    refused([demonstrations[0], demonstrations[0]], "piece piece_0: two pieces have this name")


def test_a_piece_without_flags(demonstrations: list[Demonstration]) -> None:
    drop = {e.name: None for e in GRAPH.interactions}
    refused(changed(demonstrations, 2, **drop), "piece piece_2: has no active flags; add a column hand->box")


def test_a_piece_without_one_flag(demonstrations: list[Demonstration]) -> None:
    pieces = changed(demonstrations, 1, **{"valve->tap": None})
    refused(pieces, "piece piece_1: lacks some active flags; add a column valve->tap")


def test_flags_for_an_edge_that_the_graph_lacks(demonstrations: list[Demonstration]) -> None:
    pieces = changed(demonstrations, 1, **{"lamp->box": 0.0})
    refused(pieces, "piece piece_1: flags for lamp->box, an edge that the graph lacks; remove the column")


def test_an_edge_that_is_never_active(demonstrations: list[Demonstration]) -> None:
    pieces = demonstrations
    for k in range(len(pieces)):
        pieces = changed(pieces, k, **{"valve->lamp": 0.0})
    refused(pieces, "valve->lamp: never active in any of the 9 pieces.*; record a piece")


@pytest.mark.parametrize(("count", "listed"), [(6, "a, b, c, d, e, f"), (7, "a, b, c, d, e, f, ..."), (1, "a")])
def test_of_many_pieces_the_first_six_are_named(count: int, listed: str) -> None:
    edge, names = GRAPH.interactions[0], "abcdefg"[:count]
    flags = [np.zeros(3, dtype=bool)] * count
    with pytest.raises(InputError, match=rf"never active in any of the {count} pieces \({listed}\); record"):
        check_flags(names, {edge: flags})
    check_flags(names, {edge: [*flags[1:], np.array([False, True, False])]})


def test_a_copy_is_left_out(demonstrations: list[Demonstration]) -> None:
    data = collect([*demonstrations, replace(demonstrations[1], name="again")], GRAPH)
    assert len(data.pieces) == len(demonstrations)
    assert data.copies == {"again": demonstrations[1].name}


def test_contradictory_flags(demonstrations: list[Demonstration]) -> None:
    again = replace(demonstrations[4], table=demonstrations[4].table.copy(), name="again")
    again.table["valve->tap"] = 1.0 - again.table["valve->tap"]
    message = r"valve->tap: contradictory flags: piece \w+ line \d+ says active, piece \w+ line \d+ inactive.*correct"
    refused([*demonstrations, again], message)


def test_two_periods(demonstrations: list[Demonstration]) -> None:
    pieces = changed(demonstrations, 3, time=0.5 * np.arange(len(demonstrations[3])))
    refused(pieces, "piece piece_3: its period is 0.5 s, but that of piece_0 is 0.3333 s; .*resample")


def test_a_piece_without_an_object(demonstrations: list[Demonstration]) -> None:
    refused(changed(demonstrations, 3, **{"lamp.glow": None}), "piece_3: column lamp.glow is missing")


def test_contradictory_flags_are_named_by_the_lines_of_their_files() -> None:
    """Line 1 is the header, so that row 0 is line 2."""
    graph = InteractionGraph({n: StateSpace(n, (Variable("x"),)) for n in ("hand", "cup")}, ["hand->cup"])
    edge = graph.interactions[0]
    hand = [np.arange(5.0)[:, None], np.arange(3.0, 9.0)[::-1, None]]
    states = {"hand": hand, "cup": [np.zeros((5, 1)), np.zeros((6, 1))]}
    on = [np.arange(5) == 4, np.zeros(6, dtype=bool)]
    with pytest.raises(InputError, match="hand->cup: .*: piece a line 6 says active, piece b line 6 inactive"):
        check_contradictions(["a", "b"], {edge: on}, states, graph)
    check_contradictions(["a", "b"], {edge: [on[0], np.arange(6) == 4]}, states, graph)
