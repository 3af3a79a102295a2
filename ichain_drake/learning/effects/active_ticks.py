"""The ticks in which an interaction is active: what its effects are fitted to."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ichain_drake.graph import Interaction
from ichain_drake.learning.data import GraphData, Piece
from ichain_drake.state import FloatArray


@dataclass(frozen=True)
class ActiveTicks:
    """Ticks in which an interaction is active, over all pieces, in n rows.

    Attributes:
        parent, parent_next: the parent's state at the tick's start and end, shape (n, n_parent).
        child, child_next: the same of the child, shape (n, n_child).
        child_before: the child's state one row before, or at the start where there is none, shape (n, n_child).
        others: of each other interaction with the child its parent's states at start and end, shape (n, n_other), and
            whether it acts, shape (n,).
        piece: index of the piece, shape (n,).
        row: row of the piece at which the tick starts, shape (n,).
    """

    parent: FloatArray
    parent_next: FloatArray
    child: FloatArray
    child_next: FloatArray
    child_before: FloatArray
    others: dict[Interaction, tuple[FloatArray, FloatArray, NDArray[np.bool_]]]
    piece: NDArray[np.intp]
    row: NDArray[np.intp]

    @property
    def alone(self) -> NDArray[np.bool_]:
        """Rows in which no other interaction acts on the child, shape (n,)."""
        acts = np.zeros(len(self.piece), dtype=bool)
        for _, _, on in self.others.values():
            acts |= on
        return ~acts


def active_ticks(data: GraphData, edge: Interaction, *, onsets: bool = False) -> ActiveTicks:
    """Ticks at both ends of which an interaction is active; where there are none, those that end with it active.

    Args:
        data: the pieces.
        edge: the interaction.
        onsets: whether to take all that end with it active in any case: those in which it begins, too.
    """
    ticks = [_ticks(p, edge) for p in data.pieces]
    if onsets or sum(map(len, ticks)) == 0:  # never two rows in a row: take what there is
        ticks = [np.flatnonzero(p.flags[edge][1:]) for p in data.pieces]

    def take(obj: str, later: int) -> FloatArray:
        return np.vstack([p.states[obj][np.maximum(t + later, 0)] for p, t in zip(data.pieces, ticks, strict=True)])

    others = {
        e: (
            take(e.parent, 0),
            take(e.parent, 1),
            np.concatenate([p.flags[e][t + 1] for p, t in zip(data.pieces, ticks, strict=True)]),
        )
        for e in data.incoming(edge.child)
        if e != edge
    }
    return ActiveTicks(
        take(edge.parent, 0),
        take(edge.parent, 1),
        take(edge.child, 0),
        take(edge.child, 1),
        take(edge.child, -1),
        others,
        np.repeat(np.arange(len(ticks)), [len(t) for t in ticks]),
        np.concatenate(ticks),
    )


def _ticks(piece: Piece, edge: Interaction) -> NDArray[np.intp]:
    flag = piece.flags[edge]
    return np.flatnonzero(flag[:-1] & flag[1:])
