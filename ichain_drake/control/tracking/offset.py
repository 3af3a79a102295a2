"""A model's lasting error, estimated while it is used, so that plans reckon with it (offset-free predictive control).

A learned model is off in its own way in each region, and what it doesn't see (a current, a load) changes slowly. Both
show as one-tick errors that are alike over many ticks, where noise isn't. Pannocchia and Rawlings (2003) add such an
error to the model as a state that is estimated; here the estimate is an exponentially weighted mean of the errors. How
much of it is believed follows from how alike errors two to nine ticks apart have been so far in the run (a reading that
is off makes those of successive ticks unlike), less two standard deviations of what chance would do: a model whose
errors are noise is left as it is.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ichain_drake.control.settings import TRACKING
from ichain_drake.learning.settings import LEARNING
from ichain_drake.state import FloatArray

_LAGS = TRACKING.furthest - TRACKING.nearest + 1


@dataclass(frozen=True)
class OffsetEstimate:
    """The estimator; what it remembers of each of n runs is a row of numbers.

    Attributes:
        size: number of variables.
        gain: weight of the newest error; 0 for no estimate.
        decay: share of the offset that is left a tick later.
    """

    size: int
    gain: float = 0.2
    decay: float = 0.95

    @property
    def memory_size(self) -> int:
        """Numbers that are remembered: per variable mean, squares, products and last errors; number of errors."""
        return (3 + TRACKING.furthest) * self.size + 1 if self.gain else 0

    def update(self, memory: FloatArray, error: FloatArray) -> FloatArray:
        """The memory with one more error.

        Args:
            memory: shape (n, memory_size); zeros at the start.
            error: what was measured less what was predicted, shape (n, size).
        """
        mean, squares, products, *last, count = self._parts(memory)
        weight = np.maximum(self.gain, 1.0 / (count + 1.0))  # a plain mean at first
        mean = mean + weight * (error - mean)
        products = products + error * np.sum(last[TRACKING.nearest - 1 :], axis=0)
        return np.concatenate([mean, squares + error**2, products, error, *last[:-1], count + 1.0], axis=1)

    def offsets(self, memory: FloatArray, ticks: int) -> FloatArray:
        """What to add to the model's prediction of each of the coming ticks, shape (n, ticks, size)."""
        if not self.gain:
            return np.zeros((len(memory), ticks, self.size))
        mean, squares, products, *_, count = self._parts(memory)
        pairs = np.maximum(_pairs(count), 1.0)
        alike = products / np.maximum(squares, 1e-300) * count / pairs
        lasting = np.clip(alike - LEARNING.sure / np.sqrt(pairs), 0.0, 1.0)  # share of the errors' variance
        by_chance = self.gain / (2.0 - self.gain) * (1.0 - lasting)  # what the mean has of the rest
        believed = lasting / np.maximum(lasting + by_chance, 1e-300)
        fading = self.decay ** np.arange(ticks)
        return np.asarray((believed * mean)[:, None] * fading[:, None])

    def _parts(self, memory: FloatArray) -> list[FloatArray]:
        """Mean, squares, products, the last errors (newest first), and their number."""
        return np.split(memory, self.size * np.arange(1, 4 + TRACKING.furthest), axis=1)


def _pairs(count: FloatArray) -> FloatArray:
    """Number of pairs of errors that were compared among so many errors."""
    few = np.clip(count - TRACKING.nearest, 0.0, _LAGS)
    return few * (few + 1.0) / 2.0 + _LAGS * np.maximum(count - TRACKING.nearest - _LAGS, 0.0)
