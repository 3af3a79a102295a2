"""A person's hand who shows where something begins and ends, without knowing where that is."""

from __future__ import annotations

import numpy as np

from ichain_drake.state import FloatArray


class UnsteadyHand:
    """Draws places a little off, and places to try out around something: here and there, wide, at random.

    Args:
        rng: draws everything.
    """

    def __init__(self, rng: np.random.Generator) -> None:
        self._rng = rng

    def uniform(self, low: float, high: float) -> float:
        """A number between two, as likely here as there."""
        return float(self._rng.uniform(low, high))

    def around(self, count: int, wide: float) -> FloatArray:
        """Places to try along an axis, spread over -wide to wide, in no order.

        One falls at random into each of `count` equal parts, as a person who tries several does not try one twice.

        Args:
            count: how many.
            wide: half the range, in any unit.

        Returns:
            shape (count,).
        """
        return self.between(count, -wide, wide)

    def between(self, count: int, low: float, high: float) -> FloatArray:
        """The same between any two values, shape (count,)."""
        parts = self._rng.permutation(count) + self._rng.uniform(0.0, 1.0, count)
        return low + (high - low) * parts / count
