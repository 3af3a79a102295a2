"""Demonstrations that are wrong in places: found, and said in one line with piece and rows."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from small_world import GRAPH

from ichain_drake.demonstrations import Demonstration
from ichain_drake.errors import InputError
from ichain_drake.graph import Interaction
from ichain_drake.learning import InteractionModel, findings, label_findings, learn_interactions
from ichain_drake.learning.data import Piece
from ichain_drake.learning.findings import _frozen, _repeats
from ichain_drake.state import StateSpace, Variable


def changed(pieces: list[Demonstration], k: int, first: int, last: int, edge: str) -> list[Demonstration]:
    """The pieces with the flags of an edge turned over in some rows of one."""
    table = pieces[k].table.copy()
    column = table.columns.get_loc(edge)
    table.iloc[first:last, column] = 1.0 - table.iloc[first:last, column]
    return [*pieces[:k], replace(pieces[k], table=table), *pieces[k + 1 :]]


def test_nothing_is_odd_about_clean_pieces(model: InteractionModel, demonstrations: list[Demonstration]) -> None:
    assert label_findings(demonstrations, GRAPH, model) == ()
    assert model.report()["findings"] == []


def test_a_copy_is_told_as_a_whole(model: InteractionModel, demonstrations: list[Demonstration]) -> None:
    (found,) = label_findings([*demonstrations, replace(demonstrations[1], name="again")], GRAPH, model)
    assert (found.piece, found.rows, found.edge) == ("again", (0, 0), "")
    assert f"every reading is that of piece {demonstrations[1].name}" in found.text


def test_a_few_wrong_flags_are_found(demonstrations: list[Demonstration]) -> None:
    model = learn_interactions(changed(demonstrations, 0, 3, 10, "valve->tap"), GRAPH)
    name = demonstrations[0].name
    assert any(f.startswith(f"piece {name} rows 3 to 9: valve->tap is flagged") for f in model.findings)


def test_an_inverted_edge_is_told(demonstrations: list[Demonstration]) -> None:
    pieces = demonstrations
    for k, piece in enumerate(pieces):
        pieces = changed(pieces, k, 0, len(piece), "hand->valve")
    try:
        said = " ".join(learn_interactions(pieces, GRAPH).findings)
    except InputError as error:  # where nothing else is told by them
        said = str(error)
    assert "hand->valve: its flags tell when it is inactive" in said


def test_a_frozen_feed_is_found(model: InteractionModel, demonstrations: list[Demonstration]) -> None:
    table = demonstrations[0].table.copy()
    columns = [c for c in table.columns if c.startswith("box.")]
    table.loc[table.index[5:35], columns] = table[columns].iloc[5].to_numpy()
    pieces = [replace(demonstrations[0], table=table), *demonstrations[1:]]
    found = [f for f in label_findings(pieces, GRAPH, model) if f.edge == "box"]
    assert [(f.piece, f.rows) for f in found] == [(demonstrations[0].name, (5, 35))]
    assert "frozen feed" in found[0].text


def test_a_reading_that_never_moves_is_told_of_no_piece_in_particular(
    model: InteractionModel, demonstrations: list[Demonstration]
) -> None:
    pieces = [replace(p, table=p.table.assign(**{"lamp.glow": 0.5})) for p in demonstrations]
    found = [f for f in label_findings(pieces, GRAPH, model) if f.edge == "lamp.glow"]
    assert [(f.piece, f.rows) for f in found] == [("", (0, 0))]
    assert found[0].text.startswith("lamp.glow: is 0.5 in every row of all pieces")


def test_readings_repeat_where_all_that_are_noisy_do_and_none_that_can_go_no_further_counts() -> None:
    states = np.array([[1.0, 5.0], [1.0, 5.0], [1.0, 6.0], [0.0, 6.0], [0.0, 6.0], [9.0, 6.0], [9.0, 6.0]])
    lower, upper = np.array([0.0, -np.inf]), np.array([9.0, np.inf])
    both, first = np.array([True, True]), np.array([True, False])
    assert _repeats(states, both, lower, upper).tolist() == [True, False, False, True, True, True]
    assert _repeats(states, first, lower, upper).tolist() == [True, True, False, False, False, False]


def frozen(rows: int, *stretches: tuple[int, int]) -> list[tuple[int, int]]:
    """Rows that are told of one piece in which a noisy reading stands still for these rows."""
    values = np.random.default_rng(0).normal(size=(rows, 1))
    for a, b in stretches:
        values[a:b] = values[a]
    space = StateSpace("thing", (Variable("x"),))
    piece = SimpleNamespace(states={"thing": values}, name="p")
    data = SimpleNamespace(spaces={"thing": space}, stacked=lambda obj: values, pieces=[piece])
    return [f.rows for f in _frozen(data, SimpleNamespace(noise={"thing": np.ones(1)}))]  # type: ignore[arg-type]


def test_a_feed_is_frozen_where_readings_repeat_more_often_than_they_do_elsewhere() -> None:
    """By the share of the other ticks in which they do; late in a piece as well as early."""
    assert frozen(60, (2, 11)) == [(2, 11)]
    assert frozen(60, (50, 59)) == [(50, 59)]
    assert frozen(61, (10, 14), (40, 44)) == []  # three ticks, as elsewhere: once in 15
    assert frozen(61, (10, 14)) == [(10, 14)]


@pytest.mark.parametrize(("better", "fatal"), [(-0.05, True), (0.05, False)])
def test_inverted_flags_are_fatal_where_they_tell_no_more_than_how_often_they_are_set(
    better: float, fatal: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    edge, piece = Interaction("hand", "box"), np.repeat(np.arange(4), 10)
    truth = np.arange(40) % 10 < 7
    usual = np.log(np.where(truth, 0.7, 0.3))
    said = {True: usual + better, False: usual + 1.0}  # by the flags as they are, and turned over
    choice = lambda flags, *rest: SimpleNamespace(  # noqa: E731
        choose=lambda candidates: (), left_out=lambda chosen: said[bool(flags[0])]
    )
    monkeypatch.setattr(findings, "status_candidates", lambda *args: ())
    monkeypatch.setattr(findings, "InputChoice", choice)
    data: Any = SimpleNamespace(flag=lambda e: truth, piece_index=lambda: piece)
    (found,) = findings._inverted(data, edge, SimpleNamespace(edges={}, noise={}))  # type: ignore[arg-type]
    assert found.fatal is fatal


@pytest.mark.parametrize(("rows", "told"), [(1, []), (2, [(8, 10)]), (3, [(8, 11)])])
def test_flags_that_are_wrong_in_a_row_are_told_but_one_alone_may_be_of_either_side(
    rows: int, told: list[tuple[int, int]]
) -> None:
    edge, truth = Interaction("hand", "box"), np.arange(20) >= 14
    wrong = truth ^ ((np.arange(20) >= 8) & (np.arange(20) < 8 + rows))
    sure = np.where(truth, 1.0 - 1e-6, 1e-6)
    status = SimpleNamespace(probability=lambda states, before: sure)
    piece = Piece("p", {"hand": np.zeros((20, 1)), "box": np.zeros((20, 1))}, {edge: wrong})
    data: Any = SimpleNamespace(pieces=[piece], graph=SimpleNamespace(parents=lambda obj: ("hand",)))
    model: Any = SimpleNamespace(edges={edge: SimpleNamespace(status=status)})
    assert [f.rows for f in findings._wrong_flags(data, edge, model)] == told
