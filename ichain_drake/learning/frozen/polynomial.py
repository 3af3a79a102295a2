"""Polynomials (linear models included) as one gather, one product and one matrix-vector product."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from ichain_drake.errors import InputError
from ichain_drake.learning.frozen.model import FrozenModel
from ichain_drake.learning.frozen.monomials import Monomials
from ichain_drake.learning.frozen.scaling import FloatArray, InputScaling


@dataclass(eq=False, kw_only=True)
class Polynomial(FrozenModel):
    """`y = weights @ monomials(z)`; the constant monomial carries the intercept.

    With the three spread fields it has the predictive variance of Bayesian linear regression,
    `noise_std^2 (base + sum_r gain_r (projection m(z))_r^2)`.

    Attributes:
        exponents: shape (n_monomials, n_in), closed under derivatives (as `Monomials` orders them).
        weights: shape (n_out, n_monomials).
        noise_std: shape (n_out,).
        spread_base: shape (n_out,): 1 for the noise itself plus the variance of the intercept.
        spread_gain: shape (n_out, n_directions).
        spread_projection: shape (n_directions, n_monomials).
    """

    kind: ClassVar[str] = "polynomial"
    takes_batches: ClassVar[bool] = True

    exponents: NDArray[np.int64]
    weights: FloatArray
    noise_std: FloatArray | None = None
    spread_base: FloatArray | None = None
    spread_gain: FloatArray | None = None
    spread_projection: FloatArray | None = None

    @classmethod
    def from_terms(cls, exponents: NDArray[np.int64], coef: FloatArray, intercept: FloatArray) -> Polynomial:
        """A polynomial from the coefficients of some monomials.

        Args:
            exponents: shape (n_terms, n_in).
            coef: shape (n_out, n_terms).
            intercept: shape (n_out,).
        """
        monomials = Monomials(exponents)
        weights = np.zeros((len(coef), len(monomials)))
        weights[:, monomials.positions] = coef
        weights[:, 0] += intercept
        return cls(inputs=InputScaling.identity(exponents.shape[1]), exponents=monomials.exponents, weights=weights)

    def _prepare(self) -> None:
        self.monomials = Monomials(self.exponents)
        if not np.array_equal(self.monomials.exponents, self.exponents):
            raise InputError("frozen polynomial: its exponents are not ordered and closed as Monomials makes them")
        lower = self.monomials.derivative(self.weights)
        self._slopes = lower.reshape(self.n_out * self.n_in, self.monomials.n_lower)
        self._weights_t = np.ascontiguousarray(self.weights.T)

    @property
    def n_out(self) -> int:
        """Number of outputs."""
        return len(self.weights)

    def _value(self, z: FloatArray) -> FloatArray:
        return self.weights @ self.monomials.row(z)

    def _value_and_jacobian(self, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        m = self.monomials.row(z)
        return self.weights @ m, (self._slopes @ m[: self.monomials.n_lower]).reshape(self.n_out, self.n_in)

    def _batch(self, z: FloatArray) -> FloatArray:
        return self.monomials.batch(z) @ self._weights_t

    def _batch_jacobian(self, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        value, m = self._noted(z)
        return value, self._jacobians([m])[0]

    def _noted(self, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        m = self.monomials.batch(z)
        return m @ self._weights_t, m

    def _jacobians(self, notes: Sequence[FloatArray]) -> FloatArray:
        if self.monomials.degree == 1:  # the same everywhere
            shape = (len(notes), *notes[0].shape[:-1], self.n_out, self.n_in)
            return np.array(np.broadcast_to(self._slopes.reshape(self.n_out, self.n_in), shape))
        slopes = np.array(notes)[..., : self.monomials.n_lower] @ self._slopes.T
        return slopes.reshape(*slopes.shape[:-1], self.n_out, self.n_in)

    @property
    def has_spread(self) -> bool:
        """Whether `spread` can answer: with its own predictive variance or a given residual_std."""
        return self.noise_std is not None or self.residual_std is not None

    def _batch_spread(self, z: FloatArray) -> FloatArray:
        noise, base, gain, projection = self.noise_std, self.spread_base, self.spread_gain, self.spread_projection
        if noise is None or base is None or gain is None or projection is None:
            return super()._batch_spread(z)
        q = self.monomials.batch(z) @ projection.T
        return noise * np.sqrt(base + (q * q) @ gain.T)

    def rescaled(self, scale: FloatArray, offset: FloatArray) -> Polynomial:
        """The model with outputs `y * scale + offset`."""
        weights = self.weights * scale[:, None]
        weights[:, 0] += offset
        noise = None if self.noise_std is None else self.noise_std * scale
        return replace(self, weights=weights, residual_std=self._std_times(scale), noise_std=noise)

    @property
    def is_linear(self) -> bool:
        """Whether it is linear in its inputs, without clip and without a spread of its own."""
        return self.monomials.degree <= 1 and np.isinf(self.inputs.clip) and self.noise_std is None

    def of_features(self, exponents: NDArray[np.int64]) -> Polynomial:
        """A linear model of monomial features as a polynomial of the variables.

        Args:
            exponents: exponents of the features that are this model's inputs, shape (n_in, n_variables).
        """
        coef = np.zeros((self.n_out, self.n_in))
        for j, row in enumerate(self.exponents):
            if row.any():
                coef[:, int(np.argmax(row))] = self.weights[:, j]
        coef = coef / self.inputs.scale
        return Polynomial.from_terms(exponents, coef, self.weights[:, 0] - coef @ self.inputs.mean)
