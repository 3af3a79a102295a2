"""Marginal likelihood of a Gaussian process with a polynomial trend, its gradient, and conditioning on the data."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dpotrf, dpotri

from ichain_drake.errors import InputError
from ichain_drake.learning.frozen.scaling import FloatArray

# Natural logarithms of hyper-parameters, for inputs and outputs of standard deviation 1.
_SCALE_PRIOR = (np.log(3.0), 1.5)  # mean and width of a weak prior on the length scales
BOUNDS = {"scale": (np.log(0.05), np.log(100.0)), "signal": (-14.0, 5.0), "noise": (-16.0, 1.0), "trend": (-14.0, 5.0)}
START = {"scale": np.log(3.0), "signal": np.log(0.3), "noise": np.log(0.03), "trend": np.log(0.3)}


@dataclass
class Evidence:
    """Marginal likelihood of one output and its gradient (Rasmussen & Williams 2006, eq. 5.8 and 5.9).

    Attributes:
        x: scaled inputs, shape (n, d).
        trends: Gram matrices of the trend's monomials, one for each degree from 1, each (n, n); the constant (prior
            variance 1) is always there.
    """

    x: FloatArray
    trends: list[FloatArray]

    def __post_init__(self) -> None:
        self._diagonal = slice(None, None, len(self.x) + 1)

    def kernel(self, theta: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Kernel matrix with noise, and its Gaussian part; theta: log scales (d), signal, noise, trend (degree)."""
        d = self.x.shape[1]
        scaled = self.x * np.exp(-theta[:d])
        norms = np.einsum("ij,ij->i", scaled, scaled)
        bumps = scaled @ scaled.T
        bumps -= 0.5 * norms[:, None]
        bumps -= 0.5 * norms
        np.minimum(bumps, 0.0, out=bumps)
        np.exp(bumps, out=bumps)
        bumps *= np.exp(theta[d])
        full = bumps + 1.0
        for log_variance, gram in zip(theta[d + 2 :], self.trends, strict=True):
            full += np.exp(log_variance) * gram
        full.flat[self._diagonal] += np.exp(theta[d + 1])
        return full, bumps

    def __call__(self, theta: FloatArray, y: FloatArray) -> tuple[float, FloatArray]:
        """Negative log marginal likelihood (up to a constant) with the weak prior on scales, and its gradient."""
        d = self.x.shape[1]
        full, bumps = self.kernel(theta)
        lower, failed = dpotrf(full, lower=1, overwrite_a=1)
        if failed:
            return 1e10, np.zeros(len(theta))
        log_det = 2.0 * np.log(lower.diagonal()).sum()
        inverse, _ = dpotri(lower, lower=1)
        inverse = np.tril(inverse)
        inverse = inverse + np.tril(inverse, -1).T
        a = inverse @ y
        inner = np.outer(a, a)
        inner -= inverse
        weighted = inner * bumps
        rows = weighted.sum(axis=1)
        gradient = np.empty(len(theta))
        squares = rows @ self.x**2 - np.einsum("ij,ij->j", self.x, weighted @ self.x)
        gradient[:d] = squares * np.exp(-2.0 * theta[:d])
        gradient[d] = 0.5 * rows.sum()
        gradient[d + 1] = 0.5 * np.exp(theta[d + 1]) * inner.trace()
        for k, gram in enumerate(self.trends):
            gradient[d + 2 + k] = 0.5 * np.exp(theta[d + 2 + k]) * np.vdot(inner, gram)
        centre, width = _SCALE_PRIOR
        away = (theta[:d] - centre) / width
        value = 0.5 * (y @ a + log_det + away @ away)
        gradient[:d] -= away / width
        return float(value), -gradient


def grams(features: FloatArray, degrees: NDArray[np.int64]) -> list[FloatArray]:
    """Gram matrix of the monomials of each degree from 1, features of shape (n, n_monomials)."""
    parts = (features[:, degrees == k] for k in range(1, int(degrees.max()) + 1))
    return [part @ part.T for part in parts]


def condition(evidence: Evidence, thetas: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Weights K^-1 y and leave-one-out residuals (Rasmussen & Williams 2006, eq. 5.12) of each output.

    Args:
        evidence: on all samples.
        thetas: hyper-parameters, one row an output.
        y: scaled outputs, shape (n, n_out).

    Returns:
        both of shape (n_out, n).
    """
    weights, left_out = np.empty(y.T.shape), np.empty(y.T.shape)
    for o, theta in enumerate(thetas):
        lower, failed = dpotrf(evidence.kernel(theta)[0], lower=1)
        if failed:
            raise InputError("PolynomialGaussianProcess: the kernel matrix is singular: are many samples repeated?")
        inverse, _ = dpotri(lower, lower=1)
        inverse = np.tril(inverse) + np.tril(inverse, -1).T
        weights[o] = inverse @ y[:, o]
        left_out[o] = weights[o] / inverse.diagonal()
    return weights, left_out
