"""Flags out of states: none, some or all known; what can't be read or told."""

from dataclasses import replace

import bath_log
import numpy as np
import pandas as pd
import pytest

from ichain_drake.demonstrations import Demonstration
from ichain_drake.errors import InputError
from ichain_drake.graph import Interaction
from ichain_drake.learning import f1, learn_interactions
from ichain_drake.learning.discovery.labels import Labelled, _complete, known_flags, label_pieces
from ichain_drake.learning.discovery.log import RawPiece
from ichain_drake.learning.discovery.search import FoundEdge
from ichain_drake.learning.discovery.structure import Rival
from ichain_drake.timing import TICK

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


def small(name: str, rows: int, **flags: list[float]) -> Demonstration:
    table = pd.DataFrame({"time": TICK * np.arange(rows), "hand.x": np.arange(float(rows))})
    return Demonstration(table.assign(**{k.replace("_", "->"): v for k, v in flags.items()}), {}, name)


def found_edge(edge: Interaction, on: dict[str, np.ndarray], open_: dict[str, np.ndarray]) -> FoundEdge:
    return FoundEdge(edge, 30.0, 0.9, 12, ("moves it",), (Rival("fan", 0.2),), on, open_, False)


PUSH, WIND = Interaction("hand", "box"), Interaction("fan", "box")
NAN = float("nan")


def test_what_is_known_stays_and_the_rest_is_the_likeliest_with_what_nothing_shows_left_open() -> None:
    piece = small("p", 4, hand_box=[1.0, NAN, 0.0, NAN], old_edge=[1.0] * 4)
    raw = RawPiece("p", {}, {PUSH: np.array([1.0, NAN, 0.0, NAN])})
    on, nothing = np.array([False, True, True, False]), np.array([True, True, False, False])
    inferred = {PUSH: found_edge(PUSH, {"p": on}, {"p": nothing})}
    done = _complete(piece, raw, [PUSH, WIND], inferred)
    assert [c for c in done.table.columns if "->" in c] == [PUSH.name, WIND.name]
    assert done.table[PUSH.name].tolist() == [1.0, 1.0, 0.0, 0.0]
    assert done.table[WIND.name].tolist() == [0.0] * 4, "what nobody saw is inactive"
    assert {n: rows.tolist() for n, rows in done.open.items()} == {PUSH.name: [False, True, False, False]}
    other = _complete(small("q", 4), RawPiece("q", {}, {}), [PUSH], inferred)
    assert (other.table[PUSH.name].sum(), other.open[PUSH.name].all()) == (0.0, True), (
        "of a piece that was not looked at"
    )


def test_a_flag_is_known_or_it_is_not() -> None:
    assert known_flags(small("p", 2), PUSH) is None
    assert known_flags(small("p", 2, hand_box=[NAN, NAN]), PUSH) is None
    np.testing.assert_array_equal(known_flags(small("p", 2, hand_box=[NAN, 1.0]), PUSH), [NAN, 1.0])
    for odd in (0.5, 2.0, -1.0):
        with pytest.raises(InputError, match=rf"p: line 3, column hand->box: {odd:g} given"):
            known_flags(small("p", 3, hand_box=[0.0, odd, NAN]), PUSH)


def test_a_person_is_asked_about_the_longest_stretches_that_stay_open() -> None:
    def open_piece(name: str, *stretches: tuple[int, int]) -> Demonstration:
        rows = np.zeros(40, dtype=bool)
        for a, b in stretches:
            rows[a:b] = True
        return replace(small(name, 40), open={PUSH.name: rows})

    pieces = (open_piece("a", (0, 6), (10, 31)), open_piece("b", (5, 14), (20, 21)), small("c", 40))
    found = found_edge(PUSH, {}, {})
    done = Labelled(pieces, bath_log.GRAPH, (found,), 120, (WIND,))
    assert done.open_rows(PUSH) == 6 + 21 + 9 + 1
    assert done.open_rows(WIND) == 0
    asked = done.helpful()
    assert asked[:3] == [
        "a rows 10 to 30 (7 s): is hand->box active?", "b rows 5 to 13 (3 s): is hand->box active?",
        "a rows 0 to 5 (2 s): is hand->box active?",
    ]  # fmt: skip
    assert done.lines()[:2] == [
        "hand->box: inferred, sure by 0.900; shows in 12 of 120 rows, 37 stay open; or it is fan (0.20)",
        "fan->box: nothing shows that it acts; it is left out",
    ]
    assert done.lines()[2:] == [f"a label would help: {text}" for text in asked]
    report = done.report()
    assert report["edges"]["hand->box"] == {
        "confidence": 0.9, "gain_per_row": 0.25, "shows_in_rows": 12, "has_a_say_only": False, "does": ["moves it"],
        "rivals": {"fan": 0.2}, "open_rows": 37,
    }  # fmt: skip
    assert (report["rows"], report["not_shown"]) == (120, ["fan->box"])
