"""Resampling by kinds: nothing is made up, and what was done is said."""

import numpy as np
import pandas as pd
import pytest

from ichain_drake.demonstrations import Demonstration, resample
from ichain_drake.errors import InputError
from ichain_drake.state import StateSpace, Variable
from ichain_drake.timing import TICK

SPACES = {
    "arm": StateSpace("arm", (Variable("x", "m"), Variable("grip", kind="binary"), Variable("level", kind="integer"))),
    "kart": StateSpace("kart", (Variable("h", "rad", -np.pi, np.pi, "angle"),)),
}


def log(times: np.ndarray) -> Demonstration:
    table = pd.DataFrame(
        {
            "time": times,
            "arm.x": 2.0 * times,
            "arm.grip": (times >= 1.0).astype(float),
            "arm.level": np.floor(times),
            "kart.h": (1.5 * times + np.pi) % (2 * np.pi) - np.pi,
            "command.x": np.floor(3 * times + 1e-9),
            "arm->kart": (times >= 1.0).astype(float),
        }
    )
    return Demonstration(table, {}, "log.csv")


def exact(piece: Demonstration, start: float) -> None:
    """Whether a piece has what the log was made of at its ticks."""
    t = start + TICK * np.arange(len(piece))
    np.testing.assert_allclose(piece.table["time"], TICK * np.arange(len(piece)), atol=1e-12)
    np.testing.assert_allclose(piece.table["arm.x"], 2 * t, atol=1e-9)
    turn = (1.5 * t + np.pi) % (2 * np.pi) - np.pi
    np.testing.assert_allclose(np.abs((piece.table["kart.h"] - turn + np.pi) % (2 * np.pi) - np.pi), 0, atol=1e-9)
    assert set(piece.table["arm.grip"]) <= {0.0, 1.0}
    assert (piece.table["arm.level"] == np.floor(piece.table["arm.level"])).all()


@pytest.mark.parametrize("rate", [30.0, 10.0, 7.3, 100.0])
def test_another_rate_by_kinds(rate: float) -> None:
    (piece,) = resample(log(np.arange(0, 9, 1 / rate)), SPACES).pieces
    exact(piece, 0.0)
    assert len(piece) == pytest.approx(27, abs=1)


def test_frames_give_the_ticks_themselves() -> None:
    """Every tenth row of thirty a second, to the last bit, flags and commands included."""
    frames = log(np.arange(0, 91) / 30)
    (piece,) = resample(frames, SPACES).pieces
    for name in ("arm.grip", "arm.level", "command.x", "arm->kart"):
        np.testing.assert_array_equal(piece.table[name], frames.table[name].to_numpy()[::10])


def test_jitter_of_a_log_at_the_period() -> None:
    rng = np.random.default_rng(3)
    times = TICK * np.arange(40) + rng.uniform(-0.03, 0.03, 40)
    (piece,) = resample(log(times), SPACES).pieces
    exact(piece, times[0])
    # A flag that comes up to 50 ms behind its tick belongs to it.
    assert abs(int(piece.table["arm->kart"].argmax()) - 3) <= 1


def test_nothing_is_interpolated_across_a_gap() -> None:
    times = np.arange(0, 12, 0.05)
    times = times[(times < 3.0) | (times > 5.5)]
    found = resample(log(times), SPACES)
    first, second = found.pieces
    exact(first, 0.0)
    exact(second, times[times > 5][0])
    assert [p.name for p in found.pieces] == ["log-part1.csv", "log-part2.csv"]
    assert len(first) + len(second) == 9 + 20
    assert "in 2 pieces; split at gaps: 2.667 to 5.55 s" in found.notes[0]


def test_one_lost_row_at_the_period_is_a_gap() -> None:
    times = np.delete(TICK * np.arange(20), 8)
    assert [len(p) for p in resample(log(times), SPACES).pieces] == [8, 11]


def test_columns_of_several_rates() -> None:
    times = np.arange(0, 6, 1 / 30)
    table = log(times).table
    table.loc[np.arange(len(times)) % 3 != 0, "kart.h"] = np.nan
    table.loc[np.arange(len(times)) % 30 != 0, "arm.level"] = np.nan
    found = resample(Demonstration(table, {}, "log.csv"), SPACES)
    (piece,) = found.pieces
    exact(piece, 0.0)
    assert piece.table["time"].iloc[-1] <= 5.0  # the slowest column ends there
    assert "arm.level come every 1 s, slower than 0.3333 s" in found.notes[1]


def test_a_clock_that_jumps_back_splits() -> None:
    times = np.concatenate([np.arange(10, 14, 0.1), np.arange(2, 5, 0.1)])
    found = resample(log(times), SPACES)
    assert len(found.pieces) == 2
    assert "its clock jumps back 1 times, it is split there" in found.notes[0]
    exact(found.pieces[1], 2.0)


def test_a_clock_that_jumps_forward_is_a_gap_and_doubled_times_count_once() -> None:
    times = np.concatenate([np.arange(0, 3, 0.1), np.arange(1e6, 1e6 + 3, 0.1)])
    assert [len(p) for p in resample(log(np.repeat(times, 2)), SPACES).pieces] == [9, 9]


def test_what_can_not_be_resampled() -> None:
    with pytest.raises(InputError, match=r"log\.csv: it records every 1 s, and 0\.3333 s is needed; .*3 Hz or more"):
        resample(log(np.arange(0, 9, 1.0)), SPACES)
    with pytest.raises(InputError, match="line 3, column time: not a finite number"):
        resample(log(np.array([0, np.nan, 0.2])), SPACES)
    with pytest.raises(InputError, match="a period of 0 s; give a positive one"):
        resample(log(np.arange(0, 9, 0.1)), SPACES, 0.0)
    with pytest.raises(InputError, match="it needs one column time"):
        resample(Demonstration(log(np.arange(3.0)).table.drop(columns="time")), SPACES)
    assert resample(log(np.array([0.0, 0.1])), SPACES).pieces == ()


def test_another_period() -> None:
    (piece,) = resample(log(np.arange(0, 4, 0.02)), SPACES, 0.1).pieces
    np.testing.assert_allclose(piece.table["arm.x"], 0.2 * np.arange(len(piece)), atol=1e-9)
