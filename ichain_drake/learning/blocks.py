"""Which rows are left out together in cross-validation: whole pieces, or blocks of successive rows of a piece."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ichain_drake.learning.settings import LEARNING
from ichain_drake.state import IntArray


def piece_blocks(piece: IntArray, row: IntArray, groups: int = LEARNING.groups) -> IntArray:
    """Groups of samples that are left out together: pieces where there are many, else blocks of each.

    Args:
        piece: piece of each sample, shape (n,), ascending.
        row: row of its piece at which the sample starts, shape (n,), ascending within a piece.
        groups: about how many.

    Returns:
        Group of each sample, 0 to n_groups - 1, shape (n,).
    """
    names, start, sizes = np.unique(piece, return_index=True, return_counts=True)
    out = np.zeros(len(piece), dtype=np.intp)
    pieces = len(names)
    if pieces >= LEARNING.few:
        # Whole pieces, dealt so that the groups are of like size.
        groups = min(groups, pieces)
        loads = np.zeros(groups)
        for k in sorted(range(pieces), key=lambda k: (-sizes[k], k)):
            group = int(np.argmin(loads))
            out[start[k] : start[k] + sizes[k]] = group
            loads[group] += sizes[k]
        return out
    per_piece = -(-groups // pieces)
    count = 0
    for k in range(pieces):
        n = int(np.clip(sizes[k] // LEARNING.short, 1, per_piece))
        out[start[k] : start[k] + sizes[k]] = count + (np.arange(sizes[k]) * n) // sizes[k]
        count += n
    return out


def interleaved_blocks(piece: IntArray, folds: int, length: int = 10) -> IntArray:
    """Folds of short blocks, dealt in turn: each fold has seen a part of every piece.

    Args:
        piece: piece of each row, shape (n,), ascending.
        folds: number of folds.
        length: rows of a block.

    Returns:
        Fold of each row, shape (n,).
    """
    _, start, sizes = np.unique(piece, return_index=True, return_counts=True)
    out = np.empty(len(piece), dtype=np.intp)
    offset = 0
    for s, n in zip(start, sizes, strict=True):
        block = np.arange(n) // length
        out[s : s + n] = (block + offset) % folds
        offset += int(block[-1]) + 1
    return out


def runs(mask: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Stretches (start, end) of true values; end is one past the last."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(np.int8)))
    return [(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True)]


def windows(piece: IntArray, row: IntArray, length: int) -> list[tuple[int, int]]:
    """Windows of successive samples, at most `length` long, that don't overlap and don't cross a gap.

    Args:
        piece: piece of each sample, shape (n,).
        row: row of its piece, shape (n,).
        length: [ticks].

    Returns:
        Index ranges (start, end) of the samples; they cover all samples.
    """
    n = len(piece)
    if n == 0:
        return []
    joined = (piece[1:] == piece[:-1]) & (row[1:] == row[:-1] + 1)
    cuts = np.concatenate([[0], np.flatnonzero(~joined) + 1, [n]])
    out = []
    for a, b in zip(cuts[:-1], cuts[1:], strict=True):
        parts = max(1, round((b - a) / length))
        marks = np.linspace(a, b, parts + 1).round().astype(int)
        out += [(int(p), int(q)) for p, q in zip(marks[:-1], marks[1:], strict=True) if q > p]
    return out
