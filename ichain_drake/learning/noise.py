"""How noisy each measured variable is: what can't be predicted from one row to the next while nothing happens."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ichain_drake.learning.data import GraphData
from ichain_drake.state import FloatArray, StateSpace

_ROUNDING = 12.0**-0.5  # of a number rounded to an integer
HALF_NORMAL = 0.6744897501960817  # median of |z| of a standard normal


def measurement_std(data: GraphData, obj: str) -> FloatArray:
    """Standard deviation of one reading of each variable, from the median of its second differences.

    Second differences cancel steady motion; the median ignores switching.

    Returns:
        shape (n_variables,), at least 1e-9 of the variable's range, and what rounding costs an integer.
    """
    return change_noise(data.spaces[obj], [piece.states[obj] for piece in data.pieces])


def change_noise(space: StateSpace, parts: Sequence[FloatArray]) -> FloatArray:
    """The same from states of one object at successive ticks, each of shape (n_rows, n_variables).

    Args:
        space: observable state space of the object.
        parts: stretches without a gap.

    Returns:
        shape (n_variables,); see `measurement_std`.
    """
    second = np.abs(np.vstack([np.diff(space.difference(x[1:], x[:-1]), axis=0) for x in parts]))
    std = np.median(second, axis=0) / HALF_NORMAL / np.sqrt(6.0)  # variance of x - 2 y + z: 6 sigma^2
    span = np.maximum(np.ptp(np.vstack(parts), axis=0), 1e-12)
    rounded = np.array([_ROUNDING if v.kind == "integer" else 0.0 for v in space.variables])
    return np.maximum(np.maximum(std, rounded), 1e-9 * span)
