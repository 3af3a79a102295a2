"""Pieces that a person records: from a press of a button to the next, with marks for interactions, saved at once."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from ichain_drake.demonstrations import Demonstration, write_demonstrations
from ichain_drake.errors import InputError
from ichain_drake.files import write_whole
from ichain_drake.graph import InteractionGraph
from ichain_drake.runs.open_piece import OpenRecord, flags, left_behind
from ichain_drake.scenarios.seats import Seat
from ichain_drake.simulation.episode import Episode
from ichain_drake.simulation.recorder import part_of, rows_of, tabulate
from ichain_drake.timing import FRAMES_PER_TICK


@dataclass
class OpenPiece:
    """A piece that is being recorded.

    Attributes:
        name: of its file.
        first: frame of its first row, a tick; recording may have been asked for up to nine frames before.
        marks: frames at which the person flipped an interaction's flag, by the interaction's name.
        before: its flag before the first of them.
    """

    name: str
    first: int
    marks: dict[str, list[int]] = field(default_factory=dict)
    before: dict[str, bool] = field(default_factory=dict)

    def marked(self, edge: str) -> bool | None:
        """The flag that the person gave an interaction last; None without a mark."""
        return self.before[edge] ^ bool(len(self.marks[edge]) % 2) if edge in self.marks else None

    def rows(self, frame: int) -> int:
        """How many rows it has if it ends at a frame."""
        return (frame - self.first) // FRAMES_PER_TICK + 1 if frame >= self.first else 0


class PieceRecorder:
    """Begins, marks, drops and saves pieces.

    Once a person marks an interaction in a piece, all its flags in that piece are the person's: up to the first mark
    what the simulation says at that moment, flipped there and at every further mark. Interactions without a mark have
    the simulation's flags.

    Args:
        seat: what is driven; says whose measurements are recorded.
        graph: the interaction graph.
        folder: where pieces go, as `<seat>-<number>.parquet`, numbered on from those that are there, with what is known
            about their recording in a `.json` of the same name. While one is open, its rows are in a hidden file
            there; what an earlier process that was killed left of a piece is saved first (`recovered`).
        about: further entries of that file.
    """

    def __init__(self, seat: Seat, graph: InteractionGraph, folder: Path, about: Mapping[str, Any]) -> None:
        self._seat, self._graph, self._folder, self._about = seat, graph, folder, dict(about)
        self.open: OpenPiece | None = None
        self.saved: list[Demonstration] = []
        pattern = re.compile(rf"{re.escape(seat.name)}-(\d+)")
        known = [pattern.fullmatch(file.stem) for file in folder.glob("*.*")] if folder.is_dir() else []
        self._number = max((int(m[1]) for m in known if m), default=0)
        self._record: OpenRecord | None = None
        self.recovered = self._recover() if folder.is_dir() else []

    @property
    def edges(self) -> tuple[str, ...]:
        """Names of the interactions whose flags are recorded."""
        recorded = set(self._seat.objects)
        return tuple(e.name for e in self._graph.interactions if {e.parent, e.child} <= recorded)

    def _recover(self) -> list[Demonstration]:
        """Save what a killed process left."""
        pieces = []
        for file, piece in left_behind(self._folder):
            self._number += 1
            saved = replace(piece, name=f"{self._seat.name}-{self._number:03d}")
            try:
                saved.check(self._graph)
            except InputError:  # of another scenario
                self._number -= 1
                continue
            self._write(saved, {"ended_by": "the end of the process", "rows": len(saved)})
            file.unlink(missing_ok=True)
            pieces.append(saved)
        return pieces

    def _write(self, piece: Demonstration, about: Mapping[str, Any]) -> None:
        (file,) = write_demonstrations([piece], self._folder)
        write_whole(file.with_suffix(".json"), (json.dumps({**self._about, **about}, indent=2) + "\n").encode())

    def begin(self, frame: int) -> None:
        """Open a piece that begins with the first tick from a frame on."""
        self._number += 1
        while (self._folder / f"{self._seat.name}-{self._number:03d}.parquet").exists():
            self._number += 1  # another session's
        first = -(-frame // FRAMES_PER_TICK) * FRAMES_PER_TICK
        self.open = OpenPiece(f"{self._seat.name}-{self._number:03d}", first)

    def mark(self, edge: str, frame: int, active: bool) -> None:
        """Flip an interaction's flag from the next tick on; `active` is what the simulation says."""
        if self.open is not None:
            self.open.before.setdefault(edge, active)
            self.open.marks.setdefault(edge, []).append(frame)

    def note(self, episode: Episode, frame: int) -> None:
        """Put rows of the open piece on disk that are not there yet; to be called about once a second.

        Raises:
            InputError: if they can't be written.
        """
        if self.open is None:
            return
        rows = self.open.rows(frame - 1)  # the last command of a row is in the frame behind it
        done = 0 if self._record is None else self._record.rows
        if rows <= done:
            return
        if self._record is None:
            self._record = OpenRecord(self._folder, self.open.name)
        objects, first = self._seat.objects, self.open.first
        table = rows_of(self._graph, episode.log(), objects, self.open.name, done, rows, first)
        self._record.add(table, self.open.first, self.open.marks, self.open.before)

    def _close(self) -> None:
        """No piece is open any more."""
        self.open = None
        if self._record is not None:
            self._record.remove()
        self._record = None

    def drop(self) -> None:
        """Forget the open piece."""
        if self.open is not None:
            self._number -= 1
        self._close()

    def keep(self, episode: Episode, frame: int, sampling: Mapping[str, float], why: str) -> Demonstration | None:
        """End the open piece and save it.

        Args:
            episode: in which it was recorded.
            frame: the present one; the piece ends with the last tick up to it.
            sampling: see `FrameClock.sampling`.
            why: it ends.

        Returns:
            The piece; None if it has fewer than the two rows that a piece needs, and is dropped.

        Raises:
            InputError: if it can't be written; the piece stays open.
        """
        piece = self.open
        if piece is None:
            return None
        rows = piece.rows(frame)
        if rows < 2:  # noqa: PLR2004 - one transition
            self.drop()
            return None
        end = piece.first + (rows - 1) * FRAMES_PER_TICK + 1
        log = part_of(episode.log(), piece.first, end + 1)  # one more frame, if there is one: it has the last command
        table = tabulate(self._graph, log, self._seat.objects, piece.name)
        for edge, frames in piece.marks.items():
            table.table[edge] = flags(piece.before[edge], [f - piece.first for f in frames], rows)
        table.check(self._graph)
        about = {"ended_by": why, "rows": rows, "sampling": dict(sampling), "marked": sorted(piece.marks)}
        self._write(table, about)
        self._close()
        self.saved.append(table)
        return table
