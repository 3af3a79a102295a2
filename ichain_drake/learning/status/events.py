"""Examples of (de)activation in the demonstrations: the states that a skill has to reach (paper appendix B)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ichain_drake.demonstrations import Demonstration
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning.data import GraphData
from ichain_drake.learning.settings import LEARNING
from ichain_drake.learning.status.scores import switches
from ichain_drake.state import FloatArray


@dataclass(frozen=True)
class Switching:
    """Rows around the events of one direction.

    Attributes:
        before: states of every object in the last row before, shape (n_events, n_variables).
        after: the same in the first row after.
        pieces: name of the piece of each event.
        rows: row of the piece's table that is the first after.
    """

    before: dict[str, FloatArray]
    after: dict[str, FloatArray]
    pieces: tuple[str, ...]
    rows: tuple[int, ...]

    def __len__(self) -> int:
        return len(self.rows)


@dataclass(frozen=True)
class EdgeExamples:
    """What the demonstrations show of one interaction.

    Attributes:
        activations, deactivations: see `Switching`.
        active: states of every object while it is active, evenly drawn, shape (n <= 200, n_variables).
        inactive: the same while it is inactive.
    """

    activations: Switching
    deactivations: Switching
    active: dict[str, FloatArray]
    inactive: dict[str, FloatArray]


@dataclass(frozen=True, eq=False)
class SwitchingWindow:
    """One demonstrated (de)activation with the few ticks around it.

    Attributes:
        root: robot states around the event, shape (n_rows, n_root).
        child: the object's state in the last row before the event, shape (n_child,).
        event: row of `root` that is the first after the event.
    """

    root: FloatArray
    child: FloatArray
    event: int


Windows = Mapping[Interaction, tuple[SwitchingWindow, ...]]
"""Demonstrated events of one direction, for each interaction of a robot."""


def collect_examples(data: GraphData, edge: Interaction) -> EdgeExamples:
    """All switching events of an interaction, and samples of both statuses."""
    found: list[list[tuple[int, int]]] = [[], []]
    for k, piece in enumerate(data.pieces):
        for rows, part in zip(switches(piece.flags[edge]), found, strict=True):
            part += [(k, int(r)) for r in rows]
    flag = data.flag(edge)
    return EdgeExamples(_switching(data, found[0]), _switching(data, found[1]), _drawn(data, flag), _drawn(data, ~flag))


def collect_windows(pieces: Sequence[Demonstration], graph: InteractionGraph) -> tuple[Windows, Windows]:
    """Activations and deactivations of the robots' interactions, each with its surroundings.

    Args:
        pieces: the demonstrations, with flags.
        graph: the interaction graph.
    """
    mine = [e for e in graph.interactions if graph.by_robot(e)]
    found: tuple[dict[Interaction, list[SwitchingWindow]], ...] = ({e: [] for e in mine}, {e: [] for e in mine})
    for piece in pieces:
        robots = {name: piece.states(name, graph.objects[name]) for name in graph.roots}
        for edge in mine:
            root, jumps = robots[edge.parent], graph.objects[edge.parent].observable.jump_mask
            flags = piece.table[edge.name].to_numpy(dtype=float) > 0.5
            child = piece.states(edge.child, graph.objects[edge.child])
            events = np.flatnonzero(flags[1:] != flags[:-1]) + 1
            for k, row in enumerate(events):
                first = max(row - LEARNING.look, events[k - 1] if k else 0)
                # Nor do attempts that failed before belong to it, or what was tried after it: what jumps, jumps once.
                other = np.flatnonzero((root[first:row, jumps] != root[row - 1, jumps]).any(axis=1))
                first += int(other[-1]) + 1 if len(other) else 0
                last = min(row + LEARNING.ticks + 1, events[k + 1] if k + 1 < len(events) else len(flags))
                again = np.flatnonzero((root[row:last, jumps] != root[row, jumps]).any(axis=1))
                last = row + int(again[0]) if len(again) else last
                window = SwitchingWindow(root[first:last], child[row - 1], int(row - first))
                found[0 if flags[row] else 1][edge].append(window)
    on, off = ({e: tuple(w) for e, w in part.items()} for part in found)
    return on, off


def _switching(data: GraphData, events: list[tuple[int, int]]) -> Switching:
    def at(obj: str, shift: int) -> FloatArray:
        rows = [data.pieces[k].states[obj][r + shift] for k, r in events]
        return np.array(rows, dtype=float).reshape(len(rows), len(data.spaces[obj]))

    return Switching(
        {n: at(n, -1) for n in data.spaces},
        {n: at(n, 0) for n in data.spaces},
        tuple(data.pieces[k].name for k, _ in events),
        tuple(r for _, r in events),
    )


def _drawn(data: GraphData, mask: np.ndarray) -> dict[str, FloatArray]:
    rows = np.flatnonzero(mask)
    if len(rows) > LEARNING.examples:
        rows = rows[np.linspace(0, len(rows) - 1, LEARNING.examples).round().astype(int)]
    return {n: data.stacked(n)[rows] for n in data.spaces}
