"""One long recording is cut where time, the recorder or a reset breaks it."""

from dataclasses import replace

import bath_log
import numpy as np
import pandas as pd
import pytest

from ichain_drake.demonstrations import Demonstration
from ichain_drake.learning.discovery import cuts
from ichain_drake.learning.discovery.cuts import cut_pieces
from ichain_drake.runs.discovery_scores import joined
from ichain_drake.timing import TICK

PIECES = bath_log.pieces()
ENDS = np.cumsum([len(p) for p in PIECES]).tolist()
LOG = joined(PIECES, "log.csv")


def with_table(table: pd.DataFrame) -> Demonstration:
    return replace(LOG, table=table.reset_index(drop=True))


def test_a_long_recording_becomes_its_pieces() -> None:
    said: list[str] = []
    found = cut_pieces([LOG], bath_log.GRAPH, said.append)
    assert [c.row for c in found.cuts] == ENDS[:-1]
    assert [len(p) for p in found.pieces] == [len(p) for p in PIECES]
    assert [p.name for p in found.pieces[:2]] == ["log-part01.csv", "log-part02.csv"]
    assert found.pieces[1].first_line == LOG.first_line + ENDS[0]
    np.testing.assert_array_equal(found.pieces[1].table["lever.x"], PIECES[1].table["lever.x"])
    assert all(c.sure > 0.5 and c.why.startswith("reset: ") for c in found.cuts)
    assert said[0].startswith(f"log.csv row {ENDS[0]} ({ENDS[0] * TICK:.4g} s): reset: ")


def test_pieces_stay_as_they_are() -> None:
    found = cut_pieces(PIECES, bath_log.GRAPH)
    assert all(a is b for a, b in zip(found.pieces, PIECES, strict=True))
    assert not found.cuts


def test_gaps_and_a_clock_that_goes_back_are_cuts() -> None:
    time = TICK * np.arange(ENDS[0])
    time[20:] += 5.0
    time[40:] -= 30.0
    found = cut_pieces([with_table(LOG.table[: ENDS[0]].assign(time=time))], bath_log.GRAPH)
    assert [(c.row, c.why.split(" 2")[0][:9]) for c in found.cuts] == [(20, "gap of 5."), (40, "the clock")]
    assert found.cuts[1].why == f"the clock goes back {30.0 - TICK:.4g} s"
    assert [len(p) for p in found.pieces] == [20, 20, ENDS[0] - 40]


def test_what_was_written_twice_is_left_out_and_said() -> None:
    table = pd.concat([LOG.table[:40], LOG.table[15:40], LOG.table[40:]], ignore_index=True)
    table = table.assign(time=TICK * np.arange(len(table)))
    found = cut_pieces([with_table(table)], bath_log.GRAPH)
    assert [len(p) for p in found.pieces[:2]] == [40, ENDS[0] - 40]
    assert sum(map(len, found.pieces)) == len(LOG)
    assert found.left_out == ("log.csv rows 40 to 64 repeat those from row 15 on: left out",)
    assert [c.row for c in found.cuts] == [40, *(e + 25 for e in ENDS[:-1])]


def test_one_row_alone_is_no_piece() -> None:
    time = TICK * np.arange(ENDS[0])
    time[20:], time[21:] = time[20:] + 5.0, time[21:] + 10.0
    found = cut_pieces([with_table(LOG.table[: ENDS[0]].assign(time=time))], bath_log.GRAPH)
    assert [len(p) for p in found.pieces] == [20, ENDS[0] - 21]
    assert found.left_out == ("log.csv row 20 is no piece by itself: left out",)


@pytest.mark.parametrize(
    "change",
    [{"hand.x": np.nan}, {"hand.x": "far"}, {"time": 0.1 * np.arange(len(LOG))}, {"time": np.nan}],
    ids=["missing", "text", "rate", "times"],
)
def test_what_cannot_be_read_is_left_to_the_check(change: dict[str, object]) -> None:
    log = with_table(LOG.table[: ENDS[0]].assign(**{k: v[: ENDS[0]] if isinstance(v, np.ndarray) else v
                                                   for k, v in change.items()}))  # fmt: skip
    (left,) = cut_pieces([log], bath_log.GRAPH).pieces
    assert left is log


def test_flags_go_along() -> None:
    flags = pd.concat([p.table[["hand->lever"]] for p in PIECES], ignore_index=True)
    found = cut_pieces([with_table(LOG.table.assign(**flags))], bath_log.GRAPH)
    np.testing.assert_array_equal(found.pieces[2].table["hand->lever"], PIECES[2].table["hand->lever"])


@pytest.mark.parametrize("noise", [0.0, 1e-3])
def test_without_noise_equal_readings_are_no_repetition(noise: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """What does the same again comes by the same readings, where nothing blurs them."""
    monkeypatch.setattr(cuts, "column_noise", lambda logs, graph: dict.fromkeys(LOG.table.columns[1:], noise))
    table = pd.concat([LOG.table[:20], LOG.table[10:20], LOG.table[20:40]], ignore_index=True)
    found = cut_pieces([with_table(table.assign(time=TICK * np.arange(50)))], bath_log.GRAPH)
    assert len(found.left_out) == (noise > 0)
