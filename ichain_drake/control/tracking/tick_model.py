"""A model of one tick that a predictive level rolls out and differentiates."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np

from ichain_drake.state import FloatArray

Derivatives = tuple[FloatArray, FloatArray, FloatArray]
"""By child (k, n, n_child, n_child), by the parent at t and at t + 1 (k, n, n_child, n_parent)."""


class TickModel(Protocol):
    """A model of one tick that can be differentiated: a learned `ForwardModel`, or the truth for an oracle."""

    def predict(self, child: FloatArray, parent: FloatArray, parent_next: FloatArray) -> FloatArray:
        """Next states, shape (n, n_child)."""

    def predict_noted(self, child: FloatArray, parent: FloatArray, parent_next: FloatArray) -> tuple[FloatArray, Any]:
        """Next states, and what `derivatives` needs.

        Each tick of a roll-out starts where the one before ended, but the derivatives of all can be calculated at once.
        """

    def derivatives(self, notes: Sequence[Any]) -> Derivatives:
        """Derivatives of k predictions."""


class LinearizedModel(ABC):
    """What has a `linearize`, which gives next states and their derivatives, as a `TickModel`."""

    @abstractmethod
    def linearize(
        self, child: FloatArray, parent: FloatArray, parent_next: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Next states and their derivatives by child, parent and parent_next."""

    def predict_noted(self, child: FloatArray, parent: FloatArray, parent_next: FloatArray) -> tuple[FloatArray, Any]:
        """See `TickModel`."""
        after, *derivatives = self.linearize(child, parent, parent_next)
        return after, derivatives

    def derivatives(self, notes: Sequence[Any]) -> Derivatives:
        """See `TickModel`."""
        by_child, by_parent, by_next = (np.stack(d) for d in zip(*notes, strict=True))
        return by_child, by_parent, by_next
