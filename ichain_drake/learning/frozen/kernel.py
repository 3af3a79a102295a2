"""Sums of Gaussian bumps: kernel ridge regression, support vector machines and the mean of a Gaussian process."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from ichain_drake.learning.frozen.model import FrozenModel
from ichain_drake.learning.frozen.scaling import FloatArray

_ROWS = 256  # rows evaluated at once: bounds the memory of a large batch
_TABLES = 16  # tables of two rows evaluated at once: the bumps of more would not stay in the processor's cache


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
        self._precision = 1.0 / self.length_scales**2
        linear = centred * self._precision[:, None, :]
        square = np.broadcast_to(-0.5 * self._precision[:, None, :], linear.shape)
        constant = -0.5 * (centred * linear).sum(axis=2, keepdims=True)
        table = np.concatenate([linear, square, constant], axis=2)  # (blocks, n, 2 d + 1)
        self._table = np.ascontiguousarray(table.reshape(blocks * n, -1).T)
        # For many rows, what is squared is the same number for all bumps of a block, and summed once.
        table = np.concatenate([linear, constant, np.ones((blocks, n, 1))], axis=2)
        self._tables = np.ascontiguousarray(table.swapaxes(1, 2))  # (blocks, d + 2, n)
        self._blocks = blocks
        # What a bump adds to an output's derivatives, but for what its square part does, and to the output: one product
        # for both. (blocks, d + 1 for each output of a block, n): the order that is fastest for a few rows.
        added = self.weights[:, :, None] * np.concatenate([linear, np.ones((blocks, n, 1))], axis=2)
        if blocks == 1:
            added = added.swapaxes(0, 1).reshape(1, n, -1)
        self._sums = np.ascontiguousarray(added.swapaxes(1, 2))

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

    def _of_row(self, phi: FloatArray) -> FloatArray:
        if self._blocks == 1:
            return self.weights @ phi[0] + self.offset
        return np.einsum("kn,kn->k", self.weights, phi) + self.offset

    def _value(self, z: FloatArray) -> FloatArray:
        return self._of_row(self._row_features(z)[1])

    def _value_and_jacobian(self, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        centred, phi = self._row_features(z)
        sums = (phi[:, None] @ self._sums.swapaxes(1, 2)).reshape(self.n_out, -1)
        return self._of_row(phi), sums[:, :-1] - sums[:, -1:] * centred * self._precision

    def features(self, z: FloatArray) -> FloatArray:
        """Values of all bumps, (..., n, n_in) -> (..., n_blocks, n, n_centres)."""
        return self._bumps(z)[1]

    def _bumps(self, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Inputs from the middle of the centres, (..., n, n_in), and the values of all bumps."""
        d = self.n_in
        centred = z - self._middle
        u = np.empty((*z.shape[:-1], self._blocks, d + 2))
        u[..., :d] = centred[..., None, :]
        u[..., d] = 1.0
        np.multiply(np.add.reduce((centred * centred)[..., None, :] * self._precision, axis=-1), -0.5, out=u[..., -1])
        phi = u.swapaxes(-2, -3) @ self._tables
        return centred, np.exp(phi, out=phi)

    def _batch(self, z: FloatArray) -> FloatArray:
        return _in_parts(self._some, z)[0]

    def _batch_jacobian(self, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        values, jacobians = _in_parts(self._some_with_jacobians, z)
        return values, jacobians

    def _some(self, z: FloatArray) -> tuple[FloatArray]:
        """`_batch` of so few rows that the memory is no question."""
        blocks, n = self._blocks, self.weights.shape[1]
        weights = self.weights.reshape(blocks, self.n_out // blocks, n)
        sums = self._bumps(z)[1] @ weights.swapaxes(1, 2)  # (..., n_blocks, n, outputs of a block)
        return (sums.swapaxes(-3, -2).reshape(*z.shape[:-1], self.n_out) + self.offset,)

    def _some_with_jacobians(self, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        centred, phi = self._bumps(z)
        sums = (phi @ self._sums.swapaxes(1, 2)).swapaxes(-3, -2).reshape(*z.shape[:-1], self.n_out, self.n_in + 1)
        values = sums[..., -1]
        jacobians = values[..., None] * centred[..., None, :]
        jacobians *= self._precision
        return values + self.offset, np.subtract(sums[..., :-1], jacobians, out=jacobians)

    def rescaled(self, scale: FloatArray, offset: FloatArray) -> KernelSum:
        """The model with outputs `y * scale + offset`."""
        return replace(
            self,
            weights=self.weights * scale[:, None],
            offset=self.offset * scale + offset,
            residual_std=self._std_times(scale),
        )


def _in_parts(evaluate: Callable[[FloatArray], tuple[FloatArray, ...]], z: FloatArray) -> tuple[FloatArray, ...]:
    """What an evaluation gives for tables of rows, (..., n, n_in), some at a time.

    A table of one row is evaluated as one of the rows of a table of two, with the next one's row or, if there is none,
    its own: BLAS takes as long for one row as for two, and sums for two in the same order however many such tables
    there are. Tables of more rows would cost more where there is but one.
    """
    if len(z) == 1 and z.ndim == 2:
        return tuple(f[:1] for f in evaluate(np.repeat(z, 2, axis=0)))
    if z.shape[-2] == 1:
        rows = z.reshape(-1, z.shape[-1])
        pairs = np.concatenate([rows, rows[-1:]]) if len(rows) % 2 else rows
        found = _in_parts(evaluate, pairs.reshape(-1, 2, z.shape[-1]))
        return tuple(f.reshape(-1, *f.shape[2:])[: len(rows)].reshape(*z.shape[:-1], *f.shape[2:]) for f in found)
    step = _ROWS if z.ndim == 2 else _TABLES
    if len(z) <= step:
        return evaluate(z)
    parts = [evaluate(z[start : start + step]) for start in range(0, len(z), step)]
    return tuple(np.concatenate(of) for of in zip(*parts, strict=True))


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
