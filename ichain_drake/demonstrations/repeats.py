"""Stretches of a recording that are in it twice: written again by a logger, or joined from overlapping files."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ichain_drake.demonstrations.columns import as_numbers
from ichain_drake.demonstrations.table import Demonstration

FEWEST = 4
"""Rows of a stretch: noise repeats the readings of one row by chance at most."""


def repeats(piece: Demonstration, noisy: Sequence[str]) -> list[tuple[int, int, int]]:
    """Stretches whose readings repeat earlier ones to the last digit, row by row.

    Args:
        piece: the recording.
        noisy: columns whose readings have noise; where there are none, equal readings mean nothing.

    Returns:
        First and last row of each stretch, from 0, and the row that its first row repeats.
    """
    names = [n for n in noisy if n in piece.table]
    if not names or len(piece) < 2 * FEWEST:
        return []
    values = np.stack([as_numbers(piece.table[n]) for n in names], axis=1)
    _, first, same = np.unique(values, axis=0, return_index=True, return_inverse=True)
    earlier = first[same.ravel()]
    rows = np.arange(len(piece))
    lag = rows - earlier
    # A feed that froze repeats one row again and again, with a lag that grows: that is told elsewhere.
    breaks = np.flatnonzero(np.diff(lag) != 0) + 1
    out = []
    for a, b in zip(np.r_[0, breaks], np.r_[breaks, len(rows)], strict=True):
        if lag[a] > 0 and b - a >= FEWEST and np.isfinite(values[a:b]).all():
            out.append((int(a), int(b) - 1, int(earlier[a])))
    return out
