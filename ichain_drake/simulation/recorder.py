"""Recording a demonstration: a world under a demonstrator's commands, tabulated at every tick."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd
from pydrake.systems.framework import LeafSystem

from ichain_drake.demonstrations.columns import COMMAND, TIME, column
from ichain_drake.demonstrations.table import Demonstration
from ichain_drake.graph import InteractionGraph
from ichain_drake.simulation.episode import Episode, EpisodeLog
from ichain_drake.simulation.interruption import deferred_interrupt
from ichain_drake.simulation.noting import Noting
from ichain_drake.state import FloatArray
from ichain_drake.timing import FRAMES_PER_TICK, TICK
from ichain_drake.world.world import World


class RecordingInterrupted(KeyboardInterrupt):
    """Ctrl-C in the middle of a demonstration.

    Attributes:
        piece: what was recorded up to then.
    """

    def __init__(self, piece: Demonstration) -> None:
        super().__init__("interrupted")
        self.piece = piece


def whole_frames(log: EpisodeLog) -> EpisodeLog:
    """A log without a last frame that only some of its ports have: Ctrl-C may fall between two of them."""
    logged = [log.times, log.command, *log.states.values(), *log.measured.values(), *log.active.values()]
    logged += [*log.extra.values(), *([] if log.plant_positions is None else [log.plant_positions])]
    return part_of(log, 0, min(len(values) for values in logged))


def part_of(log: EpisodeLog, first: int, end: int) -> EpisodeLog:
    """The rows of a log from one to before another."""
    rows = slice(first, end)

    def cut(port: Mapping[str, FloatArray]) -> dict[str, FloatArray]:
        return {name: values[rows] for name, values in port.items()}

    return EpisodeLog(
        log.times[rows],
        cut(log.states),
        cut(log.measured),
        cut(log.active),
        log.command[rows],
        None if log.plant_positions is None else log.plant_positions[rows],
        cut(log.extra),
    )


def record(
    world: World,
    commander: LeafSystem,
    ticks: int,
    objects: Sequence[str],
    name: str,
) -> Demonstration:
    """Run a world under a demonstrator and tabulate what was measured at each tick.

    Args:
        world: the world; its default context is where the piece starts.
        commander: sends hand commands.
        ticks: transitions to record.
        objects: whose measurements go into the table; commands are recorded if the robots are among them.
        name: of the piece.

    Returns:
        A table of ticks + 1 rows.

    Raises:
        RecordingInterrupted: on Ctrl-C, with what was recorded up to then.
    """
    episode, noting = Episode(world, commander), Noting()

    def note(running: Episode) -> bool:
        notebook = noting.due()
        if notebook is not None:
            log = running.log()
            rows = (len(log.times) - 2) // FRAMES_PER_TICK + 1  # the last command of a row is in the frame behind it
            if rows > notebook.rows:
                notebook.add(rows_of(world.graph, log, objects, name, notebook.rows, rows))
        return pressed()

    try:
        with deferred_interrupt() as pressed:
            episode.run(ticks, note)
        interrupted = pressed()
    except KeyboardInterrupt:  # the second
        interrupted = True
    if interrupted:
        raise RecordingInterrupted(tabulate(world.graph, whole_frames(episode.log()), objects, name))
    return tabulate(world.graph, episode.log(), objects, name)


def rows_of(
    graph: InteractionGraph, log: EpisodeLog, objects: Sequence[str], name: str, done: int, end: int, first: int = 0
) -> Demonstration:
    """The rows of a piece from one to before another, from the log of an episode that still runs.

    Args:
        graph, objects, name: as for `tabulate`.
        log: of the world, a row per frame; it goes at least a frame beyond the last row.
        done, end: the first row, and the one behind the last.
        first: frame of the piece's first row, a tick.
    """
    begin = first + done * FRAMES_PER_TICK
    return tabulate(graph, part_of(log, begin, first + (end - 1) * FRAMES_PER_TICK + 2), objects, name)


def tabulate(graph: InteractionGraph, log: EpisodeLog, objects: Sequence[str], name: str) -> Demonstration:
    """A table of a log whose first row is a tick: what was measured at each tick, commands, and active flags.

    Args:
        graph: the interaction graph.
        log: of the world, a row per frame.
        objects: whose measurements go into the table; commands are recorded if the robots are among them.
        name: of the piece.
    """
    rows = slice(0, None, FRAMES_PER_TICK)
    count = len(log.times[rows])
    data: dict[str, FloatArray] = {TIME: TICK * np.arange(count, dtype=np.float64)}
    units: dict[str, str] = {}
    for obj in objects:
        for i, variable in enumerate(graph.objects[obj].observable.variables):
            data[column(obj, variable.name)] = log.measured[obj][rows, i]
            units[column(obj, variable.name)] = variable.unit
    if set(graph.roots) <= set(objects):
        # Logged just before the update of the same instant: the command in force from a row on is in the next frame.
        after = np.minimum(np.arange(count) * FRAMES_PER_TICK + 1, len(log.times) - 1)
        for i, variable in enumerate(graph.command.variables):
            data[column(COMMAND, variable.name)] = log.command[after, i]
            units[column(COMMAND, variable.name)] = variable.unit
    for edge in graph.interactions:
        if edge.child in objects and edge.parent in objects:
            index = graph.parents(edge.child).index(edge.parent)
            data[edge.name] = log.active[edge.child][rows, index]
    return Demonstration(pd.DataFrame(data), units, name)
