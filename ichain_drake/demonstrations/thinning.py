"""Stretches of long demonstrations: more rows than learning looks at are thinned to stretches that show every switch.

Rows of one stretch are successive, so that changes, switches and slow effects can be told from it as from any piece.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ichain_drake.demonstrations.columns import as_numbers
from ichain_drake.demonstrations.table import Demonstration
from ichain_drake.graph import InteractionGraph
from ichain_drake.state import BoolArray, IntArray

_ON = 0.5  # a flag beyond it is set


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


def outline(piece: Demonstration, graph: InteractionGraph, length: int) -> Outline:
    """The stretches of a piece, all but the last `length` long, and what they tell.

    A stretch tells about an interaction if its flag switches in it; where it never does in the piece, if it is active;
    and where the piece has no flag of it, if both of its ends are there.

    Args:
        piece: not necessarily checked.
        graph: the interactions.
        length: [rows].
    """
    starts = np.arange(0, max(len(piece), 1), length, dtype=np.intp)
    if len(starts) > 1 and len(piece) - starts[-1] < length // 2:  # a short rest goes with the stretch before
        starts = starts[:-1]
    tells = np.zeros((len(starts), len(graph.interactions)), dtype=bool)
    for k, edge in enumerate(graph.interactions):
        if edge.name in piece.table:
            on = as_numbers(piece.table[edge.name]) > _ON
            switched = np.concatenate([[False], on[1:] != on[:-1]])
            shown = np.flatnonzero(switched if switched.any() else on)
            tells[np.searchsorted(starts, shown, side="right") - 1, k] = True
        else:
            tells[:, k] = all(piece.has(end, graph.objects[end]) for end in (edge.parent, edge.child))
    return Outline(starts, len(piece), tells)


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


def thinned(pieces: Sequence[Demonstration], graph: InteractionGraph, most: int, length: int) -> list[Demonstration]:
    """Stretches of pieces with at most so many rows in all; the pieces themselves where they have no more.

    Args:
        pieces: demonstrations.
        graph: whose interactions must be shown.
        most: rows in all.
        length: of a stretch [rows]; shorter pieces are kept, or left out, as a whole.
    """
    if sum(map(len, pieces)) <= most:
        return list(pieces)
    kept = chosen_rows([outline(piece, graph, length) for piece in pieces], most)
    return [stretch(piece, a, b) for piece, rows in zip(pieces, kept, strict=True) for a, b in rows]
