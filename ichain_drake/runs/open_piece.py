"""A piece that is still being recorded, on disk: what a killed process leaves of it is a piece of the next session."""

from __future__ import annotations

import fcntl
import itertools
import json
import os
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from ichain_drake.demonstrations import TIME, Demonstration, write_demonstrations
from ichain_drake.errors import InputError
from ichain_drake.files import is_folder, json_value, read_whole, reason_of
from ichain_drake.graph import InteractionGraph
from ichain_drake.state import FloatArray
from ichain_drake.timing import FRAMES_PER_TICK, TICK

_ENDING = ".open"


class OpenRecord:
    """The rows of an open piece, a line each, in a hidden file that goes when the piece is kept or dropped.

    Args:
        folder: where the piece will be; made where it doesn't exist.
        name: of the piece; the file gets a number where another session has one of this name, or has left one that
            nothing can be made of.

    Raises:
        InputError: if the file can't be written.
    """

    def __init__(self, folder: Path, name: str) -> None:
        self.rows = 0
        self._marks = ""
        names = itertools.chain([name], (f"{name}-{number}" for number in itertools.count(2)))
        files = (folder / f".{n}{_ENDING}" for n in names)
        self.file = folder / f".{name}{_ENDING}"
        try:
            folder.mkdir(parents=True, exist_ok=True)
            self.file = next(file for file in files if not os.path.lexists(file))
            self._stream = self.file.open("x", encoding="utf-8")
            _lock(self._stream.fileno())
        except OSError as error:
            raise InputError(f"{self.file}: can't write the open piece: {reason_of(error)}") from None

    def add(self, table: Demonstration, first: int, marks: Mapping[str, list[int]], before: Mapping[str, bool]) -> None:
        """Add rows, and what the person marked up to now.

        Args:
            table: the rows that are not in the file yet.
            first: frame of the piece's first row.
            marks, before: see `OpenPiece`.

        Raises:
            InputError: if they can't be written.
        """
        names = [c for c in table.table.columns if c != TIME]
        lines = [] if self.rows else [json.dumps({"columns": names, "units": dict(table.units)})]
        lines += [json.dumps(row) for row in table.table[names].to_numpy(dtype=float).tolist()]
        marked = json.dumps({"first": first, "marks": dict(marks), "before": dict(before)})
        lines += [] if marked == self._marks else [marked]
        try:
            self._stream.write("".join(f"{line}\n" for line in lines))
            self._stream.flush()  # to the system, which outlives this process
        except OSError as error:
            raise InputError(f"{self.file}: can't write the open piece: {reason_of(error)}") from None
        self.rows, self._marks = self.rows + len(table), marked

    def remove(self) -> None:
        """The piece is kept, or dropped."""
        with suppress(OSError):  # for what could not be written
            self._stream.close()
        self.file.unlink(missing_ok=True)


def _lock(handle: int) -> None:
    """Mark a file as being written; the system takes the mark off when the process ends, however it does."""
    fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)


class OpenScript:
    """Keeps the rows of pieces that a script records, one piece after the other; see `noted_in`.

    Where there is no room for them, it gives that up: the piece itself may still fit, and is what counts.

    Args:
        folder: where the pieces will be.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._record: OpenRecord | None = None
        self._no_room = False

    @property
    def rows(self) -> int:
        """How many rows of the open piece are on disk."""
        return 0 if self._record is None else self._record.rows

    def add(self, piece: Demonstration) -> None:
        """Put the rows that follow on disk."""
        if self._no_room:
            return
        try:
            if self._record is None:
                self._record = OpenRecord(self._folder, Path(piece.name).stem)
            self._record.add(piece, 0, {}, {})
        except InputError:
            self.close()
            self._no_room = True

    def close(self) -> None:
        """The piece is kept, or nothing is to be kept of it."""
        if self._record is not None:
            self._record.remove()
        self._record, self._no_room = None, False


def save_left_behind(folder: Path, graph: InteractionGraph, say: Callable[[str], None]) -> None:
    """Make pieces of what killed processes left in a folder of scripted pieces; what fits no graph of ours stays.

    Args:
        folder: need not exist.
        graph: whose pieces they should be.
        say: called with a line on each.

    Raises:
        InputError: if the folder can't be read, or a piece can't be written.
    """
    for file, piece in left_behind(folder) if is_folder(folder) else ():
        numbers = itertools.chain([""], (f"-{number}" for number in itertools.count(2)))
        name = next(n for n in (piece.name + more for more in numbers) if not (folder / f"{n}.parquet").exists())
        saved = replace(piece, name=name)
        try:
            saved.check(graph)
        except InputError:
            continue
        write_demonstrations([saved], folder)
        file.unlink(missing_ok=True)
        say(f"{name} is what a process that ended unexpectedly had recorded: {len(saved)} rows")


def left_behind(folder: Path) -> list[tuple[Path, Demonstration]]:
    """Open pieces in a folder whose process has ended, with the files that they are in; unreadable ones are left there.

    Raises:
        InputError: if the folder can't be read.
    """
    found = []
    try:
        files = sorted(f for f in folder.iterdir() if f.name.startswith(".") and f.name.endswith(_ENDING))
    except OSError as error:
        raise InputError(f"{folder}: can't be read ({reason_of(error)})") from None
    for file in files:
        if _is_written(file):
            continue
        try:
            piece = _read(file)
        except (InputError, ValueError, LookupError, TypeError, AttributeError, ArithmeticError):
            continue
        if piece is None:
            file.unlink(missing_ok=True)
        else:
            found.append((file, piece))
    return found


def _is_written(file: Path) -> bool:
    try:
        with file.open("rb") as stream:
            _lock(stream.fileno())
        return False
    except OSError:
        return True


def _read(file: Path) -> Demonstration | None:
    """The piece in a file; None if it has fewer than the two rows that a piece needs."""
    lines = read_whole(file, "the open piece").split(b"\n")[:-1]  # behind the last line end is half a line
    if not lines:
        return None
    head: dict[str, Any] = json_value(lines[0], str(file))
    rows, about = [], {}
    for line in lines[1:]:
        entry = json_value(line, str(file))
        if isinstance(entry, list):
            rows.append(entry)
        else:
            about = entry
    if len(rows) < 2:  # noqa: PLR2004 - one transition
        return None
    table = pd.DataFrame(np.array(rows, dtype=float), columns=head["columns"])
    table.insert(0, TIME, TICK * np.arange(len(rows), dtype=float))
    for edge, frames in about.get("marks", {}).items():
        table[edge] = flags(bool(about["before"][edge]), [f - about["first"] for f in frames], len(rows))
    return Demonstration(table, head["units"], file.name[1 : -len(_ENDING)])


def flags(before: bool, frames: list[int], rows: int) -> FloatArray:
    """Flags of a piece's rows that flip at the first tick from each frame on, shape (rows,)."""
    ticks = np.ceil(np.array(frames) / FRAMES_PER_TICK)
    flips = (np.arange(rows)[:, None] >= ticks).sum(axis=1)
    return np.asarray((before + flips) % 2, dtype=float)


__all__ = ["OpenRecord", "OpenScript", "flags", "left_behind", "save_left_behind"]
