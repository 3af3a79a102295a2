"""Skills: paths of the robot that activate or deactivate one of its interactions (paper sec. V, appendix B).

A learned skill is a demonstrated switching event with the few ticks before and after it, which carry the direction of
the approach and of the retreat. It is moved with the object through the learned alignment, and of all events that one
is taken which the learned classifier is surest about.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from ichain_drake.control.planning.frames import Frames
from ichain_drake.control.planning.model import GraphModel
from ichain_drake.control.planning.plan import States
from ichain_drake.control.planning.travel import jumping
from ichain_drake.demonstrations import Demonstration
from ichain_drake.errors import InputError
from ichain_drake.graph import Interaction
from ichain_drake.learning.status.events import SwitchingWindow
from ichain_drake.state import FloatArray

SkillFunction = Callable[[States, int], FloatArray]
"""A designer's own skill: states now, shape (n_variables,) each, and the number of the attempt -> robot states to pass,
shape (n, n_root)."""

_BEFORE, _AFTER = 4, 3  # ticks around an event


@dataclass(frozen=True, eq=False)
class Skills:
    """How the robot's interactions are activated and deactivated.

    Attributes:
        activations, deactivations: demonstrated events of each interaction of the robot.
        own: functions in place of what was learned, by interaction and whether they activate.
    """

    activations: Mapping[Interaction, tuple[SwitchingWindow, ...]]
    deactivations: Mapping[Interaction, tuple[SwitchingWindow, ...]]
    own: Mapping[tuple[Interaction, bool], SkillFunction] = field(default_factory=dict)

    def path(
        self,
        model: GraphModel,
        edge: Interaction,
        activate: bool,
        states: States,
        attempt: int,
        prefer: FloatArray | None = None,
        first: int = 0,
    ) -> FloatArray:
        """Robot states to pass, shape (n, n_root), that should switch an interaction.

        Args:
            model: the learned graph.
            edge: an interaction of the robot.
            activate: or deactivate.
            states: now, shape (n_variables,) each; the robot's is its last command.
            attempt: number of the attempt, from 0; each takes another event.
            prefer: robot state in which the object should be taken, or let go of, shape (n_root,); None for any.
            first: rank of the event that the first attempt takes: the surest one, or the next after a failure.

        Raises:
            InputError: if no such event was demonstrated and no function is given.
        """
        if (edge, activate) in self.own:
            return np.asarray(self.own[edge, activate](states, attempt), dtype=float)
        windows = (self.activations if activate else self.deactivations).get(edge, ())
        if not windows:
            what = "activated" if activate else "deactivated"
            raise InputError(
                f"{edge.name}: it is {what} in no demonstration; add a piece, or give a function as a skill"
            )
        paths = [_moved(model, edge, w, states, activate, here=prefer is not None) for w in windows]
        order = _ranking(model, edge, windows, paths, states, activate, prefer)
        return paths[order[(first + _spread(attempt, len(order))) % len(order)]]


def learn_skills(
    model: GraphModel,
    pieces: Sequence[Demonstration],
    own: Mapping[tuple[Interaction, bool], SkillFunction] | None = None,
    known: Skills | None = None,
) -> Skills:
    """Collect the switching events of the robot's interactions with their surroundings.

    Args:
        model: the learned graph.
        pieces: the demonstrations, with flags.
        own: a designer's functions in place of learned skills.
        known: events from before, which those of the pieces are added to.

    Raises:
        InputError: if a function is for something that is no interaction of the robot.
    """
    graph = model.graph
    mine = [e for e in graph.interactions if e.parent == graph.root]
    for edge, _ in own or {}:
        if edge not in mine:
            raise InputError(
                f"a skill is given for {edge.name}; skills belong to the robot's own interactions, "
                f"{', '.join(e.name for e in mine)}"
            )
    found: tuple[dict[Interaction, list[SwitchingWindow]], ...] = ({e: [] for e in mine}, {e: [] for e in mine})
    jumps = jumping(graph.objects[graph.root].observable)
    for piece in pieces:
        root = piece.states(graph.root, graph.objects[graph.root])
        for edge in mine:
            flags = piece.table[edge.name].to_numpy(dtype=float) > 0.5
            child = piece.states(edge.child, graph.objects[edge.child])
            switches = np.flatnonzero(flags[1:] != flags[:-1]) + 1
            for k, row in enumerate(switches):
                first = max(row - _BEFORE, switches[k - 1] if k else 0)
                # Nor do attempts that failed before belong to it: what jumps, jumps once.
                other = np.flatnonzero((root[first:row, jumps] != root[row - 1, jumps]).any(axis=1))
                first += int(other[-1]) + 1 if len(other) else 0
                last = min(row + _AFTER + 1, switches[k + 1] if k + 1 < len(switches) else len(flags))
                window = SwitchingWindow(root[first:last], child[row - 1], int(row - first))
                found[0 if flags[row] else 1][edge].append(window)
    before = ({}, {}) if known is None else (known.activations, known.deactivations)
    on, off = ({e: (*w, *was.get(e, ())) for e, w in part.items()} for part, was in zip(found, before, strict=True))
    return Skills(on, off, dict(own or {}))


def _spread(attempt: int, count: int) -> int:
    """First the best, then ever others: 0, a third, two thirds, one, ..."""
    return 0 if attempt == 0 else (attempt * max(1, count // 4) + attempt // 4) % count


def _moved(
    model: GraphModel, edge: Interaction, window: SwitchingWindow, states: States, activate: bool, *, here: bool
) -> FloatArray:
    """A window's path for the present states: relative to the object where its place matters.

    What is let go of `here` is let go of where the robot is, whether it is known how the object's place goes with it.
    """
    frames = Frames(model)
    path, relative = window.root.copy(), frames.goes_with(edge)
    if not relative and (activate or not here):
        return path if activate else path[max(window.event - 1, 0) :]
    if activate:
        return frames.along(edge.parent, path, edge.child, window.child, states[edge.child]) if relative else path
    # Away from where the robot is now: its grasp differs from the demonstrated one.
    last = max(window.event - 1, 0)
    kinds = model.graph.objects[edge.parent].observable.variables
    real = np.array([v.kind not in ("binary", "integer") for v in kinds])
    space = model.graph.objects[edge.parent].observable
    moved = states[edge.parent] + space.difference(path[last:], path[last])
    return np.where(real, moved, path[last:])[1:]


def _ranking(
    model: GraphModel,
    edge: Interaction,
    windows: Sequence[SwitchingWindow],
    paths: Sequence[FloatArray],
    states: States,
    activate: bool,
    prefer: FloatArray | None = None,
) -> list[int]:
    """Events in order of how sure the classifier is that the wanted status results, or of how near it leads."""
    root = model.graph.root
    ends = np.array([p[-1] for p in paths])
    batch = {n: np.repeat(np.asarray(states[n], dtype=float)[None], len(ends), axis=0) for n in model.graph.objects}
    batch[root] = ends
    if not activate:
        return [int(k) for k in np.argsort(model.decide(edge, batch), kind="stable")]
    # The object goes along once it is taken, so the row of the event itself is judged.
    batch[root] = np.array([p[min(w.event, len(p) - 1)] for p, w in zip(paths, windows, strict=True)])
    sure = model.decide(edge, batch)
    # An object that has to be switched (a level) is not yet so: the demonstrated one right after the event counts too.
    low, high = model.low[root], model.high[root]
    outside = ((ends < low - 1e-9) | (ends > high + 1e-9)).sum(axis=1)
    if prefer is not None:
        space = model.graph.objects[root].observable
        off = np.abs(space.difference(batch[root], prefer)) / np.maximum(model.step_limit[root], 1e-9)
        return [int(k) for k in np.lexsort((off[:, ~jumping(space)].max(axis=1), outside, sure < 0.0))]
    return [int(k) for k in np.lexsort((-sure, outside))]
