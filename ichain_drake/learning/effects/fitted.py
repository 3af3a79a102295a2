"""A fitted change: what `choose_regression` gives and effects and passive drifts are made of."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ichain_drake.learning.frozen import FrozenModel
from ichain_drake.state import FloatArray


@dataclass(frozen=True)
class Regression:
    """A fitted change.

    Attributes:
        columns: indices of the chosen columns, in the order of the model's inputs.
        frozen: the fitted estimator, or None where the change is a constant.
        constant: that constant.
        low: smallest input of each column in the demonstrations, shape (n_columns,); None for a linear fit.
        high: the largest. A fit that is not linear is not asked beyond them.
        dead_band: predictions smaller than this are taken as 0: small biases add up over long holds.
        sign: 1 or -1 where the change only ever goes one way; 0 where it goes both, or a linear fit says so.
        estimator: name with parameters; `constant` where there is none.
        std: standard deviation of one tick's left-out residual.
        drift: the same of the mean residual over a window: what adds up, per tick.
        explained: share of the squared change over windows that left-out predictions explain, 1 is perfect.
        samples: number of rows.
        pieces: number of pieces that they come from.
        scale: root mean square of the change over windows.
    """

    columns: tuple[int, ...]
    frozen: FrozenModel | None
    constant: float
    low: FloatArray | None
    high: FloatArray | None
    dead_band: float
    sign: int
    estimator: str
    std: float
    drift: float
    explained: float
    samples: int
    pieces: int
    scale: float

    def __call__(self, rows: FloatArray) -> FloatArray:
        """Predicted changes, shape (n,), from the chosen columns, shape (n, n_columns)."""
        if self.frozen is None:
            return np.full(len(rows), self.constant)
        if self.low is not None and self.high is not None:
            rows = np.minimum(np.maximum(rows, self.low), self.high)
        value = self.frozen.batch(rows)[:, 0]
        value = one_way(value, self.sign)
        return np.where(np.abs(value) < self.dead_band, 0.0, value) if self.dead_band > 0 else value


def one_way(change: FloatArray, sign: int) -> FloatArray:
    """Changes, shape (n,), with 0 in place of those that go the other way than `sign`; all where that is 0."""
    return sign * np.maximum(sign * change, 0.0) if sign else change
