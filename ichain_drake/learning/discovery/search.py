"""Flags and edges of all objects out of a log of states: the search that labels and edges share."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ichain_drake.graph import Interaction
from ichain_drake.learning.blas import one_blas_thread
from ichain_drake.learning.discovery.flags import edge_flags
from ichain_drake.learning.discovery.log import Log, RawPiece, digest, make_log
from ichain_drake.learning.discovery.settings import DISCOVERY
from ichain_drake.learning.discovery.structure import Explained, Rival, certainty, explain
from ichain_drake.learning.effects.alignment import position_groups
from ichain_drake.state import BoolArray, FloatArray, StateSpace


@dataclass(frozen=True)
class FoundEdge:
    """An interaction that was found.

    Attributes:
        edge: which.
        gain: evidence on ticks that were left out [nat].
        confidence: probability that it acts at all, and that it isn't a rival that does.
        ticks: in which its effect shows.
        text: what it does and when, a line a term.
        rivals: other objects that explain the same ticks.
        on: per piece whether it is active, shape (n_rows,).
        open: per piece rows in which nothing would show whether it is, shape (n_rows,).
        gates: whether its parent only has a say in when another acts.
    """

    edge: Interaction
    gain: float
    confidence: float
    ticks: int
    text: tuple[str, ...]
    rivals: tuple[Rival, ...]
    on: Mapping[str, BoolArray]
    open: Mapping[str, BoolArray]
    gates: bool


def search(
    pieces: Sequence[RawPiece],
    spaces: Mapping[str, StateSpace],
    root: str,
    candidates: Collection[Interaction],
    required: Collection[Interaction] = (),
    say: Callable[[str], None] | None = None,
) -> list[FoundEdge]:
    """Gated effects of all objects, as interactions with their statuses.

    Args:
        pieces: logs.
        spaces: observable state space per object.
        root: the robot, on which nothing acts.
        candidates: interactions that there may be.
        required: of these, those that surely are.
        say: called with a line before each object.
    """
    tell = say or (lambda line: None)
    turns: dict[str, FloatArray] = {}
    logs: dict[tuple[int, ...], Log] = {}
    out: list[FoundEdge] = []
    with one_blas_thread():
        for child in _in_order(pieces, spaces, root, candidates):
            tell(f"what acts on {child}")
            having = _telling(pieces, child, root)
            log = logs.get(having) or _log(pieces, having, child, spaces, root, turns)
            if root in log.spaces:
                logs[having] = log
            parents = [e.parent for e in log.data.edges if e in candidates and e.child == child]
            if not parents:
                continue
            needed = [e.parent for e in required if e.child == child and e.parent in parents]
            found = explain(log, child, parents, needed)
            out += _edges(log, found)
    return out


def _in_order(
    pieces: Sequence[RawPiece], spaces: Mapping[str, StateSpace], root: str, candidates: Collection[Interaction]
) -> list[str]:
    """Objects with a place first: they show how frames are turned; else by their numbers, not by their names."""
    children = [n for n in spaces if n != root and any(e.child == n for e in candidates)]
    children = [n for n in children if any(n in p.states for p in pieces)]
    key = {n: digest(np.vstack([p.states[n] for p in pieces if n in p.states])) for n in children}
    return sorted(children, key=lambda n: (not position_groups(spaces[n]), key[n]))


def _telling(pieces: Sequence[RawPiece], child: str, root: str) -> tuple[int, ...]:
    """Pieces about a child: those that hold the robot, where any does; else what the robot did isn't seen there."""
    having = [i for i, p in enumerate(pieces) if child in p.states and len(p.states) > 1]
    return tuple(i for i in having if root in pieces[i].states) or tuple(having)


def _log(
    pieces: Sequence[RawPiece],
    having: tuple[int, ...],
    child: str,
    spaces: Mapping[str, StateSpace],
    root: str,
    turns: dict[str, FloatArray],
) -> Log:
    """Ticks of some pieces with the objects that all of them hold; without the robot another stands for it."""
    chosen = [pieces[i] for i in having]
    names = [n for n in spaces if all(n in p.states for p in chosen)]
    top = root if root in names else next((n for n in names if n != child), child)
    return make_log(chosen, {n: spaces[n] for n in names}, top, turns)


def _edges(log: Log, found: Explained) -> list[FoundEdge]:
    child, names = found.residual.child, found.residual.space.names
    out = []
    for edge, flags in edge_flags(log, found).items():
        own = [(t, r) for t, r in zip(found.terms, found.rivals, strict=True) if t.parent == edge.parent]
        about = own or [(t, ()) for t in found.terms if edge.parent in t.objects and t.parent != edge.parent]
        shows = np.any([t.on & (t.evidence > DISCOVERY.shows) for t, _ in about], axis=0)
        rivals = {r.parent: r for _, others in about for r in others if r.parent != child}
        confidence = max(certainty(t.left_out, log) for t, _ in about)
        confidence *= 1.0 - max([0.0, *(r.probability for r in rivals.values())])
        names_of = [p.name for p in log.data.pieces]
        out.append(
            FoundEdge(
                edge,
                float(sum(t.gain for t, _ in about)),
                confidence,
                int(shows.sum()),
                tuple(t.text(names) for t, _ in about),
                tuple(rivals.values()),
                dict(zip(names_of, log.split(flags.on), strict=True)),
                dict(zip(names_of, log.split(flags.open), strict=True)),
                not own,
            )
        )
    return out
