"""Polynomial regression with an exact leave-one-out choice of its ridge penalty and an exact predictive spread."""

from __future__ import annotations

import math
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from ichain_drake.errors import InputError
from ichain_drake.learning.blas import one_blas_thread
from ichain_drake.learning.estimators.frozen_regressor import SpreadRegressor
from ichain_drake.learning.frozen.monomials import Monomials, all_exponents
from ichain_drake.learning.frozen.polynomial import Polynomial
from ichain_drake.learning.frozen.scaling import FloatArray, InputScaling
from ichain_drake.learning.settings import LEARNING


def standardisation(x: FloatArray, clip: float | None) -> InputScaling:
    """Mean 0 and standard deviation 1 for each column of x (n, n_in); a constant column is only shifted."""
    scale = x.std(axis=0)
    # A column that is constant up to rounding must not be blown up to noise of size 1.
    scale = np.where(scale > 10 * np.finfo(float).eps * np.abs(x).max(axis=0), scale, 1.0)
    return InputScaling(x.mean(axis=0), scale, np.inf if clip is None else clip)


def check_samples(n: int, n_monomials: int, degree: int, name: str) -> None:
    """Refuse too few samples for a degree: fewer than 5, or than a third of the monomials.

    Raises:
        InputError: states the number of samples, the degree and the number needed.
    """
    needed = max(LEARNING.short, -(-n_monomials // 3))
    if n < needed:
        raise InputError(
            f"{name}: n_samples = {n} for degree {degree} ({n_monomials} monomials); at least {needed} are needed: "
            "record more demonstrations or lower the degree"
        )


class PolynomialRegressor(SpreadRegressor[Polynomial]):
    """Ridge regression on all monomials of standardised inputs, one penalty an output.

    The penalty of each output is the one with the least leave-one-out error, computed exactly from one singular
    value decomposition (Golub, Heath & Wahba 1979; e_i / (1 - h_ii)). The spread is that of Bayesian linear
    regression, sigma^2 (1 + 1/n + phi^T (Phi^T Phi + alpha I)^-1 phi) (Bishop 2006, eq. 3.59).

    Args:
        degree: highest total degree of the monomials.
        alphas: ridge penalties to choose from, > 0; monomials have mean 0 and standard deviation 1.
        clip: bound on standardised inputs, or None: outside the demonstrations a polynomial runs away.

    Attributes:
        alpha_: chosen penalty, shape (n_outputs,).
        residual_std_: leave-one-out standard deviation of the residuals, shape (n_outputs,), in the outputs' units.
        noise_std_: sigma of the predictive spread, shape (n_outputs,).
        model_: the frozen polynomial.
    """

    def __init__(
        self, degree: int = 2, alphas: ArrayLike = (1e-4, 1e-3, 1e-2, 0.1, 1.0, 10.0, 100.0), clip: float | None = 4.0
    ) -> None:
        self.degree = degree
        self.alphas = alphas
        self.clip = clip

    def fit(self, X: ArrayLike, y: ArrayLike) -> Self:  # noqa: N803 - scikit-learn's name
        """Fit.

        Args:
            X: inputs, shape (n_samples, n_features).
            y: outputs, shape (n_samples,) or (n_samples, n_outputs).

        Raises:
            InputError: on too few samples for the degree, or on parameters out of range.
        """
        alphas = np.asarray(self.alphas, dtype=float).ravel()
        if not isinstance(self.degree, int | np.integer) or self.degree < 1:
            raise InputError(f"PolynomialRegressor: degree {self.degree!r}: give a whole number >= 1")
        if len(alphas) == 0 or not np.isfinite(alphas).all() or (alphas <= 0).any():
            raise InputError(f"PolynomialRegressor: alphas {self.alphas!r}: give numbers > 0")
        if self.clip is not None and not self.clip > 0:
            raise InputError(f"PolynomialRegressor: clip {self.clip!r}: give a number > 0, or None")
        x, targets = self.check_data(X, y)

        # Counted before they are listed: of a high degree there are more than memory holds.
        n, m = len(x), math.comb(x.shape[1] + int(self.degree), int(self.degree))
        check_samples(n, m, self.degree, "PolynomialRegressor")
        monomials = Monomials(all_exponents(x.shape[1], self.degree))
        inputs = standardisation(x, self.clip)
        raw = monomials.batch(inputs.apply(x))[:, 1:]
        mean, scale = raw.mean(axis=0), raw.std(axis=0)
        scale = np.where(scale > 1e-12 * np.abs(raw).max(axis=0), scale, 1.0)
        phi = (raw - mean) / scale
        offset = targets.mean(axis=0)
        centred = targets - offset

        # One BLAS thread: the same model in every bit on every machine load and for any number of worker processes.
        with one_blas_thread():
            u, s, vt = np.linalg.svd(phi, full_matrices=n < m)
        rank = len(s)
        u = u[:, :rank]
        projected = u.T @ centred  # (rank, n_outputs)
        best = np.full(targets.shape[1], np.inf)
        self.alpha_ = np.empty_like(best)
        self.noise_std_ = np.empty_like(best)
        shrunk = np.empty_like(projected)
        for alpha in alphas:
            filtered = s**2 / (s**2 + alpha)
            hat = 1.0 / n + (u * u) @ filtered
            residual = centred - u @ (filtered[:, None] * projected)
            left_out = residual / np.maximum(1.0 - hat, 1e-10)[:, None]
            error = np.sqrt(np.mean(left_out**2, axis=0))
            better = error < best
            best = np.where(better, error, best)
            self.alpha_[better] = alpha
            # E[e_i^2] = sigma^2 (1 - h_ii): unbiased without a penalty, finite even when the fit interpolates.
            self.noise_std_[better] = np.sqrt(np.mean(residual * left_out, axis=0))[better]
            shrunk[:, better] = ((s / (s**2 + alpha))[:, None] * projected)[:, better]
        self.residual_std_ = best
        coef = (vt[:rank].T @ shrunk).T / scale

        weights = np.column_stack([offset - coef @ mean, coef])
        energies = np.zeros(len(vt))
        energies[:rank] = s**2
        projection = vt / scale
        self.model_ = Polynomial(
            inputs=inputs,
            exponents=monomials.exponents,
            weights=weights,
            residual_std=self.residual_std_.copy(),
            noise_std=self.noise_std_.copy(),
            spread_base=np.full(len(best), 1.0 + 1.0 / n),
            spread_gain=1.0 / (energies + self.alpha_[:, None]),
            spread_projection=np.column_stack([-projection @ mean, projection]),
        )
        return self
