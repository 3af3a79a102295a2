"""How noisy each measured variable is: what can't be predicted from one row to the next while nothing happens."""

from __future__ import annotations

import numpy as np

from ichain_drake.learning.data import GraphData
from ichain_drake.state import FloatArray

_ROUNDING = 12.0**-0.5  # of a number rounded to an integer
HALF_NORMAL = 0.6744897501960817  # median of |z| of a standard normal


def measurement_std(data: GraphData, obj: str) -> FloatArray:
    """Standard deviation of one reading of each variable, from the median of its second differences.

    Second differences cancel steady motion; the median ignores switching.

    Returns:
        shape (n_variables,), at least 1e-9 of the variable's range, and what rounding costs an integer.
    """
    space = data.spaces[obj]
    parts = []
    for piece in data.pieces:
        step = space.difference(piece.states[obj][1:], piece.states[obj][:-1])
        parts.append(step[1:] - step[:-1])
    second = np.abs(np.vstack(parts))
    std = np.median(second, axis=0) / HALF_NORMAL / np.sqrt(6.0)  # variance of x - 2 y + z: 6 sigma^2
    span = np.maximum(np.ptp(data.stacked(obj), axis=0), 1e-12)
    rounded = np.array([_ROUNDING if v.kind == "integer" else 0.0 for v in space.variables])
    return np.maximum(np.maximum(std, rounded), 1e-9 * span)
