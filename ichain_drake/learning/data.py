"""Demonstration pieces as arrays in a canonical order.

Models must not depend on names, on the order of variables, objects and edges, or on the order of the pieces. So all of
them are sorted by a digest of their numbers: the same numbers are then added in the same order, and a renamed and
shuffled scenario learns the same models to the last bit.
"""

from __future__ import annotations

import hashlib
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ichain_drake.demonstrations import Demonstration
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning.checks import check_contradictions, check_flags, check_pieces
from ichain_drake.state import BoolArray, FloatArray, StateSpace


@dataclass(frozen=True)
class Piece:
    """One demonstration as arrays.

    Attributes:
        name: what errors and reports call it.
        states: measured states per object, shape (n_rows, n_variables), variables in declared order.
        flags: whether each interaction is active, shape (n_rows,).
        open: rows in which nothing shows it, of interactions whose flags were inferred, shape (n_rows,).
    """

    name: str
    states: dict[str, FloatArray]
    flags: dict[Interaction, BoolArray]
    open: dict[Interaction, BoolArray] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(next(iter(self.flags.values())))


@dataclass(frozen=True)
class GraphData:
    """All pieces; tuples are in canonical order.

    Attributes:
        graph: the interaction graph.
        spaces: observable state space per object.
        pieces: the pieces.
        edges: the interactions.
        variables: indices of each object's variables.
        copies: names of pieces that were left out, with the name of the piece whose numbers they repeat.
    """

    graph: InteractionGraph
    spaces: dict[str, StateSpace]
    pieces: tuple[Piece, ...]
    edges: tuple[Interaction, ...]
    variables: dict[str, tuple[int, ...]]
    copies: dict[str, str] = field(default_factory=dict)

    def incoming(self, child: str) -> tuple[Interaction, ...]:
        """Interactions that act on an object, in canonical order."""
        return tuple(e for e in self.edges if e.child == child)

    def stacked(self, obj: str) -> FloatArray:
        """States of an object over all pieces, shape (n_rows_total, n_variables)."""
        return np.vstack([p.states[obj] for p in self.pieces])

    def flag(self, edge: Interaction) -> BoolArray:
        """Flags of an edge over all pieces, shape (n_rows_total,)."""
        return np.concatenate([p.flags[edge] for p in self.pieces])

    def piece_index(self) -> NDArray[np.intp]:
        """Index of the piece of each stacked row, shape (n_rows_total,)."""
        return np.repeat(np.arange(len(self.pieces)), [len(p) for p in self.pieces])


def collect(pieces: Sequence[Demonstration], graph: InteractionGraph, known: Collection[Interaction] = ()) -> GraphData:
    """Check pieces and turn them into arrays.

    Args:
        pieces: tables with all objects and a flag column per interaction.
        graph: the interaction graph.
        known: interactions that they need not show.

    Raises:
        InputError: see `checks`; one line that names piece, edge and remedy.
    """
    check_pieces(pieces, graph)
    spaces = {name: space.observable for name, space in graph.objects.items()}
    read = [
        Piece(
            p.name,
            {n: np.ascontiguousarray(p.states(n, s)) for n, s in graph.objects.items()},
            {e: p.table[e.name].to_numpy(dtype=float) > 0.5 for e in graph.interactions},
            {e: np.asarray(p.open[e.name], dtype=bool) for e in graph.interactions if e.name in p.open},
        )
        for p in pieces
    ]
    names = [p.name for p in read]
    flags = {e: [p.flags[e] for p in read] for e in graph.interactions}
    check_flags(names, {e: parts for e, parts in flags.items() if e not in known})
    check_contradictions(names, flags, {n: [p.states[n] for p in read] for n in spaces}, graph)

    # What one piece says must not be counted twice, nor be left out and known from the other.
    first: dict[tuple[tuple[str, ...], ...], str] = {}
    copies = {p.name: first[k] for p in read if first.setdefault(k := _piece_key(p, graph.roots), p.name) != p.name}
    read = [p for p in read if p.name not in copies]
    ordered = tuple(sorted(read, key=lambda p: _piece_key(p, graph.roots)))
    keys = {
        n: [_digest(np.concatenate([p.states[n][:, i] for p in ordered])) for i in range(len(space))]
        for n, space in spaces.items()
    }
    variables = {n: tuple(sorted(range(len(k)), key=k.__getitem__)) for n, k in keys.items()}
    edge_keys = {
        e: (_digest(np.concatenate([p.flags[e] for p in ordered])), sorted(keys[e.child]), sorted(keys[e.parent]))
        for e in graph.interactions
    }
    edges = tuple(sorted(graph.interactions, key=lambda e: edge_keys[e]))
    return GraphData(graph, spaces, ordered, edges, variables, copies)


def _digest(values: NDArray) -> str:
    return hashlib.sha256(np.ascontiguousarray(values).tobytes()).hexdigest()


def _piece_key(piece: Piece, roots: Collection[str]) -> tuple[tuple[str, ...], ...]:
    """The robots and the flags first: no camera turns their numbers, so that it doesn't reorder the pieces either."""
    own = [_digest(column) for root in roots for column in piece.states[root].T]
    own += [_digest(f) for f in piece.flags.values()]
    others = [_digest(column) for name, states in piece.states.items() if name not in roots for column in states.T]
    return tuple(sorted(own)), tuple(sorted(others))
