"""What one-tick predictions leave of pieces, in units of their own predicted spread."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ichain_drake.demonstrations import Demonstration, collect_transitions
from ichain_drake.errors import InputError
from ichain_drake.graph import Interaction
from ichain_drake.learning.chain.chain import LearnedChain
from ichain_drake.learning.data import Piece, collect
from ichain_drake.learning.model import InteractionModel
from ichain_drake.learning.spreads import acted_on, spread_of
from ichain_drake.state import BoolArray, FloatArray


class Part(NamedTuple):
    """Rows whose predictive spread is decided by the same.

    Attributes:
        child: the object.
        variable: index of its variable.
        source: the interaction whose effect decides; None where passive dynamics do.
    """

    child: str
    variable: int
    source: Interaction | None


@dataclass(frozen=True)
class Scores:
    """Residuals of one part, in n rows.

    Attributes:
        sizes: of each residual over its predicted spread, shape (n,).
        acting: whether an effect acts on the variable, shape (n,).
    """

    sizes: FloatArray
    acting: BoolArray


def tick_scores(model: InteractionModel, pieces: Sequence[Demonstration]) -> dict[Part, Scores]:
    """Residuals of every part of a model, of one tick from reading to reading.

    What acts is taken from the pieces' flags: it is asked how far a change is off, and not whether there is one.
    Variables that can't change gradually are left out: an interval says nothing about them.

    Args:
        model: the learned model; of a chain, its links are asked, in the coordinates in which they code a change.
        pieces: with flags, or, of a chain, as it is learned from.

    Raises:
        InputError: if there is no piece, or one can't be read as the graph's.
    """
    if not pieces:
        raise InputError("no pieces to compare predictions with; give some that the model was not learned from")
    found: dict[Part, list[tuple[FloatArray, BoolArray]]] = {}
    rows = _of_graph(model, pieces) if model.chain is None else _of_chain(model.chain, pieces)
    for part, sizes, acting in rows:
        found.setdefault(part, []).append((sizes, acting))
    return {
        part: Scores(np.concatenate([s for s, _ in parts]), np.concatenate([a for _, a in parts]))
        for part, parts in sorted(found.items(), key=lambda item: _order(model, item[0]))
    }


def _order(model: InteractionModel, part: Part) -> tuple[int, int, int]:
    place = -1 if part.source is None else model.graph.interactions.index(part.source)
    return list(model.graph.objects).index(part.child), part.variable, place


Rows = Iterator[tuple[Part, FloatArray, BoolArray]]


def _of_graph(model: InteractionModel, pieces: Sequence[Demonstration]) -> Rows:
    graph = model.graph
    for piece in collect(pieces, graph, graph.interactions).pieces:
        now = {n: s[:-1] for n, s in piece.states.items()}
        flags = {e: f[1:] for e, f in piece.flags.items()}
        ahead, _ = model.step(now, {r: piece.states[r][1:] for r in graph.roots}, flags, strict=False)
        for child in graph.objects:
            if child not in graph.roots:
                yield from _of_object(model, piece, child, ahead[child])


def _of_object(model: InteractionModel, piece: Piece, child: str, ahead: FloatArray) -> Rows:
    space, passive = model.graph.objects[child].observable, model.passive[child]
    incoming = model.graph.incoming(child)
    off = np.abs(space.difference(piece.states[child][1:], ahead))
    on = np.stack([piece.flags[e][1:] for e in incoming], axis=1)
    changed = acted_on(passive, incoming, model.edges)
    for pattern in np.unique(on, axis=0):
        rows = (on == pattern).all(axis=1)
        active = {e: model.edges[e] for e, acts in zip(incoming, pattern, strict=True) if acts}
        spread, source = spread_of(passive, active, model.noise[child])
        for i in np.flatnonzero(~space.jump_mask):
            acting = any(i in changed[e] for e in active)
            sizes = off[rows, i] / max(spread[i], np.finfo(float).tiny)
            yield Part(child, int(i), source[i]), sizes, np.full(len(sizes), acting)


def _of_chain(chain: LearnedChain, pieces: Sequence[Demonstration]) -> Rows:
    for link in chain.links:
        data, model = collect_transitions(pieces, chain.graph, link.interaction), link.forward.model
        states = data.child, data.parent, data.parent_next
        off = np.abs(model.code.encode(data.child, data.child_next) - model.frozen.batch(model.inputs(*states)))
        sizes = off / np.maximum(model.spread(*states), np.finfo(float).tiny)
        for i in np.flatnonzero(~data.child_space.jump_mask):
            yield Part(link.interaction.child, int(i), link.interaction), sizes[:, i], np.ones(len(off), dtype=bool)
