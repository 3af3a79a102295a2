"""Scores of a status classifier: of the status itself, and of the switching events."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ichain_drake.state import BoolArray


def f1(truth: BoolArray, predicted: BoolArray) -> float:
    """F1 of a status, arrays of shape (n,); 1 where neither has a positive."""
    hits = int(np.sum(truth & predicted))
    wrong = int(np.sum(truth != predicted))
    return 1.0 if hits + wrong == 0 else 2.0 * hits / (2.0 * hits + wrong)


def switches(status: BoolArray) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Rows at which a status becomes true, and those at which it becomes false."""
    return np.flatnonzero(~status[:-1] & status[1:]) + 1, np.flatnonzero(status[:-1] & ~status[1:]) + 1


def match_events(truth: BoolArray, predicted: BoolArray, tolerance: int = 1) -> tuple[int, int, int]:
    """Match switching events of the same direction one to one.

    Args:
        truth: status of successive rows of one piece, shape (n,).
        predicted: the same, as predicted.
        tolerance: how many rows apart a match may lie.

    Returns:
        Matched events, true events, predicted events.
    """
    matched = n_true = n_predicted = 0
    for a, b in zip(switches(truth), switches(predicted), strict=True):
        free = list(b)
        for row in a:
            near = [r for r in free if abs(r - row) <= tolerance]
            if near:
                free.remove(near[int(np.argmin([abs(r - row) for r in near]))])
                matched += 1
        n_true, n_predicted = n_true + len(a), n_predicted + len(b)
    return matched, n_true, n_predicted


def event_f1(truths: Sequence[BoolArray], predictions: Sequence[BoolArray], tolerance: int = 1) -> float:
    """F1 of switching events over pieces; 1 where there are none and none is predicted."""
    counts = np.sum([match_events(t, p, tolerance) for t, p in zip(truths, predictions, strict=True)], axis=0)
    total = int(counts[1] + counts[2])
    return 1.0 if total == 0 else 2.0 * float(counts[0]) / total
