"""The affine map and clipping between a model's inputs and the numbers it computes with."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(eq=False)
class InputScaling:
    """An affine map of the inputs, `z = (x - mean) / scale`, then clipped to `[-clip, clip]`.

    Attributes:
        mean, scale: shape (n_in,), in the units of the inputs.
        clip: bound on |z|; infinite for none.
    """

    mean: FloatArray
    scale: FloatArray
    clip: float = np.inf

    def __post_init__(self) -> None:
        self.mean = np.ascontiguousarray(self.mean, dtype=float)
        self.scale = np.ascontiguousarray(self.scale, dtype=float)
        self.clip = float(self.clip)
        self._slope = 1.0 / self.scale
        self._plain = bool(np.all(self.mean == 0.0) and np.all(self.scale == 1.0) and np.isinf(self.clip))

    @classmethod
    def identity(cls, n_in: int) -> InputScaling:
        """The scaling that changes nothing."""
        return cls(np.zeros(n_in), np.ones(n_in))

    def apply(self, x: FloatArray) -> FloatArray:
        """Scale rows, shape (..., n_in) in and out."""
        if self._plain:
            return x
        z = x - self.mean
        z /= self.scale
        if self.clip < np.inf:
            np.minimum(np.maximum(z, -self.clip, out=z), self.clip, out=z)
        return z

    def pull_back(self, jacobian: FloatArray, z: FloatArray) -> FloatArray:
        """Turn d/dz, shape (..., n_out, n_in), into d/dx; a clipped input has no effect any more."""
        if self._plain:
            return jacobian
        if self.clip < np.inf:
            return jacobian * np.where(np.abs(z) < self.clip, self._slope, 0.0)[..., None, :]
        return jacobian * self._slope

    def after(self, mean: FloatArray, scale: FloatArray) -> InputScaling:
        """The scaling that first applies `(x - mean) / scale`, then this one."""
        if self._plain:
            return InputScaling(mean, scale)
        return InputScaling(mean + scale * self.mean, scale * self.scale, self.clip)

    def same_as(self, other: InputScaling) -> bool:
        """Whether the two are equal bit by bit."""
        return (
            np.array_equal(self.mean, other.mean)
            and np.array_equal(self.scale, other.scale)
            and self.clip == other.clip
        )
