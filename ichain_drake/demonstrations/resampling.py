"""Logs of another rate, jittered, with gaps or of several rates, taken to the period that is learned at."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import PurePath

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from ichain_drake.demonstrations.checks import TIME_TOLERANCE
from ichain_drake.demonstrations.columns import COMMAND, TIME, as_numbers, column
from ichain_drake.demonstrations.table import Demonstration
from ichain_drake.errors import InputError
from ichain_drake.state import FloatArray, StateSpace, wrap_angle
from ichain_drake.timing import TICK

GAP = 1.5
"""Readings further apart are a gap [of the longer of their own usual distance and the period]: one that is lost where
they come at the period, several of a quick sensor."""

_LATE = 0.15
"""What is held (a flag, a command, a level) counts at a tick up to so much after it [periods]: 50 ms at 3 Hz, more than
clocks jitter, less than any frame of 10 Hz."""

_MOST_ROWS = 10**6
"""More ticks than anybody recorded: four days at 3 Hz. A clock that is wrong gives more."""


@dataclass(frozen=True)
class Resampled:
    """What became of a piece.

    Attributes:
        pieces: at the period, in order of time; none where nothing of it was long enough.
        notes: what was done, a line each.
    """

    pieces: tuple[Demonstration, ...]
    notes: tuple[str, ...]


def is_at(piece: Demonstration, period: float) -> bool:
    """Whether a piece's rows are at a period already, each of them whole."""
    if list(piece.table.columns).count(TIME) != 1:
        return True  # which is told later
    steps = np.diff(as_numbers(piece.table[TIME]))
    whole = all(np.isfinite(as_numbers(piece.table.iloc[:, i])).all() for i in range(piece.table.shape[1]))
    return whole and bool((np.abs(steps - period) <= TIME_TOLERANCE * period).all())


def resample(piece: Demonstration, spaces: Mapping[str, StateSpace], period: float = TICK) -> Resampled:
    """Take a log to a period, each column by its variable's kind.

    Reals are interpolated, angles by the short way round; binaries, integers, flags and commands keep their last value.
    Nothing is interpolated across a gap: the piece is split there, and where its clock jumps. Columns may have rates of
    their own, with empty cells (NaN) between their readings. Nothing is averaged: a reading's noise stays what it is.

    Args:
        piece: the log, with a column `time` [s].
        spaces: state space of each object; columns of others are taken as reals.
        period: wanted [s].

    Returns:
        The pieces, named after the log (`<name>-part2` and so on where there are several), and what was done.

    Raises:
        InputError: without times, on a period that isn't positive, or if every column is slower than the period.
    """
    if not (np.isfinite(period) and period > 0):
        raise InputError(f"{piece.name}: a period of {period:g} s; give a positive one")
    if list(piece.table.columns).count(TIME) != 1:
        raise InputError(f"{piece.name}: it needs one column {TIME}, the time of each row in seconds")
    times = as_numbers(piece.table[TIME])
    if not np.isfinite(times).all():
        row = int(np.argmax(~np.isfinite(times)))
        raise InputError(f"{piece.name}: line {piece.first_line + row}, column {TIME}: not a finite number")
    names = [str(c) for c in piece.table.columns if c != TIME]
    if len(set(names)) < len(names):
        twice = next(n for n in names if names.count(n) > 1)
        raise InputError(f"{piece.name}: column {twice} appears twice; remove one")
    kinds = _kinds(names, spaces)
    values = {name: as_numbers(piece.table[name]) for name in names}
    usual = {name: _usual(times[np.isfinite(v)]) for name, v in values.items()}
    known = [u for u in usual.values() if np.isfinite(u)]
    if not known or min(known) > GAP * period:
        what = f"every {min(known):.4g} s" if known else "hardly anything"
        raise InputError(
            f"{piece.name}: it records {what}, and {period:.4g} s is needed; what lies between can't be made up: "
            f"record at {1 / period:.3g} Hz or more"
        )
    jumps = np.flatnonzero(np.diff(times) < 0) + 1
    stretches: list[tuple[FloatArray, dict[str, FloatArray]]] = []
    lost = 0
    for rows in np.split(np.arange(len(times)), jumps):
        for begin, end in _covered(times[rows], {n: v[rows] for n, v in values.items()}, usual, period):
            count = int((end - begin) / period * (1 + 1e-9)) + 1
            if count > _MOST_ROWS:
                raise InputError(f"{piece.name}: {end - begin:.4g} s are over {_MOST_ROWS} rows; mend its times")
            if count < 2:
                lost += 1
                continue
            at: FloatArray = begin + period * np.arange(count, dtype=np.float64)
            data = {n: _values(times[rows], v[rows], at, kinds[n], period) for n, v in values.items()}
            stretches.append((at, data))
    pieces = tuple(_piece(piece, i, len(stretches), period, data) for i, (_, data) in enumerate(stretches))
    return Resampled(pieces, tuple(_notes(piece, times, usual, stretches, period, len(jumps), lost)))


def _kinds(names: list[str], spaces: Mapping[str, StateSpace]) -> dict[str, str]:
    declared = {column(o, v.name): v.kind for o, space in spaces.items() for v in space.variables}
    held = [n for n in names if "->" in n or n.startswith(f"{COMMAND}.")]
    return {n: "held" if n in held else declared.get(n, "real") for n in names}


def _usual(times: FloatArray) -> float:
    """Median time between a column's readings [s]; NaN for fewer than two."""
    steps = np.diff(times)
    return float(np.median(steps[steps > 0])) if (steps > 0).any() else np.nan


def _covered(
    times: FloatArray, values: Mapping[str, FloatArray], usual: Mapping[str, float], period: float
) -> list[tuple[float, float]]:
    """Stretches of time in which no column has a gap."""
    covered: list[tuple[float, float]] = [(times[0], times[-1])]
    for name, value in values.items():
        own = times[np.isfinite(value)]
        if len(own) == 0:
            return []
        limit = GAP * max(period, usual[name]) if np.isfinite(usual[name]) else period
        breaks = np.flatnonzero(np.diff(own) > limit)
        starts, ends = np.concatenate([own[:1], own[breaks + 1]]), np.concatenate([own[breaks], own[-1:]])
        covered = _both(covered, list(zip(starts, ends, strict=True)))
    return covered


def _both(first: list[tuple[float, float]], second: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """What two ascending lists of stretches have in common."""
    out, i, j = [], 0, 0
    while i < len(first) and j < len(second):
        begin, end = max(first[i][0], second[j][0]), min(first[i][1], second[j][1])
        if end > begin:
            out.append((begin, end))
        if first[i][1] < second[j][1]:
            i += 1
        else:
            j += 1
    return out


def _values(times: FloatArray, values: FloatArray, at: FloatArray, kind: str, period: float) -> FloatArray:
    there = np.isfinite(values)
    own, known = times[there], values[there]
    later = np.append(np.diff(own) > 0, True)  # of doubled times the last counts
    own, known = own[later], known[later]
    if kind in ("held", "binary", "integer"):
        last: NDArray[np.intp] = np.searchsorted(own, at + _LATE * period, side="right") - 1
        return np.asarray(known[np.maximum(last, 0)])
    if kind == "angle":
        return wrap_angle(np.interp(at, own, np.unwrap(known)))
    return np.interp(at, own, known)


def _piece(piece: Demonstration, index: int, count: int, period: float, data: dict[str, FloatArray]) -> Demonstration:
    rows = len(next(iter(data.values())))
    table = pd.DataFrame({TIME: period * np.arange(rows), **data})[list(piece.table.columns)]
    path = PurePath(piece.name)
    name = piece.name if count == 1 else f"{path.stem}-part{index + 1}{path.suffix}"
    return replace(piece, table=table, name=name, first_line=2)


def _notes(
    piece: Demonstration,
    times: FloatArray,
    usual: Mapping[str, float],
    stretches: list[tuple[FloatArray, dict[str, FloatArray]]],
    period: float,
    jumps: int,
    lost: int,
) -> list[str]:
    own = _usual(times)
    steps = np.diff(times)
    spread = 500 * float(np.subtract(*np.quantile(steps[steps > 0], [0.95, 0.05]))) if (steps > 0).any() else 0.0
    rows = sum(len(at) for at, _ in stretches)
    parts = "" if len(stretches) == 1 else f" in {len(stretches)} pieces"
    before = f"{len(times)} rows every {own:.4g} s (+-{spread:.3g} ms)"
    line = f"{piece.name}: {before} became {rows} every {period:.4g} s{parts}"
    if jumps:
        line += f"; its clock jumps back {jumps} times, it is split there"
    gaps = [
        f"{end:.4g} to {begin:.4g} s"
        for (a, _), (b, _) in zip(stretches[:-1], stretches[1:], strict=True)
        if (begin := b[0]) > (end := a[-1])
    ]
    if gaps:
        line += f"; split at gaps: {', '.join(gaps[:3])}" + (f" and {len(gaps) - 3} more" if len(gaps) > 3 else "")
    if lost:
        line += f"; {lost} parts too short for two rows are left out"
    slow = [n for n, u in usual.items() if np.isfinite(u) and u > GAP * period]
    notes = [line]
    if slow:
        notes.append(
            f"{piece.name}: {', '.join(slow[:4])} come every {max(usual[n] for n in slow):.4g} s, slower than "
            f"{period:.4g} s: what lies between two of their readings is a straight line"
        )
    return notes
