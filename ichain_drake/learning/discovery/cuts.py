"""Cuts: long recordings taken apart where time, the recorder or whoever set up the scene anew leaves a break."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import PurePath
from typing import Any

import numpy as np

from ichain_drake.demonstrations import Demonstration
from ichain_drake.demonstrations.column_noise import column_noise
from ichain_drake.demonstrations.columns import TIME, as_numbers
from ichain_drake.demonstrations.repeats import repeats
from ichain_drake.demonstrations.resampling import GAP
from ichain_drake.errors import InputError
from ichain_drake.graph import InteractionGraph
from ichain_drake.learning.discovery.marks import CUT, Mark
from ichain_drake.learning.discovery.resets import find_resets
from ichain_drake.state import FloatArray
from ichain_drake.timing import TICK

TABLE = "cuts.json"
"""Beside pieces it says how they were cut: nobody cuts them again."""


@dataclass(frozen=True)
class Cut:
    """Between two rows of a recording.

    Attributes:
        log: name of the recording.
        row: the first one behind it, from 0.
        time: of that row [s].
        why: in words.
        sure: its probability; 1 where it can be read off.
        fixed: whether what is on either side of it can't be one piece: a gap, or what was left out.
    """

    log: str
    row: int
    time: float
    why: str
    sure: float
    fixed: bool = False

    def __str__(self) -> str:
        """In one line."""
        return f"{self.log} row {self.row} ({self.time:.4g} s): {self.why} (sure by {self.sure:.3f})"

    def report(self) -> dict[str, Any]:
        """Plain numbers and texts, ready for JSON."""
        return {
            "log": self.log, "row": self.row, "time": round(self.time, 4), "why": self.why, "sure": round(self.sure, 4)
        }  # fmt: skip


@dataclass(frozen=True)
class Pieces:
    """What recordings were cut into.

    Attributes:
        pieces: in the order of the recordings; one that has no cut is as it was.
        cuts: all of them, in the same order.
        begins: per piece the name of its recording and the row of it at which it begins.
        left_out: what became no piece, a line each.
    """

    pieces: tuple[Demonstration, ...]
    cuts: tuple[Cut, ...]
    begins: tuple[tuple[str, int], ...]
    left_out: tuple[str, ...] = ()

    def lines(self) -> list[str]:
        """What was done, a line each."""
        return [*map(str, self.cuts), *self.left_out]

    def report(self) -> dict[str, Any]:
        """What stands beside the pieces, ready for JSON."""
        return {
            "cuts": [c.report() for c in self.cuts],
            "left_out": list(self.left_out),
            "pieces": {PurePath(p.name).stem: len(p) for p in self.pieces},
        }


@dataclass(frozen=True)
class _Stretch:
    """Rows of a recording between two breaks that can be read off: `first` up to, not including, `end`."""

    log: int
    first: int
    end: int


def cut_pieces(
    logs: Sequence[Demonstration],
    graph: InteractionGraph,
    say: Callable[[str], None] | None = None,
    marks: Sequence[Mark] = (),
) -> Pieces:
    """Cut recordings where they were interrupted, written twice, or reset.

    A reset is told by likelihood: several objects are at once where none of them comes by how it moves in these logs.
    Recordings that hold what can't be read are left as they are, for whoever checks them to name it.

    Args:
        logs: at the library's period, in the graph's units; flags and commands may be there.
        graph: declares objects and their state spaces.
        say: called with a line on each cut.
        marks: what a person says of cuts: there is one, or none, and how the piece behind it is called. Checked.

    Raises:
        InputError: if a person joins what a gap or a repetition keeps apart.
    """
    told = _Told(logs, marks)
    readable = [_readable(log, graph) for log in logs]
    noise = column_noise([log for log, fine in zip(logs, readable, strict=True) if fine], graph)
    noisy = [n for n, std in noise.items() if std > 0]
    cuts: list[list[Cut]] = []
    stretches: list[_Stretch] = []
    left_out: list[str] = []
    for k, log in enumerate(logs):
        if not readable[k]:
            cuts.append([])
            stretches.append(_Stretch(k, 0, len(log)))
            continue
        twice = repeats(log, noisy)
        left_out += [f"{log.name} rows {a} to {b} repeat those from row {c} on: left out" for a, b, c in twice]
        found, kept = _interruptions(k, log, twice)
        cuts.append(found)
        stretches += kept
    asked = [s for s in stretches if readable[s.log] and s.end - s.first > 1]
    states = [_states(logs[s.log], graph, s) for s in asked]
    spaces = {n: space.observable for n, space in graph.objects.items()}
    parts = {s: [s.first, s.end] for s in stretches}
    for stretch, found_resets in zip(asked, find_resets(states, spaces), strict=True):
        log = logs[stretch.log]
        for tick in np.flatnonzero(found_resets.probability > 0.5):
            row = stretch.first + int(tick) + 1
            if (mark := told.at(log, row)) is not None and not mark.active:
                continue
            jumped = [n for n, jumps in found_resets.jumped.items() if jumps[tick]]
            why = f"reset: {', '.join(jumped)} jump as they never do by themselves"
            cuts[stretch.log].append(Cut(log.name, row, _time(log, row), why, float(found_resets.probability[tick])))
            parts[stretch].append(row)
    for stretch in stretches:
        log = logs[stretch.log]
        wanted = [row for row in told.cuts(log) if stretch.first < row < stretch.end and row not in parts[stretch]]
        cuts[stretch.log] += [Cut(log.name, row, _time(log, row), "marked by a person", 1.0) for row in wanted]
        parts[stretch] = sorted({*parts[stretch], *wanted})
    for log, found in zip(logs, cuts, strict=True):
        told.check(log, found)
    pieces: list[Demonstration] = []
    begins: list[tuple[str, int]] = []
    for k, log in enumerate(logs):
        ends = [(a, b) for s in stretches if s.log == k for a, b in zip(parts[s][:-1], parts[s][1:], strict=True)]
        whole = [(a, b) for a, b in ends if b - a > 1]
        left_out += [f"{log.name} row {a} is no piece by itself: left out" for a, b in ends if b - a == 1 < len(log)]
        alone = len(ends) == 1 and not told.name(log, 0)
        pieces += [log] if alone else _parts(log, whole, told)
        begins += [(log.name, 0)] if alone else [(log.name, a) for a, _ in whole]
    ordered = tuple(c for found in cuts for c in sorted(found, key=lambda c: c.row))
    done = Pieces(tuple(pieces), ordered, tuple(begins), tuple(left_out))
    for line in done.lines() if say is not None else ():
        say(line)  # type: ignore[misc]
    return done


def _readable(log: Demonstration, graph: InteractionGraph) -> bool:
    """Whether there are rows at the period and finite numbers; who checks the piece says what is wrong with it."""
    if list(log.table.columns).count(TIME) != 1 or len(log) < 2 or log.table.columns.duplicated().any():
        return False
    times = as_numbers(log.table[TIME])
    if not abs(float(np.median(np.diff(times))) - TICK) < (GAP - 1.0) * TICK:  # of another rate, or no times
        return False
    held = [n for n, s in graph.objects.items() if log.has(n, s)]
    values = [as_numbers(log.table[f"{n}.{v}"]) for n in held for v in graph.objects[n].observable.names]
    return bool(held) and all(np.isfinite(x).all() for x in (times, *values))


def _interruptions(
    k: int, log: Demonstration, twice: Sequence[tuple[int, int, int]]
) -> tuple[list[Cut], list[_Stretch]]:
    """Cuts at gaps, at jumps of the clock and around what was written twice, and the stretches between."""
    times = as_numbers(log.table[TIME])
    steps = np.diff(times)
    cuts, bounds = [], {0, len(log)}
    for row in np.flatnonzero((steps > GAP * TICK) | (steps <= 0)) + 1:
        step = steps[row - 1]
        why = f"gap of {step:.4g} s" if step > 0 else f"the clock goes back {-step:.4g} s"
        cuts.append(Cut(log.name, int(row), float(times[row]), why, 1.0, fixed=True))
        bounds.add(int(row))
    doubled = set()
    for a, b, c in twice:
        why = f"rows {a} to {b} repeat those from row {c} on"
        cuts.append(Cut(log.name, a, float(times[a]), why, 1.0, fixed=True))
        bounds |= {a, b + 1}
        doubled |= set(range(a, b + 1))
    marks = sorted(bounds)
    kept = [_Stretch(k, a, b) for a, b in zip(marks[:-1], marks[1:], strict=True) if a not in doubled]
    return cuts, kept


def _states(log: Demonstration, graph: InteractionGraph, stretch: _Stretch) -> Mapping[str, FloatArray]:
    rows = slice(stretch.first, stretch.end)
    return {n: log.states(n, s)[rows] for n, s in graph.objects.items() if log.has(n, s)}


def _time(log: Demonstration, row: int) -> float:
    return float(as_numbers(log.table[TIME])[row])


def _parts(log: Demonstration, ends: Sequence[tuple[int, int]], told: _Told) -> list[Demonstration]:
    """Pieces of a recording, numbered where nobody named them; a name holds where nothing is cut off, too."""
    path = PurePath(log.name)
    out = []
    for i, (first, end) in enumerate(ends):
        stem = told.name(log, first) or f"{path.stem}-part{i + 1:02d}"
        table = log.table.iloc[first:end].reset_index(drop=True)
        shown = {n: rows[first:end] for n, rows in log.open.items()}
        name = f"{stem}{path.suffix}"
        out.append(replace(log, table=table, name=name, first_line=log.first_line + first, open=shown))
    return out


class _Told:
    """What a person says of cuts, by recording and row."""

    def __init__(self, logs: Sequence[Demonstration], marks: Sequence[Mark]) -> None:
        self._marks: dict[tuple[str, int], Mark] = {}
        times = {log.name: as_numbers(log.table[TIME]) for log in logs} if marks else {}
        for mark in marks:
            if mark.interaction == CUT:
                row = int(np.argmin(np.abs(times[mark.piece] - mark.first)))
                self._marks[mark.piece, row] = mark

    def at(self, log: Demonstration, row: int) -> Mark | None:
        """What is said of a row, if anything."""
        return self._marks.get((log.name, row))

    def cuts(self, log: Demonstration) -> list[int]:
        """Rows before which there is a cut."""
        return sorted(row for (name, row), mark in self._marks.items() if name == log.name and mark.active and row)

    def name(self, log: Demonstration, row: int) -> str:
        """What the piece that begins at a row is called; empty where nobody says."""
        mark = self.at(log, row)
        return mark.name if mark is not None and mark.active else ""

    def check(self, log: Demonstration, cuts: Sequence[Cut]) -> None:
        """Refuse to join what can't be.

        Raises:
            InputError: names the mark.
        """
        for cut in cuts:
            mark = self.at(log, cut.row)
            if mark is not None and not mark.active:
                raise InputError(f"{mark.where}: {log.name} can't be joined at {cut.time:.4g} s: {cut.why}")
