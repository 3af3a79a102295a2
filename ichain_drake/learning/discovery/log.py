"""States of unlabelled pieces as ticks, in an order that depends on numbers alone."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning.blocks import interleaved_blocks
from ichain_drake.learning.data import GraphData, Piece
from ichain_drake.learning.discovery.settings import DISCOVERY
from ichain_drake.learning.effects.alignment import position_groups
from ichain_drake.learning.noise import measurement_std
from ichain_drake.state import BoolArray, FloatArray, IntArray, StateSpace


@dataclass(frozen=True)
class RawPiece:
    """A piece as it came: states of the objects that it holds, and what is known of statuses.

    Attributes:
        name: what errors and reports call it.
        states: per object, shape (n_rows, n_variables).
        known: per interaction 1, 0 or NaN (not known), shape (n_rows,); interactions of which nothing is known are left
            out.
    """

    name: str
    states: Mapping[str, FloatArray]
    known: Mapping[Interaction, FloatArray] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(next(iter(self.states.values())))


@dataclass(frozen=True, eq=False)
class Log:
    """Pieces that hold the same objects, as ticks t -> t + 1; arrays over ticks have shape (n_ticks, ...).

    Attributes:
        data: the pieces, no interaction of which is flagged; edges are all pairs.
        root: the robot.
        noise: of readings per object, shape (n_variables,).
        states: per object, shape (n_rows, n_variables).
        piece: index of the piece of each row, shape (n_rows,).
        t: row at which each tick starts.
        back: the row before, or the same where there is none: a reading that starts a change is no input of it.
        fold, block: part in which each tick is left out, and the stretch of ticks that it belongs to.
        turns: how each frame's coordinates turn into the root's, as far as it is known; filled as it becomes so.
        known: statuses that are known at the ends of ticks, 1, 0 or NaN.
    """

    data: GraphData
    root: str
    noise: dict[str, FloatArray]
    states: dict[str, FloatArray]
    piece: IntArray
    t: IntArray
    back: IntArray
    fold: IntArray
    block: IntArray
    turns: dict[str, FloatArray]
    known: dict[Interaction, FloatArray]

    @property
    def spaces(self) -> dict[str, StateSpace]:
        """Observable state space per object."""
        return self.data.spaces

    @property
    def tick_piece(self) -> IntArray:
        """Index of the piece of each tick."""
        return self.piece[self.t]

    def rows_of(self, ticks: BoolArray) -> BoolArray:
        """Rows at the ends of ticks, shape (n_rows,); the first row of a piece goes with its first tick."""
        out = np.zeros(len(self.piece), dtype=bool)
        out[self.t + 1] = ticks
        first = np.flatnonzero(np.r_[True, self.piece[1:] != self.piece[:-1]])
        out[first] = out[np.minimum(first + 1, len(out) - 1)]
        return out

    def split(self, rows: NDArray) -> list[NDArray]:
        """Arrays over rows, one a piece."""
        return np.split(rows, np.cumsum([len(p) for p in self.data.pieces])[:-1])


def digest(values: NDArray) -> str:
    """What identifies numbers, whatever they are called."""
    return hashlib.sha256(np.ascontiguousarray(values).tobytes()).hexdigest()


def make_log(
    pieces: Sequence[RawPiece],
    spaces: Mapping[str, StateSpace],
    root: str,
    turns: dict[str, FloatArray],
) -> Log:
    """Ticks of pieces.

    Args:
        pieces: all of which hold all the objects of `spaces`.
        spaces: observable state space per object.
        root: the robot, or what stands for it.
        turns: see `Log`.
    """
    ordered = sorted(pieces, key=lambda p: tuple(sorted(digest(column) for column in p.states[root].T)))
    keys = {
        n: [digest(np.concatenate([p.states[n][:, i] for p in ordered])) for i in range(len(space))]
        for n, space in spaces.items()
    }
    variables = {n: tuple(sorted(range(len(k)), key=k.__getitem__)) for n, k in keys.items()}
    pairs = [Interaction(a, b) for b in spaces for a in spaces if b not in (a, root)]
    edges = sorted(pairs, key=lambda e: (sorted(keys[e.child]), sorted(keys[e.parent])))
    graph = InteractionGraph(spaces, edges)
    none = {e: np.zeros(1, dtype=bool) for e in edges}
    quiet = tuple(
        Piece(p.name, {n: p.states[n] for n in spaces}, {e: np.repeat(f, len(p)) for e, f in none.items()})
        for p in ordered
    )
    data = GraphData(graph, dict(spaces), quiet, tuple(edges), variables)
    piece = data.piece_index()
    t = np.flatnonzero(piece[1:] == piece[:-1])
    first = np.r_[True, piece[1:] != piece[:-1]][t]
    row = np.concatenate([np.arange(len(p) - 1) for p in quiet])
    _, block = np.unique(piece[t] * (row.max() + 1) + row // (2 * DISCOVERY.window), return_inverse=True)
    for group in position_groups(spaces[root]):
        turns.setdefault(group.frame, np.eye(len(group.indices)))
    known = {}
    for e in edges:
        values = np.concatenate([p.known.get(e, np.full(len(p), np.nan)) for p in ordered])
        if np.isfinite(values).any():
            known[e] = values[t + 1]
    return Log(
        data=data,
        root=root,
        noise={n: measurement_std(data, n) for n in spaces},
        states={n: data.stacked(n) for n in spaces},
        piece=piece,
        t=t,
        back=np.where(first, t, t - 1),
        fold=interleaved_blocks(piece[t], DISCOVERY.parts, 2 * DISCOVERY.window),
        block=np.asarray(block, dtype=np.intp).ravel(),
        turns=turns,
        known=known,
    )
