"""Nearest neighbours, by brute force: the demonstrations of one interaction are few."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from ichain_drake.learning.frozen.model import FrozenModel
from ichain_drake.learning.frozen.scaling import FloatArray

_ROWS = 64  # rows whose distances are held at once


@dataclass(eq=False, kw_only=True)
class Neighbours(FrozenModel):
    """Mean of the nearest points' outputs, all alike or weighted by 1 / Euclidean distance.

    Attributes:
        points: shape (n_points, n_in), scaled.
        targets: shape (n_points, n_out).
        n_neighbours: shape ().
        by_distance: whether 1 / distance weighs, shape ().
    """

    kind: ClassVar[str] = "neighbours"

    points: FloatArray
    targets: FloatArray
    n_neighbours: NDArray[np.int64]
    by_distance: NDArray[np.bool_]

    def _prepare(self) -> None:
        self._k = int(self.n_neighbours)
        self._weighted = bool(self.by_distance)

    @property
    def n_out(self) -> int:
        """Number of outputs."""
        return self.targets.shape[1]

    def _nearest(self, z: FloatArray) -> tuple[NDArray[np.intp], FloatArray]:
        delta = z - self.points
        squared = np.einsum("ij,ij->i", delta, delta)
        chosen = np.argpartition(squared, self._k - 1)[: self._k] if self._k < len(squared) else np.arange(self._k)
        return chosen, np.sqrt(squared[chosen])

    def _weights(self, distance: FloatArray) -> FloatArray:
        if not self._weighted:
            return np.full(len(distance), 1.0 / len(distance))
        on_point = distance == 0.0
        weights = on_point.astype(float) if on_point.any() else 1.0 / distance
        return weights / weights.sum()

    def _value(self, z: FloatArray) -> FloatArray:
        chosen, distance = self._nearest(z)
        return self._weights(distance) @ self.targets[chosen]

    def _value_and_jacobian(self, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        chosen, distance = self._nearest(z)
        weights = self._weights(distance)
        value = weights @ self.targets[chosen]
        if not self._weighted or not distance.all():
            return value, np.zeros((self.n_out, self.n_in))
        # d w_i / dz = -(z - p_i) / r_i^3 with w_i = 1 / r_i, quotient rule on the weighted mean
        slopes = (weights / distance**2)[:, None] * (self.points[chosen] - z)
        return value, (self.targets[chosen] - value).T @ slopes

    def _batch(self, z: FloatArray) -> FloatArray:
        result = np.empty((len(z), self.n_out))
        for start in range(0, len(z), _ROWS):
            part = z[start : start + _ROWS]
            delta = part[:, None, :] - self.points
            squared = np.einsum("nij,nij->ni", delta, delta)
            k = min(self._k, len(self.points))
            chosen = np.argpartition(squared, k - 1, axis=1)[:, :k]
            distance = np.sqrt(np.take_along_axis(squared, chosen, axis=1))
            weights = np.stack([self._weights(row) for row in distance])
            result[start : start + _ROWS] = np.einsum("nk,nko->no", weights, self.targets[chosen])
        return result

    def rescaled(self, scale: FloatArray, offset: FloatArray) -> Neighbours:
        """The model with outputs `y * scale + offset`."""
        return replace(self, targets=self.targets * scale + offset, residual_std=self._std_times(scale))
