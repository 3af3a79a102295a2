"""What a person marks in recordings: when an interaction is active or not, and where pieces begin; as a table."""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from ichain_drake.demonstrations import Demonstration
from ichain_drake.demonstrations.checks import TIME_TOLERANCE
from ichain_drake.demonstrations.columns import TIME, as_numbers
from ichain_drake.demonstrations.csv_text import read_csv
from ichain_drake.errors import InputError
from ichain_drake.files import write_whole
from ichain_drake.graph import InteractionGraph
from ichain_drake.state import BoolArray
from ichain_drake.timing import TICK

CUT = "cut"
"""Stands in place of an interaction where a mark is about a cut."""

COLUMNS = ("piece", "interaction", "from", "to", "active", "name")
_NAME = re.compile(r"[\w-]{1,60}")


@dataclass(frozen=True)
class Mark:
    """One line of the table.

    Attributes:
        piece: name of the recording.
        interaction: `parent->child`, or `cut`.
        first, last: from and to [s], both included, by the recording's clock; a cut has the time of the first row
            behind it, twice.
        active: whether the interaction is; of a cut whether there is one.
        name: of the piece that begins at a cut; empty to let it be numbered.
        where: begins an error: file and line.
    """

    piece: str
    interaction: str
    first: float
    last: float
    active: bool
    name: str = ""
    where: str = "marks"

    def rows(self, times: np.ndarray) -> BoolArray:
        """Rows of the recording that it is about, shape (n_rows,)."""
        beside = (0.5 if self.interaction == CUT else TIME_TOLERANCE) * TICK
        return np.asarray((times > self.first - beside) & (times < self.last + beside))


def read_marks(file: Path) -> list[Mark]:
    """Marks from a CSV with columns piece, interaction, from, to, active and, if wanted, name.

    Raises:
        InputError: if it can't be read, or a line is no mark; names file, line and what is wrong with it.
    """
    found = read_csv(file, "the marks", ", ".join(COLUMNS))
    table = found.table
    lost = [c for c in COLUMNS[:5] if c not in table.columns]
    if lost:
        raise InputError(f"{file}: column {lost[0]} is missing; its columns are {', '.join(COLUMNS)}")
    out = []
    for i, row in enumerate(table.to_dict("records")):
        where = f"{file}: line {found.first_line + i}"
        out.append(_mark({str(k): v for k, v in row.items()}, where))
    return out


def make_marks(rows: Sequence[Mapping[str, object]], where: str) -> list[Mark]:
    """Marks out of plain values by the table's column names, as a page sends them.

    Raises:
        InputError: as `read_marks`.
    """
    return [_mark(row, f"{where} {i + 1}") for i, row in enumerate(rows)]


def _mark(row: Mapping[str, object], where: str) -> Mark:
    """A mark out of the cells of a line."""
    text = {k: "" if v is None or (isinstance(v, float) and math.isnan(v)) else str(v).strip() for k, v in row.items()}
    about, name = text.get("interaction", ""), text.get("name", "")
    numbers: dict[str, float] = {}
    for column in ("from", "to", "active"):
        cell = text.get(column, "")
        if column == "to" and about == CUT and not cell:
            cell = text.get("from", "")
        try:
            numbers[column] = float(cell)
        except ValueError:
            numbers[column] = math.nan
        if not math.isfinite(numbers[column]):
            raise InputError(f"{where}: column {column}: {cell!r} given; a number is needed")
    if numbers["active"] not in (0.0, 1.0):
        raise InputError(f"{where}: column active: {numbers['active']:g} given; 1 is active, 0 is not")
    if numbers["to"] < numbers["from"]:
        raise InputError(f"{where}: it ends at {numbers['to']:g} s, before it begins at {numbers['from']:g} s")
    if name and about != CUT:
        raise InputError(f"{where}: a name is for a cut: it names the piece that begins there")
    if name and not _NAME.fullmatch(name):
        raise InputError(f"{where}: name {name[:40]!r}: give letters, digits, '-' and '_', at most 60")
    return Mark(text.get("piece", ""), about, numbers["from"], numbers["to"], numbers["active"] == 1.0, name, where)


def write_marks(marks: Sequence[Mark], file: Path) -> None:
    """Write marks as a CSV that `read_marks` reads, whole or not at all.

    Raises:
        InputError: if it can't be written.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    for m in marks:
        last = "" if m.interaction == CUT else f"{m.last:.6g}"
        writer.writerow([m.piece, m.interaction, f"{m.first:.6g}", last, int(m.active), m.name])
    write_whole(file, text.getvalue().encode())


def check_marks(marks: Sequence[Mark], logs: Sequence[Demonstration], graph: InteractionGraph) -> None:
    """Check marks against what they are about.

    Raises:
        InputError: on a recording or an interaction that there isn't, times beyond the recording or between two rows,
            two marks that say opposite things of a row, and names given twice; begins with the mark's line.
    """
    times = {log.name: as_numbers(log.table[TIME]) for log in logs}
    edges = [e.name for e in graph.interactions]
    said: dict[tuple[str, str], list[Mark]] = {}
    names: dict[str, Mark] = {}
    for m in marks:
        if m.piece not in times:
            raise InputError(f"{m.where}: there is no recording {m.piece!r}; there are {', '.join(times)}")
        if m.interaction != CUT and m.interaction not in edges:
            raise InputError(
                f"{m.where}: {m.interaction!r} is no interaction of the graph; it has {', '.join(edges)} (or {CUT})"
            )
        at = times[m.piece]
        if (np.diff(at) <= 0).any():
            raise InputError(f"{m.where}: the clock of {m.piece} goes back, so that times say nothing; cut it first")
        if m.first < at.min() - TICK or m.last > at.max() + TICK:
            raise InputError(
                f"{m.where}: {m.first:g} to {m.last:g} s, but {m.piece} lasts from {at.min():g} to {at.max():g} s"
            )
        if not m.rows(at).any():
            raise InputError(f"{m.where}: {m.piece} has no row from {m.first:g} to {m.last:g} s")
        for other in said.setdefault((m.piece, m.interaction), []):
            if other.active != m.active and (other.rows(at) & m.rows(at)).any():
                raise InputError(
                    f"{m.where}: it says the opposite of {other.where} on {m.interaction} in {m.piece}; keep one"
                )
        said[m.piece, m.interaction].append(m)
        if m.name and names.setdefault(m.name, m) is not m:
            raise InputError(f"{m.where}: the name {m.name} is given at {names[m.name].where}, too")


def marked(log: Demonstration, marks: Sequence[Mark]) -> Demonstration:
    """A recording with what was marked in its flags: 1, 0, and empty where nothing is known.

    Args:
        log: whose flag columns may be missing; what they say stays where nothing was marked.
        marks: checked; those about other recordings are passed over.
    """
    mine = [m for m in marks if m.piece == log.name and m.interaction != CUT]
    table = log.table.copy()
    times = as_numbers(table[TIME])
    for m in mine:
        known = as_numbers(table[m.interaction]) if m.interaction in table else np.full(len(table), np.nan)
        table[m.interaction] = pd.Series(np.where(m.rows(times), float(m.active), known), index=table.index)
    return Demonstration(table, log.units, log.name, log.first_line) if mine else log
