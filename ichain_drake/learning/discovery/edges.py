"""Edges: an interaction graph out of logs of states, with a confidence per edge and what the data can't tell apart."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from ichain_drake.errors import InputError
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning.discovery.log import RawPiece
from ichain_drake.learning.discovery.search import FoundEdge, search
from ichain_drake.learning.noise import change_noise
from ichain_drake.learning.settings import LEARNING
from ichain_drake.state import StateSpace


@dataclass(frozen=True)
class Prior:
    """What is known about a graph beforehand.

    Attributes:
        forbidden: interactions that there can't be.
        required: interactions that there are.
        no_cause: objects that act on nothing.
    """

    forbidden: frozenset[Interaction] = frozenset()
    required: frozenset[Interaction] = frozenset()
    no_cause: frozenset[str] = frozenset()

    def check(self, spaces: Mapping[str, StateSpace], root: str) -> None:
        """Refuse what can't be.

        Raises:
            InputError: on an unknown object, an edge that is both forbidden and required, or one that acts on the
                robot.
        """
        named = [n for e in (*self.forbidden, *self.required) for n in (e.parent, e.child)] + list(self.no_cause)
        for name in named:
            if name not in spaces:
                raise InputError(f"there is no object {name!r} in the logs; objects are {', '.join(spaces)}")
        for edge in self.required:
            if edge in self.forbidden or edge.parent in self.no_cause:
                raise InputError(f"{edge.name} is required and ruled out; give one of the two")
            if edge.child in (root, edge.parent):
                raise InputError(f"{edge.name} is required, but nothing acts on the robot, and no object on itself")

    def allows(self, edge: Interaction) -> bool:
        """Whether there may be an interaction."""
        return edge not in self.forbidden and edge.parent not in self.no_cause


@dataclass(frozen=True)
class DiscoveredGraph:
    """A graph as logs of states tell it.

    Attributes:
        spaces: state space per object of the logs.
        root: the robot.
        found: the interactions, surest first.
        free: objects on which nothing acts, as far as the logs show; they are no part of the graph.
        still: objects that never change.
        notes: what else is to be known about the logs, a line each.
        rows: of all pieces.
    """

    spaces: Mapping[str, StateSpace]
    root: str
    found: tuple[FoundEdge, ...]
    free: tuple[str, ...]
    still: tuple[str, ...]
    notes: tuple[str, ...] = field(default=())
    rows: int = 0

    def graph(self) -> InteractionGraph:
        """The interaction graph of the objects that the robot reaches.

        Raises:
            InputError: if nothing was found.
        """
        reached = {self.root}
        while more := {f.edge.child for f in self.found if f.edge.parent in reached} - reached:
            reached |= more
        edges = [f.edge for f in self.found if f.edge.parent in reached]
        if not edges:
            raise InputError(f"no interaction of {self.root} shows in the logs; record pieces in which it acts")
        return InteractionGraph({n: s for n, s in self.spaces.items() if n in reached}, edges)


def discover_graph(
    pieces: Sequence[RawPiece],
    spaces: Mapping[str, StateSpace],
    root: str,
    prior: Prior | None = None,
    say: Callable[[str], None] | None = None,
) -> DiscoveredGraph:
    """Which objects act on which, out of states alone.

    Args:
        pieces: logs; each holds some of the objects.
        spaces: observable state space per object.
        root: the robot.
        prior: what is known beforehand.
        say: called with a line before each object.

    Raises:
        InputError: on a prior that can't be, or an unknown robot.
    """
    prior = prior or Prior()
    if root not in spaces:
        raise InputError(f"there is no object {root!r} in the logs to be the robot; objects are {', '.join(spaces)}")
    prior.check(spaces, root)
    still = tuple(n for n in spaces if n != root and _never_changes(pieces, n, spaces[n]))
    moving = [n for n in spaces if n not in still]
    pairs = [Interaction(a, b) for b in moving if b != root for a in moving if a != b]
    lost = [e for e in prior.required if e.parent in still or e.child in still]
    if lost:
        raise InputError(f"{lost[0].name} is required, but one of the two never changes in the logs")
    found = search(
        [RawPiece(p.name, {n: s for n, s in p.states.items() if n in moving}) for p in pieces],
        {n: spaces[n] for n in moving},
        root,
        _allowed(pairs, prior),
        prior.required,
        say,
    )
    children = {f.edge.child for f in found}
    return DiscoveredGraph(
        spaces=spaces,
        root=root,
        found=tuple(sorted(found, key=lambda f: -f.confidence)),
        free=tuple(n for n in moving if n != root and n not in children),
        still=still,
        notes=tuple(_copied(pieces, spaces)),
        rows=sum(len(p) for p in pieces),
    )


def _allowed(pairs: Collection[Interaction], prior: Prior) -> list[Interaction]:
    return [e for e in pairs if prior.allows(e)]


def _never_changes(pieces: Sequence[RawPiece], obj: str, space: StateSpace) -> bool:
    """Whether no variable of an object ever changes within a piece, or by no more than its readings' noise at all.

    What stands still in all pieces is as good as the ground: to be somewhere relative to it is to be somewhere.
    """
    parts = [p.states[obj] for p in pieces if obj in p.states]
    if not any(np.ptp(x, axis=0).any() for x in parts):
        return True
    parts = [x for x in parts if len(x) > 2]  # noqa: PLR2004 - two differences need three
    if not parts:
        return False
    noise, every = change_noise(space, parts), np.vstack(parts)
    away = np.abs(space.difference(every, np.median(every, axis=0)))
    rests = (away < LEARNING.plain * noise) & (np.sqrt(np.mean(away**2, axis=0)) < LEARNING.moving * noise)
    noisy = np.array([v.kind in ("real", "angle") for v in space.variables])
    return bool(((rests & noisy) | (away == 0)).all())


def _copied(pieces: Sequence[RawPiece], spaces: Mapping[str, StateSpace]) -> list[str]:
    """Columns that are copies of another object's, in words: which of the two acts can't be told."""
    out = []
    columns = [(n, i) for n, space in spaces.items() for i in range(len(space))]
    for k, (a, i) in enumerate(columns):
        for b, j in columns[k + 1 :]:
            both = [p for p in pieces if a in p.states and b in p.states] if a != b else []
            values = [(p.states[a][:, i], p.states[b][:, j]) for p in both]
            if values and any(np.ptp(x) > 0 for x, _ in values) and all(np.array_equal(x, y) for x, y in values):
                first, second = f"{a}.{spaces[a].names[i]}", f"{b}.{spaces[b].names[j]}"
                out.append(f"{second} repeats {first} to the last digit; leave one of the columns out")
    return out
