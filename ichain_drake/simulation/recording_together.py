"""Demonstrations of several worlds of one system recorded at once, in `ideal` physics: each as it is alone."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from ichain_drake.demonstrations.table import Demonstration
from ichain_drake.robot.ideal import IdealHand
from ichain_drake.simulation.episode import EpisodeLog
from ichain_drake.simulation.interruption import deferred_interrupt
from ichain_drake.simulation.noting import Noting
from ichain_drake.simulation.recorder import RecordingInterrupted, tabulate
from ichain_drake.simulation.watching import present_watcher
from ichain_drake.state import FloatArray
from ichain_drake.timing import FRAME, FRAMES_PER_TICK
from ichain_drake.world.rows import WorldRows
from ichain_drake.world.world import World


def nobody_looks() -> bool:
    """Whether nobody watches what is recorded, or keeps its rows, before it is whole."""
    return present_watcher() is None and Noting().notebook is None


def record_together(
    worlds: Sequence[World], commands: Sequence[FloatArray], objects: Sequence[str], names: Sequence[str]
) -> Iterator[Demonstration]:
    """What `record` makes of each world under `Commands`, to the last bit.

    Args:
        worlds: see `WorldRows`; their objects and robots are as they were made.
        commands: hand commands of each, shape (n_ticks, n_hand).
        objects: whose measurements go into the tables.
        names: of the pieces.

    Returns:
        The pieces in their order.

    Raises:
        NotTogetherError: if these worlds can't be calculated together; before the first piece.
        RecordingInterrupted: on Ctrl-C, after the pieces that were whole by then, with what there is of the next.
    """
    logs, whole = _run(worlds, commands)
    return _pieces(worlds[0], logs, whole, objects, names)


def _pieces(
    world: World, logs: Sequence[EpisodeLog], whole: Sequence[bool], objects: Sequence[str], names: Sequence[str]
) -> Iterator[Demonstration]:
    for log, done, name in zip(logs, whole, names, strict=True):
        piece = tabulate(world.graph, log, objects, name)
        if not done:
            raise RecordingInterrupted(piece)
        yield piece


def _run(worlds: Sequence[World], commands: Sequence[FloatArray]) -> tuple[list[EpisodeLog], list[bool]]:
    """The logs of all, and which of them are whole."""
    ticks = np.array([len(c) for c in commands])
    order = np.argsort(-ticks, kind="stable")  # so that those that still run are always the first
    rows = WorldRows([worlds[k] for k in order])
    sent = np.zeros((len(worlds), ticks.max(), commands[0].shape[1]))
    for row, k in enumerate(order):
        sent[row, : ticks[k]] = commands[k]
    length = ticks.max() * FRAMES_PER_TICK + 1
    states = {n: np.zeros((len(v), length, v.shape[1])) for n, v in rows.states.items()}
    active = {n: np.zeros((len(v), length, v.shape[1])) for n, v in rows.active.items()}

    def note(frame: int) -> None:
        for log, now in ((states, rows.states), (active, rows.active)):
            for name, values in now.items():
                log[name][: len(values), frame] = values

    note(0)
    done = 0
    with deferred_interrupt() as pressed:
        while done < ticks.max() and not pressed():
            running = np.arange(len(rows)) < np.count_nonzero(ticks > done)
            rows.keep(running)
            for frame, _ in enumerate(rows.frames(sent[: len(rows), done]), start=done * FRAMES_PER_TICK + 1):
                note(frame)
            done += 1
    logs: list[EpisodeLog] = []
    for world, own, row in zip(worlds, commands, np.argsort(order), strict=True):
        part = slice(min(len(own), done) * FRAMES_PER_TICK + 1)
        mine = ({n: v[row, part] for n, v in log.items()} for log in (states, active))
        logs.append(_log(world, own, *mine))
    return logs, (ticks <= done).tolist()


def _log(
    world: World, commands: FloatArray, states: Mapping[str, FloatArray], active: Mapping[str, FloatArray]
) -> EpisodeLog:
    """The log of one world as its Diagram would have written it."""
    numbers = np.arange(len(states[world.graph.root]))
    sensors = {n: o.readings for n, o in world.objects.items()}
    sensors |= {n: r.measurement.readings for n, r in world.robots.items() if isinstance(r, IdealHand)}
    measured = {n: sensors[n](v, numbers.tolist()) for n, v in states.items()}
    # Logged just before the update of the same instant: a command is in force from the next frame on.
    command = commands[np.maximum(numbers - 1, 0) // FRAMES_PER_TICK]
    return EpisodeLog(FRAME * numbers.astype(np.float64), states, measured, active, command)
