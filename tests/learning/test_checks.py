"""Data that can't be learned from: one line that names piece, edge and remedy."""

import re
from dataclasses import replace

import numpy as np
import pytest
from small_world import GRAPH

from ichain_drake.demonstrations import Demonstration
from ichain_drake.errors import InputError
from ichain_drake.graph import Interaction, InteractionGraph
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


@pytest.mark.parametrize(
    ("count", "listed"), [(1, "p0"), (6, "p0, p1, p2, p3, p4, p5"), (7, "p0, p1, p2, p3, p4, p5, ...")]
)
def test_up_to_six_pieces_are_named(count: int, listed: str) -> None:
    edge, names = GRAPH.interactions[0], [f"p{k}" for k in range(count)]
    with pytest.raises(InputError, match=re.escape(f"in any of the {count} pieces ({listed});")):
        check_flags(names, {edge: [np.zeros(3, dtype=bool)] * count})
    check_flags(names, {edge: [np.zeros(3, dtype=bool)] * (count - 1) + [np.array([False, True, False])]})


def test_lines_that_contradict_each_other_are_counted_as_in_their_files() -> None:
    """The header is line 1; what a third object does makes no difference to the edge, and other states none at all."""
    spaces = {n: StateSpace(n, (Variable("x"),)) for n in "abc"}
    graph, edge = InteractionGraph(spaces, ["a->b", "a->c"]), Interaction("a", "b")
    states = {
        "a": [np.array([[0.0], [1.0], [2.0]]), np.array([[5.0], [6.0], [7.0], [1.0]])],
        "b": [np.zeros((3, 1)), np.zeros((4, 1))],
        "c": [np.ones((3, 1)), np.full((4, 1), 9.0)],
    }
    flags = {e: [np.array([True, True, False]), np.array([True, False, True, False])] for e in graph.interactions}
    message = "a->b: contradictory flags: piece one line 3 says active, piece two line 5 inactive, in the same state"
    with pytest.raises(InputError, match=message):
        check_contradictions(["one", "two"], flags, states, graph)
    flags[edge][1][3] = True
    check_contradictions(["one", "two"], flags, states, graph)
