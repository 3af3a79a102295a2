"""A demonstration: one recorded piece as a table, on disk as Parquet or CSV."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq

from ichain_drake.errors import InputError
from ichain_drake.graph import InteractionGraph
from ichain_drake.state import FloatArray, StateSpace
from ichain_drake.timing import TICK

TIME = "time"
COMMAND = "command"
"""Object name under which the hand command in force since a row is recorded (paper sec. III: A_1)."""

_METADATA_KEY = b"ichain_drake"
_UNIT = re.compile(r"^(?P<name>.*?)\s*\[(?P<unit>[^\]]*)\]$")
_TIME_TOLERANCE = 0.05  # of the period


def column(obj: str, variable: str) -> str:
    """Name of a measured variable's column: `object.variable`."""
    return f"{obj}.{variable}"


@dataclass(frozen=True)
class Demonstration:
    """One piece of demonstration.

    Attributes:
        table: columns `time` [s], `object.variable` for each measured variable, `command.variable` for the hand
            command in force from a row to the next (optional), and `parent->child` for active flags (0 or 1, optional).
        units: unit of each variable column.
        name: what errors call it; the file it came from.
    """

    table: pd.DataFrame
    units: Mapping[str, str] = field(default_factory=dict)
    name: str = "demonstration"

    def __len__(self) -> int:
        return len(self.table)

    @property
    def period(self) -> float:
        """Median time between rows [s]."""
        return float(np.median(np.diff(self.table[TIME])))

    def has(self, obj: str, space: StateSpace) -> bool:
        """Whether every observable variable of an object is in the table."""
        return all(column(obj, v) in self.table for v in space.observable.names)

    def states(self, obj: str, space: StateSpace) -> FloatArray:
        """Measured states of one object, shape (n_rows, n_observable).

        Raises:
            InputError: if a variable's column is missing.
        """
        names = [column(obj, v) for v in space.observable.names]
        missing = [n for n in names if n not in self.table]
        if missing:
            raise InputError(f"{self.name}: column {missing[0]} is missing; it has {', '.join(self.table.columns)}")
        return self.table[names].to_numpy(dtype=float)

    def check(self, graph: InteractionGraph, objects: Sequence[str] | None = None) -> None:
        """Check a table where it enters.

        Args:
            graph: names the objects, variables, units and interactions that may appear.
            objects: objects that must be there; default: none, but at least one object must be complete.

        Raises:
            InputError: on missing or unknown columns, wrong units, times that are unsorted, doubled or not at the
                library's period, NaN, or flags other than 0 and 1; with table, column and line.
        """
        _check_columns(self, graph, objects)
        _check_values(self, graph)


def _check_columns(demo: Demonstration, graph: InteractionGraph, objects: Sequence[str] | None) -> None:
    unknown = [o for o in objects or () if o not in graph.objects]
    if unknown:
        raise InputError(f"{demo.name}: there is no object {unknown[0]!r}; objects are {', '.join(graph.objects)}")
    if COMMAND in graph.objects:
        raise InputError(f"{demo.name}: {COMMAND!r} stands for the hand's commands; give that object another name")
    if TIME not in demo.table:
        raise InputError(f"{demo.name}: column {TIME} is missing; give the time of each row in seconds")
    doubled = demo.table.columns[demo.table.columns.duplicated()]
    if len(doubled):
        raise InputError(f"{demo.name}: column {doubled[0]} appears twice; remove one")
    known = {column(o, v.name): v.unit for o, s in graph.objects.items() for v in s.observable.variables}
    known |= {column(COMMAND, v.name): v.unit for v in graph.objects[graph.root].observable.variables}
    known[TIME] = "s"
    flags = {e.name for e in graph.interactions}
    for name in demo.table.columns:
        if name in flags:
            continue
        if "->" in name:
            raise InputError(f"{demo.name}: {name} is no interaction of the graph; it has {', '.join(sorted(flags))}")
        if name not in known:
            raise InputError(f"{demo.name}: column {name} is no measured variable; known are {', '.join(known)}")
        unit = demo.units.get(name, known[name])
        if unit != known[name]:
            raise InputError(f"{demo.name}: column {name} is in {unit}, but {known[name]} is needed; convert it")
    for obj in (*graph.objects, COMMAND):
        wanted = graph.objects[graph.root if obj == COMMAND else obj].observable.names
        present = [v for v in wanted if column(obj, v) in demo.table]
        if (present or obj in (objects or ())) and len(present) != len(wanted):
            lost = next(v for v in wanted if v not in present)
            raise InputError(f"{demo.name}: column {column(obj, lost)} is missing")
    if not any(demo.has(o, s) for o, s in graph.objects.items()):
        raise InputError(f"{demo.name}: holds no object of the graph; its objects are {', '.join(graph.objects)}")


def _check_values(demo: Demonstration, graph: InteractionGraph) -> None:
    if len(demo.table) < 2:
        raise InputError(f"{demo.name}: {len(demo.table)} rows; a piece needs at least 2")
    for name in demo.table.columns:
        values = pd.to_numeric(demo.table[name], errors="coerce").to_numpy(dtype=float, na_value=np.nan)
        bad = ~np.isfinite(values)
        if bad.any():
            row = int(np.argmax(bad))
            raise InputError(
                f"{demo.name}: line {row + 2}, column {name}: not a finite number; remove the row or mend it"
            )
        odd = ~np.isin(values, (0.0, 1.0))
        if "->" in name and odd.any():
            row = int(np.argmax(odd))
            raise InputError(
                f"{demo.name}: line {row + 2}, column {name}: {values[row]:g} given; an active flag is 0 or 1"
            )
    steps = np.diff(demo.table[TIME].to_numpy(dtype=float))
    if (steps <= 0).any():
        row = int(np.argmax(steps <= 0)) + 1
        what = "a doubled time" if steps[row - 1] == 0 else "a time before the previous one"
        raise InputError(f"{demo.name}: line {row + 2}, column {TIME}: {what}; sort by time and remove doubles")
    off = np.abs(steps - TICK) > _TIME_TOLERANCE * TICK
    if off.any():
        row = int(np.argmax(off)) + 1
        raise InputError(
            f"{demo.name}: line {row + 2}, column {TIME}: {steps[row - 1]:.4g} s since the previous row, {TICK:.4g} s "
            "needed; record at 3 Hz, or split the piece there"
        )


def write_demonstration(demo: Demonstration, file: Path) -> None:
    """Write a piece as `.parquet`, or as `.csv` with units in the header (`car.x [px]`).

    Raises:
        InputError: on another ending, or if the file can't be written.
    """
    try:
        if file.suffix == ".csv":
            header = {c: f"{c} [{demo.units[c]}]" for c in demo.table.columns if c in demo.units}
            demo.table.rename(columns=header).to_csv(file, index=False)
        elif file.suffix == ".parquet":
            table = pa.Table.from_pandas(demo.table, preserve_index=False)
            metadata = {
                **(table.schema.metadata or {}),
                _METADATA_KEY: json.dumps({"units": dict(demo.units)}).encode(),
            }
            pq.write_table(table.replace_schema_metadata(metadata), file)
        else:
            raise InputError(f"{file}: a demonstration ends in .parquet or .csv")
    except OSError as error:
        raise InputError(f"{file}: can't write the demonstration: {error.strerror or error}") from None


def read_demonstration(file: Path) -> Demonstration:
    """Read a piece written by `write_demonstration`, or by hand.

    Raises:
        InputError: if it can't be read or parsed.
    """
    try:
        if file.suffix == ".csv":
            table = pd.read_csv(file, engine="python")  # parses numbers as Python does: to the last bit
            matches = {c: _UNIT.match(str(c)) for c in table.columns}
            units = {m["name"]: m["unit"] for m in matches.values() if m}
            table = table.rename(columns={c: m["name"] for c, m in matches.items() if m})
            return Demonstration(table, units, file.name)
        if file.suffix == ".parquet":
            stored = pq.read_table(file)
            extra = json.loads((stored.schema.metadata or {}).get(_METADATA_KEY, b"{}"))
            return Demonstration(stored.to_pandas(), dict(extra.get("units", {})), file.name)
    except (OSError, ValueError, pa.ArrowException, pd.errors.ParserError) as error:
        raise InputError(f"{file}: can't read the demonstration: {str(error).splitlines()[0]}") from None
    raise InputError(f"{file}: a demonstration ends in .parquet or .csv")


def read_folder(folder: Path) -> list[Demonstration]:
    """Read every piece of a folder, in order of file name, without checking what is in it.

    Raises:
        InputError: if the folder does not exist or holds no piece, or a file can't be read.
    """
    if not folder.is_dir():
        raise InputError(f"{folder}: no such folder of demonstrations")
    files = sorted(f for f in folder.iterdir() if f.suffix in {".parquet", ".csv"})
    if not files:
        raise InputError(f"{folder}: holds no demonstration (.parquet or .csv)")
    return [read_demonstration(f) for f in files]


def read_demonstrations(folder: Path, graph: InteractionGraph) -> list[Demonstration]:
    """Read and check every piece of a folder, in order of file name.

    Raises:
        InputError: if the folder does not exist or holds no piece, or a piece is bad.
    """
    pieces = read_folder(folder)
    for piece in pieces:
        piece.check(graph)
    return pieces


def write_demonstrations(pieces: Sequence[Demonstration], folder: Path) -> list[Path]:
    """Write pieces into a folder as `<name>.parquet`, making the folder if needed.

    Raises:
        InputError: if the folder can't be made or written, or two pieces would get the same file.
    """
    files = [folder / f"{Path(p.name).stem}.parquet" for p in pieces]
    for file in files:
        if files.count(file) > 1:
            raise InputError(f"{file}: two pieces have this name; give each its own")
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: can't make the folder: {error.strerror or error}") from None
    for piece, file in zip(pieces, files, strict=True):
        write_demonstration(piece, file)
    return files
