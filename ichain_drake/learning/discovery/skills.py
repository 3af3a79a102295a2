"""Skills that recordings show: what was done between two switches of statuses, from where, and what it changed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ichain_drake.demonstrations import Demonstration
from ichain_drake.graph import InteractionGraph
from ichain_drake.learning.discovery.inputs import is_change
from ichain_drake.learning.noise import change_noise
from ichain_drake.learning.settings import LEARNING
from ichain_drake.state import FloatArray

REST = "nothing"
"""Name of stretches in which no interaction is active."""


@dataclass(frozen=True)
class Stretch:
    """Rows of a piece in which all statuses stay the same.

    Attributes:
        piece: its name.
        first, last: rows, from 0.
        active: names of the active interactions.
        before: of those that were active in the row before; None at the start of a piece.
    """

    piece: str
    first: int
    last: int
    active: tuple[str, ...]
    before: tuple[str, ...] | None


@dataclass(frozen=True)
class ShownSkill:
    """A set of interactions that were active together, and what that did.

    Attributes:
        name: of the interactions; a person may give it another.
        active: names of the interactions.
        shown: where.
        precondition: what held in each of them just before: statuses, and variables within a part of their range.
        effect: what changed from their start to their end, in most of them.
    """

    name: str
    active: tuple[str, ...]
    shown: tuple[Stretch, ...]
    precondition: tuple[str, ...]
    effect: tuple[str, ...]

    def __str__(self) -> str:
        """In one line."""
        when = " and ".join(self.precondition) or "anything"
        return f"{self.name}: {len(self.shown)} times; from {when}; {', '.join(self.effect) or 'changes nothing'}"

    def report(self) -> dict[str, Any]:
        """Plain numbers and texts, ready for JSON."""
        return {
            "name": self.name,
            "active": list(self.active),
            "precondition": list(self.precondition),
            "effect": list(self.effect),
            "shown": [{"piece": s.piece, "first_row": s.first, "last_row": s.last} for s in self.shown],
        }


def stretches(piece: Demonstration, graph: InteractionGraph) -> list[Stretch]:
    """Stretches between the switches of a piece; its flags are complete."""
    names = [e.name for e in graph.interactions]
    flags = piece.table[names].to_numpy(dtype=float) > 0.5  # noqa: PLR2004 - a flag
    marks = [0, *(np.flatnonzero((flags[1:] != flags[:-1]).any(axis=1)) + 1).tolist(), len(flags)]
    active = [tuple(n for n, on in zip(names, flags[a], strict=True) if on) for a in marks[:-1]]
    return [
        Stretch(piece.name, a, b - 1, now, before)
        for a, b, now, before in zip(marks[:-1], marks[1:], active, [None, *active[:-1]], strict=True)
    ]


def shown_skills(pieces: Sequence[Demonstration], graph: InteractionGraph) -> list[ShownSkill]:
    """Skills that pieces show, those that take most rows first.

    Args:
        pieces: with all objects, and complete flags.
        graph: the interaction graph.
    """
    groups: dict[tuple[str, ...], list[Stretch]] = {}
    for piece in pieces:
        for stretch in stretches(piece, graph):
            groups.setdefault(stretch.active, []).append(stretch)
    states = {n: {p.name: p.states(n, s) for p in pieces} for n, s in graph.objects.items()}
    noise = {n: change_noise(s.observable, list(states[n].values())) for n, s in graph.objects.items()}
    found = [
        ShownSkill(
            " + ".join(active) or REST,
            active,
            tuple(shown),
            (*_statuses(active, shown), *_values(graph, states, noise, active, shown)),
            tuple(_effects(graph, states, noise, shown)),
        )
        for active, shown in groups.items()
    ]
    return sorted(found, key=lambda s: (-sum(x.last - x.first + 1 for x in s.shown), s.name))


def _statuses(active: tuple[str, ...], shown: Sequence[Stretch]) -> list[str]:
    """Statuses that held before each of them."""
    known = [set(s.before) for s in shown if s.before is not None]
    if not known:
        return []
    always, never = set.intersection(*known), [n for n in active if not any(n in k for k in known)]
    return [f"{n} active" for n in sorted(always)] + [f"{n} inactive" for n in sorted(never)]


def _values(
    graph: InteractionGraph,
    states: dict[str, dict[str, FloatArray]],
    noise: dict[str, FloatArray],
    active: tuple[str, ...],
    shown: Sequence[Stretch],
) -> list[str]:
    """Variables of those who take part that were within a narrow part of their range at the start of each."""
    if len(shown) < LEARNING.few:
        return []
    out = []
    taking_part = {n for e in graph.interactions if e.name in active for n in (e.parent, e.child)}
    for name in (n for n in graph.objects if n in taking_part):
        space = graph.objects[name].observable
        every = np.vstack(list(states[name].values()))
        start = np.array([states[name][s.piece][s.first] for s in shown])
        for i, variable in enumerate(space.names):
            span, narrow = np.ptp(every[:, i]), np.ptp(start[:, i])
            if span > LEARNING.plain * noise[name][i] and narrow < LEARNING.reach * span and not is_change(space, i):
                out.append(f"{start[:, i].min():.3g} <= {name}.{variable} <= {start[:, i].max():.3g}")
    return out


def _effects(
    graph: InteractionGraph,
    states: dict[str, dict[str, FloatArray]],
    noise: dict[str, FloatArray],
    shown: Sequence[Stretch],
) -> list[str]:
    """Variables of all but the robot that changed in most of them: by how much (median) if always the same way."""
    out = []
    for name in (n for n in graph.objects if n != graph.root):
        space = graph.objects[name].observable
        ways = np.array(
            [space.difference(states[name][s.piece][s.last], states[name][s.piece][max(s.first - 1, 0)]) for s in shown]
        )
        for i, variable in enumerate(space.variables):
            middle = float(np.median(ways[:, i]))
            clear = LEARNING.clear * np.sqrt(2.0) * noise[name][i]
            same = np.mean(ways[:, i] * np.sign(middle) > clear)
            if is_change(space, i):
                continue
            if abs(middle) > clear and same >= LEARNING.kept:
                out.append(f"{name}.{variable.name} by {middle:+.3g}")
            elif np.mean(np.abs(ways[:, i]) > clear) > 0.5:  # noqa: PLR2004 - most of them
                out.append(f"{name}.{variable.name} either way")
    return out
