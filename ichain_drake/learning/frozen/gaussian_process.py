"""Gaussian processes: a sum of Gaussian bumps plus a polynomial trend, with the exact predictive spread."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cholesky, solve_triangular

from ichain_drake.learning.blas import one_blas_thread
from ichain_drake.learning.frozen.kernel import KernelSum
from ichain_drake.learning.frozen.model import FrozenModel
from ichain_drake.learning.frozen.polynomial import Polynomial
from ichain_drake.learning.frozen.scaling import FloatArray, InputScaling


@dataclass(eq=False, kw_only=True)
class GaussianProcess(FrozenModel):
    """Posterior of `f(z) = b . m(z) + g(z)`, `b ~ N(0, trend_variance)`, `g ~ GP(0, signal_variance RBF)`.

    Rasmussen & Williams, Gaussian Processes for Machine Learning, 2006: eq. 2.25, 2.26 (posterior), sec. 2.7 (trend).

    Attributes:
        centres: the training inputs, scaled, shape (n_centres, n_in).
        length_scales: shape (n_out, n_in), or (1, n_in) where all outputs have the same kernel.
        signal_variance, noise_variance: shape (n_out,); the noise is part of the predictive spread.
        nugget: what was added to the kernel matrix's diagonal, shape (n_out, n_centres).
        weights: kernel matrix^-1 @ training outputs, shape (n_out, n_centres).
        exponents: monomials of the trend, closed under derivatives, shape (n_monomials, n_in).
        trend_variance: prior variance of the trend's coefficients, shape (n_out, n_monomials); 0 for no trend.
        scale, offset: outputs are `scale * f + offset`, shape (n_out,).
    """

    kind: ClassVar[str] = "gaussian_process"
    takes_batches: ClassVar[bool] = True

    centres: FloatArray
    length_scales: FloatArray
    signal_variance: FloatArray
    noise_variance: FloatArray
    nugget: FloatArray
    weights: FloatArray
    exponents: NDArray[np.int64]
    trend_variance: FloatArray
    scale: FloatArray
    offset: FloatArray

    def _prepare(self) -> None:
        plain = InputScaling.identity(self.n_in)
        blocks = len(self.length_scales)
        self._bumps = KernelSum(
            inputs=plain,
            centres=np.broadcast_to(self.centres, (blocks, *self.centres.shape)),
            length_scales=self.length_scales,
            weights=self.weights * (self.signal_variance * self.scale)[:, None],
            offset=self.offset,
        )
        self._trend = Polynomial(inputs=plain, exponents=self.exponents, weights=np.zeros((1, len(self.exponents))))
        self._has_trend = bool(self.trend_variance.any())
        if self._has_trend:
            m = self._trend.monomials.batch(self.centres)
            self._trend = replace(self._trend, weights=self.trend_variance * (self.weights @ m) * self.scale[:, None])

    @property
    def n_out(self) -> int:
        """Number of outputs."""
        return len(self.weights)

    @property
    def mean_parts(self) -> list[FrozenModel]:
        """Models of the scaled inputs whose sum is the mean: the bumps and, where there is one, the trend."""
        return [self._bumps, *([self._trend] if self._has_trend else [])]

    def _value(self, z: FloatArray) -> FloatArray:
        value = self._bumps._value(z)
        return value + self._trend._value(z) if self._has_trend else value

    def _value_and_jacobian(self, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        value, jacobian = self._bumps._value_and_jacobian(z)
        if not self._has_trend:
            return value, jacobian
        trend, slope = self._trend._value_and_jacobian(z)
        return value + trend, jacobian + slope

    def _batch(self, z: FloatArray) -> FloatArray:
        value = self._bumps._batch(z)
        return value + self._trend._batch(z) if self._has_trend else value

    def _batch_jacobian(self, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        values, jacobians = self._bumps._batch_jacobian(z)
        if not self._has_trend:
            return values, jacobians
        trend, slopes = self._trend._batch_jacobian(z)
        return values + trend, jacobians + slopes

    def _noted(self, z: FloatArray) -> tuple[FloatArray, Any]:
        values, bumps = self._bumps._noted(z)
        if not self._has_trend:
            return values, (bumps, None)
        trend, slopes = self._trend._noted(z)
        return values + trend, (bumps, slopes)

    def _jacobians(self, notes: Sequence[Any]) -> FloatArray:
        bumps = self._bumps._jacobians([note for note, _ in notes])
        return bumps + self._trend._jacobians([note for _, note in notes]) if self._has_trend else bumps

    @cached_property
    def _whitening(self) -> list[FloatArray]:
        """Inverse Cholesky factor of each output's kernel matrix; computed at the first spread, then kept."""
        bumps = self._bumps.features(self.centres)
        m = self._trend.monomials.batch(self.centres)
        factors: list[FloatArray] = []
        for o in range(self.n_out):
            twin = next((p for p in range(o) if self._same_kernel(o, p)), None)
            if twin is not None:
                factors.append(factors[twin])
                continue
            kernel = self.signal_variance[o] * bumps[min(o, len(bumps) - 1)] + (m * self.trend_variance[o]) @ m.T
            kernel.flat[:: len(kernel) + 1] += self.nugget[o]
            # One BLAS thread: the same factor in every bit for any number of worker processes.
            with one_blas_thread():
                lower = cholesky(kernel, lower=True)
                factors.append(solve_triangular(lower, np.eye(len(lower)), lower=True))
        return factors

    def _same_kernel(self, o: int, p: int) -> bool:
        blocks = len(self.length_scales)
        return (
            (blocks == 1 or np.array_equal(self.length_scales[o], self.length_scales[p]))
            and self.signal_variance[o] == self.signal_variance[p]
            and np.array_equal(self.nugget[o], self.nugget[p])
            and np.array_equal(self.trend_variance[o], self.trend_variance[p])
        )

    @property
    def has_spread(self) -> bool:
        """Always: the predictive variance is its own."""
        return True

    def _batch_spread(self, z: FloatArray) -> FloatArray:
        bumps = self._bumps.features(z)
        m = self._trend.monomials.batch(z)
        m_centres = self._trend.monomials.batch(self.centres) if self._has_trend else None
        result = np.empty((len(z), self.n_out))
        for o, whitening in enumerate(self._whitening):
            cross = self.signal_variance[o] * bumps[min(o, len(bumps) - 1)]
            prior = np.full(len(z), self.signal_variance[o])
            if m_centres is not None:
                cross += (m * self.trend_variance[o]) @ m_centres.T
                prior += (m * m) @ self.trend_variance[o]
            explained = np.square(cross @ whitening.T).sum(axis=1)
            # Rounding can leave a hair below zero at a training point without noise.
            result[:, o] = np.sqrt(np.maximum(prior - explained, 0.0) + self.noise_variance[o])
        return result * self.scale

    def rescaled(self, scale: FloatArray, offset: FloatArray) -> GaussianProcess:
        """The model with outputs `y * scale + offset`."""
        return replace(
            self,
            scale=self.scale * scale,
            offset=self.offset * scale + offset,
            residual_std=self._std_times(scale),
        )


def stack_gaussian_processes(models: list[GaussianProcess]) -> GaussianProcess:
    """One model of several with the same input scaling, training inputs and trend monomials."""
    first = models[0]
    same = all(len(m.length_scales) == 1 and np.array_equal(m.length_scales, first.length_scales) for m in models)
    per_output = [np.broadcast_to(m.length_scales, (m.n_out, m.n_in)) for m in models]
    names = ("signal_variance", "noise_variance", "nugget", "weights", "trend_variance", "scale", "offset")
    joined: dict[str, Any] = {name: np.concatenate([getattr(m, name) for m in models]) for name in names}
    scales = first.length_scales if same else np.concatenate(per_output)
    return replace(first, length_scales=scales, residual_std=None, **joined)
