"""Sums of Gaussian bumps: kernel ridge regression, support vector machines and the mean of a Gaussian process."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from ichain_drake.learning.frozen.model import FrozenModel
from ichain_drake.learning.frozen.scaling import FloatArray

_ROWS = 256  # rows evaluated at once: bounds the memory of a large batch
_TABLES = 16  # tables of one row evaluated at once: the bumps of more would not stay in the processor's cache
_KEPT = 2  # rows whose bumps are kept for the derivatives: those of more would leave the processor's cache meanwhile


@dataclass(eq=False, kw_only=True)
class KernelSum(FrozenModel):
    """`y_o = offset_o + sum_n weights_on exp(-1/2 |(z - centres_n) / length_scales|^2)`.

    Either all outputs share one block of centres and length scales, or each output has a block of its own.

    Attributes:
        centres: shape (n_blocks, n_centres, n_in), n_blocks 1 or n_out.
        length_scales: shape (n_blocks, n_in).
        weights: shape (n_out, n_centres).
        offset: shape (n_out,).
    """

    kind: ClassVar[str] = "kernel"
    takes_batches: ClassVar[bool] = True

    centres: FloatArray
    length_scales: FloatArray
    weights: FloatArray
    offset: FloatArray

    def _prepare(self) -> None:
        blocks, n, d = self.centres.shape
        # The exponent is linear in [z, z^2, 1]: one matrix product for all blocks. Around the middle of the centres,
        # or it would cancel digits for inputs far from zero.
        self._middle = self.centres.reshape(-1, d).mean(axis=0) if n else np.zeros(d)
        centred = self.centres - self._middle
        precision = (1.0 / self.length_scales**2)[:, None, :]
        linear = centred * precision
        square = np.broadcast_to(-0.5 * precision, linear.shape)
        constant = -0.5 * (centred * linear).sum(axis=2, keepdims=True)
        table = np.concatenate([linear, square, constant], axis=2)  # (blocks, n, 2 d + 1)
        self._table = np.ascontiguousarray(table.reshape(blocks * n, -1).T)
        self._tables = np.ascontiguousarray(table.transpose(0, 2, 1))
        self._slopes = np.ascontiguousarray(np.concatenate([linear, 2 * square], axis=2))  # (blocks, n, 2 d)
        self._blocks = blocks

    @property
    def n_out(self) -> int:
        """Number of outputs."""
        return len(self.weights)

    def _row_features(self, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        d = self.n_in
        u = np.empty(2 * d + 1)
        centred = np.subtract(z, self._middle, out=u[:d])
        np.multiply(centred, centred, out=u[d:-1])
        u[-1] = 1.0
        return centred, np.exp(u @ self._table).reshape(self._blocks, -1)

    def _value(self, z: FloatArray) -> FloatArray:
        _, phi = self._row_features(z)
        if self._blocks == 1:
            return self.weights @ phi[0] + self.offset
        return np.einsum("kn,kn->k", self.weights, phi) + self.offset

    def _value_and_jacobian(self, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        centred, phi = self._row_features(z)
        parts = self.weights * phi  # (n_out, n), by broadcasting where the block is shared
        if self._blocks == 1:
            value, slopes = self.weights @ phi[0], parts @ self._slopes[0]
        else:
            value = np.einsum("kn,kn->k", self.weights, phi)
            slopes = np.matmul(parts[:, None, :], self._slopes)[:, 0]
        return value + self.offset, slopes[:, : self.n_in] + slopes[:, self.n_in :] * centred

    def features(self, z: FloatArray) -> FloatArray:
        """Values of all bumps, (..., n, n_in) -> (..., n_blocks, n, n_centres)."""
        d = self.n_in
        u = np.empty((*z.shape[:-1], 2 * d + 1))
        centred = np.subtract(z, self._middle, out=u[..., :d])
        np.square(centred, out=u[..., d:-1])
        u[..., -1] = 1.0
        phi = u[..., None, :, :] @ self._tables
        return np.exp(phi, out=phi)

    def _batch(self, z: FloatArray) -> FloatArray:
        step = _ROWS if z.ndim == 2 else _TABLES
        if len(z) <= step:
            return self._some(z)
        return np.concatenate([self._some(z[k : k + step]) for k in range(0, len(z), step)])

    def _some(self, z: FloatArray) -> FloatArray:
        """`_batch` of so few rows that the memory is no question."""
        phi = self.features(z)
        shared = self._blocks == 1
        if shared:
            value = phi[..., 0, :, :] @ self.weights.T
        else:
            value = np.matmul(phi, self.weights[:, :, None])[..., 0].swapaxes(-1, -2)
        return np.add(value, self.offset, out=np.empty((*z.shape[:-1], self.n_out)))

    def _batch_jacobian(self, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        values = np.empty((*z.shape[:-1], self.n_out))
        jacobians = np.empty((*values.shape, self.n_in))
        step = _ROWS if z.ndim == 2 else _TABLES
        for start in range(0, len(z), step):
            part = slice(start, start + step)
            values[part], phi = self._weighed(z[part])
            jacobians[part] = self._slopes_of([(z[part], phi)])[0]
        return values, jacobians

    def _noted(self, z: FloatArray) -> tuple[FloatArray, Any]:
        if len(z) > _KEPT:
            return self._batch_jacobian(z)
        value, phi = self._weighed(z)
        return value, (z, phi)

    def _jacobians(self, notes: Sequence[Any]) -> FloatArray:
        return super()._jacobians(notes) if isinstance(notes[0], np.ndarray) else self._slopes_of(notes)

    def _weighed(self, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Values (..., n, n_out), and what each bump adds to them, (..., n_out, n, n_centres)."""
        phi = self.features(z) * self.weights[:, None, :]
        value = np.add.reduce(phi, axis=-1).swapaxes(-1, -2)
        return np.add(value, self.offset, out=np.empty((*z.shape[:-1], self.n_out))), phi

    def _slopes_of(self, notes: Sequence[tuple[FloatArray, FloatArray]]) -> FloatArray:
        """Jacobians (k, ..., n, n_out, n_in) from inputs and what each bump adds there, k times."""
        bumps = notes[0][1][None] if len(notes) == 1 else np.array([phi for _, phi in notes])
        slopes = np.matmul(bumps, self._slopes).swapaxes(-3, -2)
        centred = (np.array([z for z, _ in notes]) - self._middle)[..., None, :]
        result = np.multiply(slopes[..., self.n_in :], centred, out=np.empty((*slopes.shape[:-1], self.n_in)))
        return np.add(slopes[..., : self.n_in], result, out=result)

    def rescaled(self, scale: FloatArray, offset: FloatArray) -> KernelSum:
        """The model with outputs `y * scale + offset`."""
        return replace(
            self,
            weights=self.weights * scale[:, None],
            offset=self.offset * scale + offset,
            residual_std=self._std_times(scale),
        )


def stack_kernel_sums(models: list[KernelSum]) -> KernelSum:
    """One model of several with the same input scaling; blocks that are equal are shared.

    Args:
        models: models of one block each.
    """
    first = models[0]
    offset = np.concatenate([m.offset for m in models])
    shared = all(
        np.array_equal(m.centres, first.centres) and np.array_equal(m.length_scales, first.length_scales)
        for m in models
    )
    if shared:
        weights = np.concatenate([m.weights for m in models])
        return replace(first, weights=weights, offset=offset, residual_std=None)
    # Support vectors differ in number: pad with centres of weight 0.
    n = max(m.centres.shape[1] for m in models)
    outputs = [(m, o) for m in models for o in range(m.n_out)]
    centres = np.stack([np.pad(m.centres[0], ((0, n - m.centres.shape[1]), (0, 0)), "edge") for m, _ in outputs])
    scales = np.stack([m.length_scales[0] for m, _ in outputs])
    weights = np.stack([np.pad(m.weights[o], (0, n - m.centres.shape[1])) for m, o in outputs])
    return KernelSum(inputs=first.inputs, centres=centres, length_scales=scales, weights=weights, offset=offset)
