"""Files that hold a piece each, as people hand them in: which they are, and what is in one."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd

from ichain_drake.demonstrations.checks import known_units
from ichain_drake.demonstrations.columns import TIME, as_numbers
from ichain_drake.demonstrations.csv_text import ENDINGS, read_csv
from ichain_drake.demonstrations.parquet import read_parquet
from ichain_drake.demonstrations.table import Demonstration
from ichain_drake.errors import InputError
from ichain_drake.files import check_folder, is_file, reason_of, shown
from ichain_drake.graph import InteractionGraph
from ichain_drake.units import convert, split_unit

WHAT = "the demonstration"
_COLUMNS = f"{TIME}, object.variable ..., parent->child ..."
_UNNAMED = re.compile(r"|index|Unnamed: 0|__index_level_0__")
_MOMENT = re.compile(r"\d{4}-\d\d-\d\d[T ]\d\d:\d\d")
# Beside pieces, `teach --browser` writes what is known about their recording.
_NO_TABLES = (".json", ".md", ".txt")

Say = Callable[[str], None]


def read_demonstration(file: Path) -> Demonstration:
    """Read a piece written by `write_demonstration`, by another program, or by hand.

    Parquet, or CSV in any of its dialects (see `read_csv`), also packed as `.csv.gz`. Units may stand behind a column's
    name in brackets. Times may be the table's index, and moments instead of seconds.

    Raises:
        InputError: if it can't be read or parsed.
    """
    file = Path(file)
    ending = file.name.lower()
    if ending.endswith(".parquet"):
        table, stored = read_parquet(file, WHAT)
        table, units = split_units(table)
        return Demonstration(with_time(table), units | stored, shown(file))
    if ending.endswith(ENDINGS):
        text = read_csv(file, WHAT, _COLUMNS)
        table, units = split_units(text.table)
        return Demonstration(with_time(table), units, shown(file), text.first_line)
    raise InputError(f"{file}: a demonstration ends in .parquet or .csv (or .csv.gz)")


def split_units(table: pd.DataFrame) -> tuple[pd.DataFrame, dict[str, str]]:
    """The table with plain names, and the units that stood behind names in brackets; its names are changed in place."""
    split = [split_unit(str(c)) for c in table.columns]
    table.columns = pd.Index([name for name, _ in split])
    return table, {name: unit for name, unit in split if unit is not None}


def with_time(table: pd.DataFrame) -> pd.DataFrame:
    """The table without an index that only counts its rows; one that tells times is their column."""
    if len(table.columns) and len(table):
        for place in {0, len(table.columns) - 1}:  # pandas writes an index first into CSV, last into Parquet
            name = str(table.columns[place])
            if not _UNNAMED.fullmatch(name):
                continue
            if TIME in table.columns:
                counts = np.array_equal(as_numbers(table.iloc[:, place]), np.arange(len(table)))
                return table.drop(columns=name) if counts else table
            table.columns = pd.Index([TIME if i == place else c for i, c in enumerate(table.columns)])
            break
    if list(table.columns).count(TIME) == 1:
        times = table[TIME]
        if not pd.api.types.is_numeric_dtype(times) and len(times) and _MOMENT.match(str(times.iloc[0])):
            moments = pd.to_datetime(times, errors="coerce", format="ISO8601", utc=True)
            return table.assign(**{TIME: (moments - moments.min()).dt.total_seconds()})
    return table


def converted(piece: Demonstration, graph: InteractionGraph) -> tuple[Demonstration, list[str]]:
    """A piece in the units that a graph declares, and a line on each unit that was converted.

    Raises:
        InputError: names the column whose unit has no way to the one that is needed.
    """
    table, units, notes = piece.table, dict(piece.units), []
    for name, wanted in known_units(graph).items():
        given = units.get(name, wanted)
        if given == wanted or list(table.columns).count(name) != 1:
            continue
        try:
            values = convert(as_numbers(table[name]), given, wanted)
        except InputError as error:
            raise InputError(
                f"{piece.name}: column {name} is in {given}, but {wanted} is needed, and {error}; convert it"
            ) from None
        table, units[name] = table.assign(**{name: values}), wanted
        notes.append(f"{piece.name}: {name} converted from {given} to {wanted}")
    return replace(piece, table=table, units=units), notes


def piece_files(folder: Path, say: Say | None = None) -> list[Path]:
    """The files of a folder that are pieces, by their endings, in order of name; one file stands for itself.

    Raises:
        InputError: if the folder does not exist or holds no piece.
    """
    if folder.name.lower().endswith((".parquet", *ENDINGS)) and is_file(folder):
        return [folder]
    check_folder(folder, "demonstrations")
    try:
        entries = sorted(folder.iterdir())
    except OSError as error:
        raise InputError(f"{folder}: can't be read ({reason_of(error)})") from None
    files = [f for f in entries if not f.name.startswith(".") and f.name.lower().endswith((".parquet", *ENDINGS))]
    if not files:
        beside = f"; beside it there is {', '.join(shown(f) for f in entries[:3])}" if entries else ""
        raise InputError(f"{folder}: holds no demonstration (.parquet or .csv){beside}")
    for file in entries:
        if say is not None and file not in files and not file.name.lower().endswith(_NO_TABLES):
            why = "hidden" if file.name.startswith(".") else "neither .parquet nor .csv"
            say(f"passed over: {shown(file)} ({why})")
    return files
