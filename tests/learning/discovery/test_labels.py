"""Flags out of states: none, some or all known; what can't be read or told."""

from dataclasses import replace

import bath_log
import numpy as np
import pytest

from ichain_drake.demonstrations import Demonstration
from ichain_drake.errors import InputError
from ichain_drake.graph import Interaction
from ichain_drake.learning import f1, learn_interactions
from ichain_drake.learning.discovery.labels import Labelled, label_pieces

HAND, TAP = (Interaction.parse(e.name) for e in bath_log.GRAPH.interactions)


def bare(pieces: list[Demonstration]) -> list[Demonstration]:
    return [replace(p, table=p.table.drop(columns=[HAND.name, TAP.name])) for p in pieces]


def flag(pieces: list[Demonstration] | tuple[Demonstration, ...], edge: Interaction) -> np.ndarray:
    return np.concatenate([p.table[edge.name].to_numpy() > 0.5 for p in pieces])


@pytest.fixture(scope="module")
def true() -> list[Demonstration]:
    return bath_log.pieces()


@pytest.fixture(scope="module")
def labelled(true: list[Demonstration]) -> Labelled:
    return label_pieces(bare(true), bath_log.GRAPH)


@pytest.mark.parametrize("edge", [HAND, TAP])
def test_flags_are_right_where_an_effect_shows(
    edge: Interaction, true: list[Demonstration], labelled: Labelled
) -> None:
    shown = ~np.concatenate([p.open[edge.name] for p in labelled.pieces])
    assert shown.sum() > 20
    assert f1(flag(true, edge)[shown], flag(labelled.pieces, edge)[shown]) >= 0.97


def test_it_says_in_how_many_rows_nothing_shows(true: list[Demonstration], labelled: Labelled) -> None:
    report = labelled.report()
    assert report["rows"] == sum(map(len, true))
    assert 0 < report["edges"][HAND.name]["open_rows"] == labelled.open_rows(HAND) < report["rows"]
    assert any("rows" in text and "active?" in text for text in report["labels_that_would_help"])


def test_whole_flags_are_taken_as_they_are(true: list[Demonstration]) -> None:
    assert label_pieces(true, bath_log.GRAPH).pieces == tuple(true)


def test_known_intervals_are_kept(true: list[Demonstration]) -> None:
    some = [p.table[HAND.name].where(p.table.index < 6) for p in true]
    some[0][:] = np.nan
    some[0][4:9] = 1.0  # whatever it looks like
    pieces = [replace(p, table=p.table.assign(**{HAND.name: s})) for p, s in zip(true, some, strict=True)]
    found = label_pieces(pieces, bath_log.GRAPH)
    assert found.pieces[0].table[HAND.name][4:9].all()
    assert (found.pieces[1].table[HAND.name][:6] == true[1].table[HAND.name][:6]).all()
    assert (flag(found.pieces, TAP) == flag(true, TAP)).all()  # that one was known
    assert not found.pieces[0].open[HAND.name][4:9].any()


def test_models_are_learned_without_flags(true: list[Demonstration]) -> None:
    model = learn_interactions(bare(true), bath_log.GRAPH, unlabelled=True)
    states = {n: np.vstack([p.states(n, s) for p in true]) for n, s in bath_log.GRAPH.objects.items()}
    assert f1(flag(true, HAND), model.edges[HAND].status.active(states)) > 0.8
    assert [e.variable for e in model.edges[HAND].effects] == [0]


def test_without_the_option_the_refusal_names_it(true: list[Demonstration]) -> None:
    with pytest.raises(InputError, match="has no active flags; .* --unlabelled"):
        learn_interactions(bare(true), bath_log.GRAPH)


def test_a_flag_that_is_none_is_refused(true: list[Demonstration]) -> None:
    odd = replace(true[0], table=true[0].table.assign(**{HAND.name: 0.5}))
    with pytest.raises(InputError, match=r"piece_0: line 2, column hand->lever: 0.5 given.*or empty"):
        label_pieces([odd, *true[1:]], bath_log.GRAPH)


def test_an_object_on_which_nothing_acts_is_named(true: list[Demonstration]) -> None:
    rng = np.random.default_rng(0)
    still = [
        replace(p, table=p.table.assign(**{"tank.level": 0.5 + 1e-3 * rng.standard_normal(len(p))})) for p in bare(true)
    ]
    with pytest.raises(InputError, match="lever->tank: the pieces don't show that anything acts on tank; record"):
        label_pieces(still, bath_log.GRAPH)
