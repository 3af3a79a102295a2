"""Stretches of long demonstrations: more rows than learning looks at are thinned to stretches that show every switch.

Rows of one stretch are successive, so that changes, switches and slow effects can be told from it as from any piece.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from ichain_drake.demonstrations.columns import as_numbers
from ichain_drake.demonstrations.table import Demonstration
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.state import BoolArray, IntArray

_ON = 0.5  # a flag beyond it is set


@dataclass(frozen=True)
class Bound:
    """How much of long recordings is used.

    Attributes:
        rows: in all, at most.
        stretch: successive rows that are used, or not, together.
    """

    rows: int
    stretch: int


@dataclass(frozen=True)
class Outline:
    """What of a recording decides which stretches of it are kept.

    Attributes:
        starts: first row of each stretch, ascending from 0, shape (n,).
        rows: of the recording.
        tells: which stretches tell about each interaction of the graph, shape (n, n_interactions).
    """

    starts: IntArray
    rows: int
    tells: BoolArray

    @property
    def sizes(self) -> IntArray:
        """Rows of each stretch, shape (n,)."""
        return np.diff(self.starts, append=self.rows)


class Outliner:
    """Makes the outline of a recording that is read a part at a time.

    A stretch tells about an interaction if its flag switches in it; where it never does in the recording, if it is
    active; and where the recording has no flag of it, if both of its ends are there.

    Args:
        graph: the interactions.
        length: of all stretches but the last [rows].
    """

    def __init__(self, graph: InteractionGraph, length: int) -> None:
        self._edges, self._length, self._rows = graph.interactions, length, 0
        self._last: dict[Interaction, bool] = {}
        self._switched: dict[Interaction, list[IntArray]] = {e: [] for e in self._edges}
        self._active: dict[Interaction, list[IntArray]] = {e: [] for e in self._edges}

    def add(self, flags: pd.DataFrame) -> None:
        """The next rows; columns that are no flags are not looked at, and not needed."""
        for edge in self._edges:
            if edge.name not in flags or not len(flags):
                continue
            on = as_numbers(flags[edge.name]) > _ON
            before = np.concatenate([[self._last.get(edge, on[0])], on[:-1]])
            for rows, found in ((on != before, self._switched), (on, self._active)):
                found[edge].append(np.unique((self._rows + np.flatnonzero(rows)) // self._length))
            self._last[edge] = bool(on[-1])
        self._rows += len(flags)

    def outline(self, holds: Callable[[str], bool]) -> Outline:
        """The outline of all rows so far.

        Args:
            holds: whether the recording has an object of that name.
        """
        starts = np.arange(0, max(self._rows, 1), self._length, dtype=np.intp)
        if len(starts) > 1 and self._rows - starts[-1] < self._length // 2:  # a short rest goes with the one before
            starts = starts[:-1]
        tells = np.zeros((len(starts), len(self._edges)), dtype=bool)
        for k, edge in enumerate(self._edges):
            if edge in self._last:
                shown = np.concatenate(self._switched[edge])
                shown = shown if len(shown) else np.concatenate(self._active[edge])
                tells[np.minimum(shown, len(starts) - 1), k] = True
            else:
                tells[:, k] = holds(edge.parent) and holds(edge.child)
        return Outline(starts, self._rows, tells)


def outline(piece: Demonstration, graph: InteractionGraph, length: int) -> Outline:
    """The stretches of a piece, and what they tell; see `Outliner`."""
    whole = Outliner(graph, length)
    whole.add(piece.table)
    return whole.outline(lambda name: piece.has(name, graph.objects[name]))


def chosen_rows(outlines: Sequence[Outline], most: int) -> list[list[tuple[int, int]]]:
    """Which rows of recordings are kept: half of them for what tells about each interaction, half evenly of the rest.

    The interaction that fewest stretches tell about chooses first. All choices are evenly spaced, never at random.

    Args:
        outlines: of all recordings.
        most: rows to keep at most.

    Returns:
        Of each recording first rows and rows after the last, joined where stretches follow each other.
    """
    sizes = np.concatenate([o.sizes for o in outlines])
    tells = np.concatenate([o.tells for o in outlines])
    taken = np.zeros(len(sizes), dtype=bool)
    share = most // (2 * max(tells.shape[1], 1))
    for k in np.argsort(tells.sum(axis=0), kind="stable"):
        _take(taken, sizes, np.flatnonzero(tells[:, k]), share)
    _take(taken, sizes, np.arange(len(sizes)), most)
    out, first = [], 0
    for o in outlines:
        mine = taken[first : first + len(o.starts)]
        edges = np.flatnonzero(np.diff(np.concatenate([[False], mine, [False]]).astype(np.int8)))
        ends = np.append(o.starts, o.rows)
        out.append([(int(ends[a]), int(ends[b])) for a, b in zip(edges[::2], edges[1::2], strict=True)])
        first += len(o.starts)
    return out


def _take(taken: BoolArray, sizes: IntArray, among: NDArray[np.intp], most: int) -> None:
    """Mark evenly spaced ones of some stretches, until so many rows of them are taken."""
    free = among[~taken[among]]
    room = most - int(sizes[among[taken[among]]].sum())
    if not len(free) or room <= 0:
        return
    count = min(len(free), int(room // sizes[free].mean()))
    picked = free[np.linspace(0, len(free) - 1, count).round().astype(np.intp)]
    taken[picked[np.cumsum(sizes[picked]) <= room]] = True


def stretch(piece: Demonstration, first: int, end: int) -> Demonstration:
    """Some successive rows of a piece, as a piece; itself where that is all."""
    if (first, end) == (0, len(piece)):
        return piece
    return replace(
        piece,
        table=piece.table.iloc[first:end].reset_index(drop=True),
        name=f"{piece.name} rows {first} to {end - 1}",
        first_line=piece.first_line + first,
        open={name: rows[first:end] for name, rows in piece.open.items()},
    )


def thinned(pieces: Sequence[Demonstration], graph: InteractionGraph, bound: Bound) -> list[Demonstration]:
    """Stretches of pieces with at most so many rows in all; the pieces themselves where they have no more.

    Args:
        pieces: demonstrations.
        graph: whose interactions must be shown.
        bound: how many rows; pieces shorter than its stretches are kept, or left out, as a whole.
    """
    if sum(map(len, pieces)) <= bound.rows:
        return list(pieces)
    kept = chosen_rows([outline(piece, graph, bound.stretch) for piece in pieces], bound.rows)
    return [stretch(piece, a, b) for piece, rows in zip(pieces, kept, strict=True) for a, b in rows]
