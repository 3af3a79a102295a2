"""Multi-layer perceptrons."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from scipy.special import expit

from ichain_drake.errors import InputError
from ichain_drake.learning.frozen.model import Array, FrozenModel
from ichain_drake.learning.frozen.scaling import FloatArray, InputScaling


# Named functions, so that fitted estimators that hold a network can be copied to other processes.
def _identity(a: FloatArray) -> FloatArray:
    return a


def _rectified(a: FloatArray) -> FloatArray:
    return np.maximum(a, 0.0)


def _logistic_slope(h: FloatArray) -> FloatArray:
    return h * (1.0 - h)


def _tanh_slope(h: FloatArray) -> FloatArray:
    return 1.0 - h * h


def _rectified_slope(h: FloatArray) -> FloatArray:
    return (h > 0.0).astype(float)


# name: (function, derivative in terms of the function's value)
_ACTIVATIONS: dict[str, tuple[Callable[[FloatArray], FloatArray], Callable[[FloatArray], FloatArray]]] = {
    "identity": (_identity, np.ones_like),
    "logistic": (expit, _logistic_slope),
    "tanh": (np.tanh, _tanh_slope),
    "relu": (_rectified, _rectified_slope),
}


@dataclass(eq=False, kw_only=True)
class Network(FrozenModel):
    """Layers `h = activation(W h + b)`, the last one without activation.

    Attributes:
        activation: `identity`, `logistic`, `tanh` or `relu`.
        matrices: one a layer, shape (n_units, n_units_before).
        biases: one a layer, shape (n_units,).
    """

    kind: ClassVar[str] = "network"

    activation: str
    matrices: list[FloatArray]
    biases: list[FloatArray]

    def _prepare(self) -> None:
        if self.activation not in _ACTIVATIONS:
            raise InputError(f"activation {self.activation!r} can't be frozen; use one of {', '.join(_ACTIVATIONS)}")
        self.matrices = [np.ascontiguousarray(m, dtype=float) for m in self.matrices]
        self.biases = [np.ascontiguousarray(b, dtype=float) for b in self.biases]
        self._function, self._slope = _ACTIVATIONS[self.activation]
        self._hidden = list(zip(self.matrices[:-1], self.biases[:-1], strict=True))

    @property
    def n_out(self) -> int:
        """Number of outputs."""
        return len(self.biases[-1])

    def _value(self, z: FloatArray) -> FloatArray:
        for matrix, bias in self._hidden:
            z = self._function(matrix @ z + bias)
        return self.matrices[-1] @ z + self.biases[-1]

    def _value_and_jacobian(self, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        slopes = []
        for matrix, bias in self._hidden:
            z = self._function(matrix @ z + bias)
            slopes.append(self._slope(z))
        jacobian = self.matrices[-1]
        for (matrix, _), slope in zip(reversed(self._hidden), reversed(slopes), strict=True):
            jacobian = (jacobian * slope) @ matrix
        return self.matrices[-1] @ z + self.biases[-1], jacobian

    def _batch(self, z: FloatArray) -> FloatArray:
        for matrix, bias in self._hidden:
            z = self._function(z @ matrix.T + bias)
        return z @ self.matrices[-1].T + self.biases[-1]

    def _batch_jacobian(self, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        slopes = []
        jacobian = np.broadcast_to(self.matrices[-1], (len(z), *self.matrices[-1].shape))
        for matrix, bias in self._hidden:
            z = self._function(z @ matrix.T + bias)
            slopes.append(self._slope(z))
        for (matrix, _), slope in zip(reversed(self._hidden), reversed(slopes), strict=True):
            jacobian = (jacobian * slope[:, None, :]) @ matrix
        return z @ self.matrices[-1].T + self.biases[-1], jacobian

    def rescaled(self, scale: FloatArray, offset: FloatArray) -> Network:
        """The model with outputs `y * scale + offset`."""
        matrices = [*self.matrices[:-1], self.matrices[-1] * scale[:, None]]
        biases = [*self.biases[:-1], self.biases[-1] * scale + offset]
        return replace(self, matrices=matrices, biases=biases, residual_std=self._std_times(scale))

    def arrays(self) -> dict[str, Array]:
        """The model as plain arrays, one pair a layer."""
        result = super().arrays() | {"activation": np.array(self.activation)}
        for i, (matrix, bias) in enumerate(zip(self.matrices, self.biases, strict=True)):
            result |= {f"matrix_{i}": matrix, f"bias_{i}": bias}
        return result

    @classmethod
    def _from_arrays(cls, inputs: InputScaling, arrays: Mapping[str, Array]) -> Network:
        n = sum(1 for name in arrays if name.startswith("matrix_"))
        return cls(
            inputs=inputs,
            residual_std=arrays.get("residual_std"),
            activation=str(arrays["activation"]),
            matrices=[arrays[f"matrix_{i}"] for i in range(n)],
            biases=[arrays[f"bias_{i}"] for i in range(n)],
        )
