"""Logs of many runs that are calculated together, a row each 30 Hz frame."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from ichain_drake.simulation.episode import EpisodeLog
from ichain_drake.state import FloatArray, IntArray
from ichain_drake.timing import FRAME, FRAMES_PER_TICK

Frame = Mapping[str, FloatArray]
"""What is logged of a frame by name, shape (n_running, width) each."""


class RunLogs:
    """What is logged of every run.

    Args:
        ticks: of each, at most.
        states: at the start, shape (n_runs, n_variables) each.
        command: before the first decision, shape (n_runs, n_hand), or (1, n_hand) for all.
        active: at the start, shape (n_runs, n_parents) each; nothing if that is not logged.
    """

    def __init__(self, runs: int, ticks: int, states: Frame, command: FloatArray, active: Frame | None = None) -> None:
        rows = ticks * FRAMES_PER_TICK + 1
        tables = (states, active or {})
        self._tables = [{n: np.empty((runs, rows, v.shape[1])) for n, v in table.items()} for table in tables]
        self._command = np.empty((runs, rows, command.shape[1]))
        self._last = np.zeros(runs, dtype=np.intp)
        self._command[:, 0] = command
        for kept, table in zip(self._tables, tables, strict=True):
            for name, values in table.items():
                kept[name][:, 0] = values

    @property
    def states(self) -> Mapping[str, FloatArray]:
        """All runs' states, shape (n_runs, n_frames, n_variables) each; rows that were not run hold anything."""
        return self._tables[0]

    def add(self, runs: IntArray, tick: int, frames: Iterable[tuple[Frame, Frame]], command: FloatArray) -> None:
        """A tick of some of the runs: states, and what is active, of its frames; and the command in force."""
        begin = tick * FRAMES_PER_TICK + 1
        self._last[runs] = begin + FRAMES_PER_TICK - 1
        self._command[runs, begin : begin + FRAMES_PER_TICK] = command[:, None]
        for k, tables in enumerate(frames):
            for kept, table in zip(self._tables, tables, strict=True):
                for name, log in kept.items():
                    log[runs, begin + k] = table[name]

    def of(self, run: int) -> EpisodeLog:
        """The log of one run: views, for copies of many long runs would take as much memory again."""
        rows = slice(self._last[run] + 1)
        states, active = ({name: log[run, rows] for name, log in table.items()} for table in self._tables)
        times = np.arange(self._last[run] + 1) * FRAME
        return EpisodeLog(times, states, {}, active, self._command[run, rows])
