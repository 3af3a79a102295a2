"""Logs that are too long for the memory: read twice, a part at a time, and kept as far as they are learned from."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ichain_drake.demonstrations.columns import TIME, as_numbers, column
from ichain_drake.demonstrations.long_parquet import opened_parquet
from ichain_drake.demonstrations.piece_file import (
    WHAT,
    Say,
    converted,
    piece_files,
    read_demonstration,
    split_units,
    with_time,
)
from ichain_drake.demonstrations.table import Demonstration
from ichain_drake.demonstrations.thinning import Bound, Outline, Outliner, chosen_rows, outline, stretch
from ichain_drake.errors import InputError
from ichain_drake.files import MOST_CELLS, shown
from ichain_drake.graph import InteractionGraph
from ichain_drake.timing import TICK
from ichain_drake.units import split_unit

MOST_AT_ONCE = 5 * MOST_CELLS
"""Rows times columns of all logs together from which on they are read by parts [1]: 400 MB as numbers."""

_CHARACTERS = 4  # of a value in CSV, at least, with its comma
_RATE_ROWS = 1000  # from which the period is told
_MOST_A_TICK = 1000.0  # rows: of shorter periods than that fewer ticks are kept


def read_enough(
    folder: Path,
    graph: InteractionGraph,
    bound: Bound | None,
    *,
    resampled: bool = False,
    say: Say | None = None,
) -> list[Demonstration]:
    """Read every piece of a folder; of logs that are too long for the memory, stretches of them (see `thinning`).

    Long logs are read twice, a few thousand rows at a time: for their flags, and for the rows that are kept. Only these
    are checked by whoever checks pieces. So what is in memory depends on the bound, not on the length of the logs.

    Args:
        folder: with the pieces, or one file.
        graph: whose interactions must be shown.
        bound: how much of them is kept; None to read all in any case.
        resampled: whether pieces will be taken to the library's period: the bound is then one of its ticks.
        say: called with a line on each file that is passed over, and on what is left out.

    Raises:
        InputError: as `read_folder`.
    """
    files = piece_files(Path(folder), say)
    if bound is None or not is_long(files):
        return [read_demonstration(file) for file in files]
    rate = _rows_a_tick(files[0], graph) if resampled else 1
    outlines = [outline_of(file, graph, rate * bound.stretch) for file in files]
    ranges = chosen_rows(outlines, rate * bound.rows)
    kept, rows = sum(b - a for part in ranges for a, b in part), sum(o.rows for o in outlines)
    if say is not None:
        how = "stretches that show every change of status, and evenly of the rest"
        say(f"{folder}: {kept} of {rows} rows are read: {how}")
    return [piece for file, part in zip(files, ranges, strict=True) for piece in read_stretches(file, part)]


def _rows_a_tick(file: Path, graph: InteractionGraph) -> int:
    """How many rows of a log are one tick; 1 where its times don't tell, as whoever checks it will say."""
    if _is_parquet(file):
        with opened_parquet(file, WHAT) as log:
            rows = min(_RATE_ROWS, log.rows)
        pieces = read_stretches(file, [(0, rows)] if rows else [])
    else:
        pieces = [read_demonstration(file)]
    for piece in pieces:
        table = converted(piece, graph)[0].table
        if list(table.columns).count(TIME) == 1 and len(table) > 1:
            period = float(np.median(np.diff(as_numbers(table[TIME]))))
            return round(min(max(TICK / period, 1.0), _MOST_A_TICK)) if period > 0 else 1
    return 1


def is_long(files: Sequence[Path]) -> bool:
    """Whether logs are too long to be read at once: any that is refused then, or all together."""
    cells = [_cells(file) for file in files]
    return max(cells, default=0) > MOST_CELLS or sum(cells) > MOST_AT_ONCE


def _cells(file: Path) -> int:
    """About how many values a log holds; 0 where it can't be read, which reading it will tell."""
    try:
        if not _is_parquet(file):
            return min(file.stat().st_size // _CHARACTERS, MOST_CELLS)
        with opened_parquet(file, WHAT) as log:
            return log.rows * len(log.names)
    except (InputError, OSError):
        return 0


def outline_of(file: Path, graph: InteractionGraph, length: int) -> Outline:
    """The stretches of a log and what they tell.

    Args:
        file: a log; CSV is read as a whole.
        graph: the interactions.
        length: of a stretch [rows].

    Raises:
        InputError: if it can't be read.
    """
    if not _is_parquet(file):
        return outline(read_demonstration(file), graph, length)
    with opened_parquet(file, WHAT) as log:
        whole, names = Outliner(graph, length), [split_unit(name)[0] for name in log.names]
        for part in log.parts({e.name for e in graph.interactions}):
            whole.add(part)
        return whole.outline(lambda name: {column(name, v) for v in graph.objects[name].observable.names} <= set(names))


def read_stretches(file: Path, ranges: Sequence[tuple[int, int]]) -> list[Demonstration]:
    """Ranges of rows of a log, each a piece; the piece itself where one is all of it.

    Args:
        file: a log.
        ranges: first rows and rows after the last, ascending.

    Raises:
        InputError: if it can't be read.
    """
    if not ranges:
        return []
    if not _is_parquet(file):
        piece = read_demonstration(file)
        return [stretch(piece, first, end) for first, end in ranges]
    out = []
    with opened_parquet(file, WHAT) as log:
        for (first, end), part in zip(ranges, log.stretches(ranges), strict=True):
            table, units = split_units(part)
            whole = (first, end) == (0, log.rows)
            name = shown(file) if whole else f"{shown(file)} rows {first} to {end - 1}"
            out.append(Demonstration(with_time(table, first), units | log.units, name, 2 + first))
    return out


def _is_parquet(file: Path) -> bool:
    return file.name.lower().endswith(".parquet")
