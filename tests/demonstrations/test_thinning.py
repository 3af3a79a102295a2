"""Of more rows than are learned from, stretches are kept that show every switch; of fewer, all."""

import numpy as np
import pandas as pd
import pytest

from ichain_drake.demonstrations import Demonstration
from ichain_drake.demonstrations.thinning import Bound, Outliner, chosen_rows, outline, stretch, thinned
from ichain_drake.graph import InteractionGraph
from ichain_drake.state import StateSpace, Variable

SPACE = StateSpace("thing", (Variable("x", "m"),))
GRAPH = InteractionGraph({"hand": SPACE, "box": SPACE, "lid": SPACE}, ["hand->box", "box->lid"])


def log(rows: int, switches: dict[str, list[int]], name: str = "log") -> Demonstration:
    """A recording whose flags change at some rows; x is the row."""
    table = {"time": np.arange(rows) / 3.0, **{f"{o}.x": np.arange(rows, dtype=float) for o in GRAPH.objects}}
    for edge, at in switches.items():
        steps = np.zeros(rows, dtype=int)
        steps[at] = 1
        table[edge] = np.cumsum(steps) % 2
    return Demonstration(pd.DataFrame(table), {}, name)


def test_few_rows_are_the_very_pieces() -> None:
    pieces = [log(90, {"hand->box": [3], "box->lid": [5]}), log(10, {"hand->box": [3], "box->lid": [5]})]
    kept = thinned(pieces, GRAPH, Bound(100, 20))
    assert all(a is b for a, b in zip(kept, pieces, strict=True))


def test_a_rare_switch_is_kept_and_the_bound_holds() -> None:
    piece = log(10_000, {"hand->box": list(range(50, 10_000, 100)), "box->lid": [7_777, 7_790]})
    kept = thinned([piece], GRAPH, Bound(1_000, 50))
    assert sum(map(len, kept)) <= 1_000
    assert sum(map(len, kept)) > 900
    rows = np.concatenate([k.table["hand.x"].to_numpy() for k in kept])
    assert {7_777.0, 7_790.0} <= set(rows)
    assert rows.min() < 1_000  # evenly from all of it
    assert rows.max() > 9_000
    assert sum(k.table["box->lid"].diff().abs().sum() for k in kept) == 2  # noqa: PLR2004 - on and off


def test_stretches_are_successive_rows_and_say_where_they_are_from() -> None:
    piece = log(1_000, {"hand->box": [500], "box->lid": [510]}, "long.csv")
    for part in thinned([piece], GRAPH, Bound(300, 50)):
        first = int(part.table["hand.x"].iloc[0])
        assert part.name == f"long.csv rows {first} to {first + len(part) - 1}"
        assert part.first_line == piece.first_line + first
        assert np.array_equal(np.diff(part.table["hand.x"]), np.ones(len(part) - 1))
        assert list(part.table.index) == list(range(len(part)))


def test_pieces_without_flags_count_for_what_they_hold() -> None:
    """Of a chain each piece may show one link; those that show a rare one are not lost among the others."""
    one = log(100, {})
    other = [Demonstration(log(100, {}).table[["time", "hand.x", "box.x"]], {}, f"p{k}") for k in range(200)]
    kept = thinned([*other, one], GRAPH, Bound(1_000, 100))
    assert kept[-1] is one


def test_open_rows_go_along() -> None:
    piece = log(300, {"hand->box": [100], "box->lid": [110]})
    marked = Demonstration(piece.table, {}, "p", open={"hand->box": np.arange(300) > 150})
    assert stretch(marked, 140, 160).open["hand->box"].tolist() == [False] * 11 + [True] * 9


@pytest.mark.parametrize("rows", [1, 24, 25, 74, 75, 1000])
def test_stretches_cover_a_recording(rows: int) -> None:
    found = outline(log(rows, {"hand->box": []}), GRAPH, 50)
    assert found.sizes.sum() == rows
    assert (found.sizes > 0).all()
    assert chosen_rows([found], rows) == [[(0, rows)]]


@pytest.mark.parametrize("part", [1, 7, 50, 199])
def test_an_outline_is_the_same_however_a_recording_is_read(part: int) -> None:
    piece = log(331, {"hand->box": [50, 99, 100, 200], "box->lid": []})
    by_parts, whole = Outliner(GRAPH, 50), outline(piece, GRAPH, 50)
    for first in range(0, 331, part):
        by_parts.add(piece.table.iloc[first : first + part])
    found = by_parts.outline(lambda name: True)
    assert np.array_equal(found.starts, whole.starts)
    assert np.array_equal(found.tells, whole.tells)
    assert whole.tells[:, 0].tolist() == [False, True, True, False, True, False, False]
