"""Runs towards goals at once, in `ideal` physics: each decides for itself, and the worlds are calculated together."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from ichain_drake.control.execution.executor import Executor, Memory
from ichain_drake.control.planning.plan import States
from ichain_drake.simulation.episode import EpisodeLog
from ichain_drake.simulation.interruption import deferred_interrupt
from ichain_drake.simulation.run_logs import Frame, RunLogs
from ichain_drake.simulation.wiring import LOOK, start_command
from ichain_drake.state import FloatArray
from ichain_drake.world.rows import WorldRows
from ichain_drake.world.world import World


def look_together(worlds: Sequence[World]) -> list[States]:
    """`look` at each of several worlds; see `WorldRows`.

    Raises:
        NotTogetherError: if these worlds can't be calculated together.
    """
    rows, command = WorldRows(worlds), np.array([start_command(w) for w in worlds])
    readings = []
    for tick in range(LOOK):
        if tick:
            for _ in rows.frames(command):
                pass
        readings.append({n: rows.measured(n) for n in rows.states})
    each = {n: np.array([r[n] for r in readings]) for n in rows.states}
    return [{n: np.mean(list(v[:, k]), axis=0) for n, v in each.items()} for k in range(len(worlds))]


def act_together(
    worlds: Sequence[World], executors: Sequence[Executor], ticks: int
) -> list[tuple[EpisodeLog, Memory] | None]:
    """Let an executor act in each world until it stops.

    Args:
        worlds: see `WorldRows`.
        executors: one a world.
        ticks: at most so many.

    Returns:
        Of each run its log, without readings, and the executor's memory, to the last bit as a `GraphEpisode` has them;
        None where the executor raised: alone it does so again.

    Raises:
        NotTogetherError: if these worlds can't be calculated together.
        KeyboardInterrupt: on Ctrl-C.
    """
    commands = [start_command(w) for w in worlds]
    memories = [e.start(np.asarray(c, dtype=float)) for e, c in zip(executors, commands, strict=True)]
    rows = WorldRows(worlds)
    log = RunLogs(len(worlds), ticks, rows.states, np.array(commands), rows.active)
    running, failed = np.arange(len(worlds)), set[int]()
    with deferred_interrupt() as pressed:
        for tick in range(ticks):
            measured = {n: rows.measured(n) for n in rows.states}
            for row, k in enumerate(running.tolist()):
                memories[k] = memories[k].own()
                now = {n: values[row] for n, values in measured.items()}
                try:
                    commands[k] = executors[k].decide(memories[k], now, dict.fromkeys(now, True))
                except Exception:  # whatever it is, the run alone will show it
                    failed.add(k)
            command = np.array([commands[k] for k in running])
            log.add(running, tick, _frames(rows, command), command)
            if pressed():
                raise KeyboardInterrupt
            on = np.array([k not in failed and not memories[k].stopped for k in running])
            if not on.any():
                break
            if not on.all():
                running = running[on]
                rows.keep(on)
    return [None if k in failed else (log.of(k), memory) for k, memory in enumerate(memories)]


def _frames(rows: WorldRows, command: FloatArray) -> Iterator[tuple[Frame, Frame]]:
    for states in rows.frames(command):
        yield states, rows.active
