"""What became better or worse since an earlier scoreboard, beyond chance."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from scipy.stats import fisher_exact

from ichain_drake.errors import InputError
from ichain_drake.files import read_json

LEVEL = 0.05
"""Chance, over all rows together, that any is called changed where none is."""


@dataclass(frozen=True)
class Change:
    """A row in two scoreboards.

    Attributes:
        row: its name.
        before, after: successes and runs.
        p: of Fisher's exact test, two-sided.
        adjusted: the same over all rows, by Holm.
    """

    row: str
    before: tuple[int, int]
    after: tuple[int, int]
    p: float
    adjusted: float

    @property
    def gain(self) -> float:
        """Change of the share of successes."""
        return self.after[0] / self.after[1] - self.before[0] / self.before[1]

    @property
    def beyond_chance(self) -> bool:
        """Whether chance is no explanation."""
        return self.adjusted < LEVEL

    def words(self) -> str:
        """In one line."""
        (a, n), (b, m) = self.before, self.after
        return f"{self.row}: {a}/{n} -> {b}/{m} (p {self.adjusted:.2g} over all rows, {self.p:.2g} alone)"


@dataclass(frozen=True)
class Comparison:
    """Two scoreboards side by side.

    Attributes:
        changes: rows that both have, those that changed most first.
        gone, new: names of rows that only one has.
    """

    changes: tuple[Change, ...]
    gone: tuple[str, ...]
    new: tuple[str, ...]

    @property
    def better(self) -> list[Change]:
        """Rows that won, beyond chance."""
        return [c for c in self.changes if c.beyond_chance and c.gain > 0]

    @property
    def worse(self) -> list[Change]:
        """Rows that lost, beyond chance."""
        return [c for c in self.changes if c.beyond_chance and c.gain < 0]


def compare(before: Sequence[Mapping[str, Any]], after: Sequence[Mapping[str, Any]]) -> Comparison:
    """Compare the lines of two scoreboards: an exact test a row, corrected for their number.

    Args:
        before, after: lines with `row`, `reached` and `runs`.
    """
    old, new = ({line["row"]: (int(line["reached"]), int(line["runs"])) for line in t} for t in (before, after))
    shared = [name for name in new if name in old]
    alone = [_fisher(old[name], new[name]) for name in shared]
    changes = [Change(name, old[name], new[name], p, q) for name, p, q in zip(shared, alone, holm(alone), strict=True)]
    changes.sort(key=lambda c: (c.p, c.row))
    return Comparison(tuple(changes), tuple(n for n in old if n not in new), tuple(n for n in new if n not in old))


def holm(values: Sequence[float]) -> list[float]:
    """P values of several tests, corrected for their number step by step (Holm 1979).

    Args:
        values: of the single tests.
    """
    out, largest = [0.0] * len(values), 0.0
    for rank, index in enumerate(sorted(range(len(values)), key=lambda i: values[i])):
        largest = max(largest, min(1.0, (len(values) - rank) * values[index]))
        out[index] = largest
    return out


@cache  # many rows have the same few counts
def _fisher(before: tuple[int, int], after: tuple[int, int]) -> float:
    table = [[reached, runs - reached] for reached, runs in (before, after)]
    return float(fisher_exact(table).pvalue)


def read_scoreboard(file: Path) -> dict[str, Any]:
    """A scoreboard's report.

    Raises:
        InputError: if it is none.
    """
    report = read_json(file, "the earlier scoreboard")
    lines = report.get("table") if isinstance(report, dict) else None
    if not isinstance(lines, list) or not all(isinstance(line, dict) and _is_line(line) for line in lines):
        raise InputError(f"{file}: is no scoreboard; give the report of `ichain scoreboard`")
    return report


def _is_line(line: Mapping[str, Any]) -> bool:
    reached, runs = line.get("reached"), line.get("runs")
    whole = isinstance(reached, int) and isinstance(runs, int)
    return isinstance(line.get("row"), str) and whole and 0 <= reached <= runs and runs > 0  # type: ignore[operator]
