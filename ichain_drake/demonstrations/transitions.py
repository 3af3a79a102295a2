"""Transitions of one interaction, taken out of demonstration tables."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ichain_drake.demonstrations.columns import COMMAND, column
from ichain_drake.demonstrations.table import Demonstration
from ichain_drake.errors import InputError
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.state import FloatArray, StateSpace


@dataclass(frozen=True)
class Transitions:
    """Successive measured states of a child and its parent, over all pieces that hold both.

    Row i is a tick from t to t + 1 while the interaction is active (paper sec. III, V).

    Attributes:
        child_space, parent_space: the observable state spaces.
        child: child's state at t, shape (n, n_child).
        child_next: the same at t + 1.
        parent: parent's state at t, shape (n, n_parent).
        parent_next: the same at t + 1: by default the action (paper sec. III).
        piece: index of the piece, shape (n,).
        row: row of the piece's table in which the tick starts, shape (n,).
    """

    child_space: StateSpace
    parent_space: StateSpace
    child: FloatArray
    child_next: FloatArray
    parent: FloatArray
    parent_next: FloatArray
    piece: NDArray[np.intp]
    row: NDArray[np.intp]

    def __len__(self) -> int:
        return len(self.piece)

    def take(self, rows: NDArray[np.intp] | NDArray[np.bool_] | slice) -> Transitions:
        """Some of the rows."""
        return replace(
            self,
            child=self.child[rows],
            child_next=self.child_next[rows],
            parent=self.parent[rows],
            parent_next=self.parent_next[rows],
            piece=self.piece[rows],
            row=self.row[rows],
        )

    def child_ahead(self, ticks: int) -> tuple[FloatArray, NDArray[np.bool_]]:
        """The child's state some ticks after each row.

        Args:
            ticks: >= 1.

        Returns:
            States, shape (n, n_child), and whether the piece reaches that far without a gap, shape (n,).
        """
        n = len(self)
        later = np.minimum(np.arange(n) + ticks - 1, n - 1)
        # By table rows, not by equal states: a child at rest is in the same state on both sides of a gap.
        joined = np.zeros(n, dtype=bool)
        joined[:-1] = (self.piece[1:] == self.piece[:-1]) & (self.row[1:] == self.row[:-1] + 1)
        broken = np.concatenate([[0], np.cumsum(~joined)])
        ok = (np.arange(n) + ticks - 1 < n) & (broken[later] == broken[np.arange(n)])
        return self.child_next[later], ok


def collect_transitions(
    pieces: Sequence[Demonstration], graph: InteractionGraph, interaction: Interaction, limit: int | None = None
) -> Transitions:
    """All transitions of one interaction while it is active.

    Args:
        pieces: checked demonstrations; those that lack the child or the parent are passed over.
        graph: the interaction graph.
        interaction: the edge.
        limit: take only the first so many.

    Raises:
        InputError: if no piece holds the two objects with the interaction active.
    """
    child_space = graph.objects[interaction.child].observable
    parent_space = graph.objects[interaction.parent].observable
    parts: list[tuple[NDArray[Any], ...]] = []
    for number, piece in enumerate(pieces):
        if not (piece.has(interaction.child, child_space) and piece.has(interaction.parent, parent_space)):
            continue
        child = piece.states(interaction.child, child_space)
        parent = piece.states(interaction.parent, parent_space)
        flag = piece.table.get(interaction.name)
        on = np.ones(len(child), dtype=bool) if flag is None else flag.to_numpy(dtype=float) > 0.5
        rows = on[:-1] & on[1:]
        start = np.flatnonzero(rows)
        index = np.full(len(start), number)
        parts.append((child[:-1][rows], child[1:][rows], parent[:-1][rows], parent[1:][rows], index, start))
    if not parts or not sum(len(p[0]) for p in parts):
        raise InputError(
            f"{interaction.name}: no demonstration holds {interaction.parent} and {interaction.child} with the "
            "interaction active; record a piece that does"
        )
    joined = [np.concatenate(column_) for column_ in zip(*parts, strict=True)]
    data = Transitions(child_space, parent_space, *joined[:4], *(j.astype(np.intp) for j in joined[4:]))
    return data if limit is None else data.take(slice(limit))


def collect_commands(pieces: Sequence[Demonstration], graph: InteractionGraph) -> tuple[FloatArray, FloatArray] | None:
    """Hand commands and the hand states at the end of the tick that they bring about.

    Returns:
        Commands and states, shape (n, n_hand) each; None if no piece records commands.
    """
    space = graph.objects[graph.root].observable
    names = [column(COMMAND, v) for v in space.names]
    usable = [p for p in pieces if p.has(graph.root, space) and all(n in p.table for n in names)]
    if not usable:
        return None
    commands = np.concatenate([p.table[names].to_numpy(dtype=float)[:-1] for p in usable])
    states = np.concatenate([p.states(graph.root, space)[1:] for p in usable])
    return commands, states
