"""Gaussian process regression with a polynomial trend: fast to fit on some hundred samples and several outputs."""

from __future__ import annotations

import math
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import minimize
from sklearn.utils import check_random_state

from ichain_drake.errors import InputError
from ichain_drake.learning.blas import one_blas_thread
from ichain_drake.learning.estimators.evidence import BOUNDS, START, Evidence, condition, grams
from ichain_drake.learning.estimators.frozen_regressor import SpreadRegressor
from ichain_drake.learning.estimators.polynomial import check_samples, standardisation
from ichain_drake.learning.frozen.gaussian_process import GaussianProcess
from ichain_drake.learning.frozen.monomials import Monomials, all_exponents
from ichain_drake.learning.frozen.scaling import FloatArray


class PolynomialGaussianProcess(SpreadRegressor[GaussianProcess]):
    """A Gaussian process an output: polynomial trend + anisotropic RBF + noise, hyper-parameters by evidence.

    The trend's coefficients have a Gaussian prior whose variance, one for each degree, is chosen along with the other
    hyper-parameters, so trend and deviations from it share the data rightly and the spread is exact (Rasmussen &
    Williams 2006, sec. 2.7 and 5.4.1).

    Args:
        degree: degree of the trend; 0 for a constant.
        clip: bound on standardised inputs, or None.
        search_samples: hyper-parameters are searched on at most this many samples, drawn at random.
        max_samples: at most this many samples, drawn at random, become centres.
        max_iter: steps of the search.
        n_restarts: further searches from random starts; the best counts.
        random_state: seed of the draws.

    Attributes:
        length_scales_: shape (n_outputs, n_features), in standard deviations of the inputs.
        noise_std_: shape (n_outputs,), in the outputs' units.
        n_iter_: steps of the longest search.
        residual_std_: leave-one-out standard deviation of the residuals, shape (n_outputs,).
        model_: the frozen process.
    """

    def __init__(
        self,
        degree: int = 2,
        clip: float | None = 4.0,
        search_samples: int = 500,
        max_samples: int = 1500,
        max_iter: int = 60,
        n_restarts: int = 0,
        random_state: int | np.random.RandomState | None = 0,
    ) -> None:
        self.degree = degree
        self.clip = clip
        self.search_samples = search_samples
        self.max_samples = max_samples
        self.max_iter = max_iter
        self.n_restarts = n_restarts
        self.random_state = random_state

    def fit(self, X: ArrayLike, y: ArrayLike) -> Self:  # noqa: N803 - scikit-learn's name
        """Fit.

        Args:
            X: inputs, shape (n_samples, n_features).
            y: outputs, shape (n_samples,) or (n_samples, n_outputs).

        Raises:
            InputError: on too few samples for the degree, or on parameters out of range.
        """
        self._check_parameters()
        x, targets = self.check_data(X, y)
        count = math.comb(x.shape[1] + int(self.degree), int(self.degree))
        check_samples(len(x), count, self.degree, "PolynomialGaussianProcess")
        monomials = Monomials(all_exponents(x.shape[1], self.degree))

        # One BLAS thread: the search ends at the same parameters for any number of threads and worker processes.
        with one_blas_thread():
            return self._fit(x, targets, monomials)

    def _fit(self, x: FloatArray, targets: FloatArray, monomials: Monomials) -> Self:
        random = check_random_state(self.random_state)
        inputs = standardisation(x, self.clip)
        kept = _draw(random, len(x), self.max_samples)
        z, targets = inputs.apply(x)[kept], targets[kept]
        outputs = standardisation(targets, None)
        scaled = outputs.apply(targets)
        degrees = monomials.exponents.sum(axis=1)
        features = monomials.batch(z)
        searched = _draw(random, len(z), self.search_samples)
        evidence = Evidence(z[searched], grams(features[searched], degrees))
        self.n_iter_ = 0
        thetas = np.array([self._search(evidence, column[searched], random) for column in scaled.T])
        weights, left_out = condition(Evidence(z, grams(features, degrees)), thetas, scaled)

        d, n = z.shape[1], len(z)
        variances = np.exp(thetas[:, d:])
        self.length_scales_ = np.exp(thetas[:, :d])
        self.noise_std_ = np.sqrt(variances[:, 1]) * outputs.scale
        self.residual_std_ = np.sqrt(np.mean(left_out**2, axis=1)) * outputs.scale
        self.model_ = GaussianProcess(
            inputs=inputs,
            centres=z,
            length_scales=self.length_scales_.copy(),
            signal_variance=variances[:, 0],
            noise_variance=variances[:, 1],
            nugget=np.repeat(variances[:, 1:2], n, axis=1),
            weights=weights,
            exponents=monomials.exponents,
            # columns of `variances`: signal, noise, then one for each degree from 1; the constant's is 1
            trend_variance=np.column_stack([np.ones(len(thetas)), variances[:, 2:]])[:, degrees],
            scale=outputs.scale,
            offset=outputs.mean,
            residual_std=self.residual_std_.copy(),
        )
        return self

    def _check_parameters(self) -> None:
        if not isinstance(self.degree, int | np.integer) or self.degree < 0:
            raise InputError(f"PolynomialGaussianProcess: degree {self.degree!r}: give a whole number >= 0")
        if self.clip is not None and not self.clip > 0:
            raise InputError(f"PolynomialGaussianProcess: clip {self.clip!r}: give a number > 0, or None")
        for name, least in (("max_iter", 1), ("n_restarts", 0)):
            if getattr(self, name) < least:
                raise InputError(
                    f"PolynomialGaussianProcess: {name} {getattr(self, name)!r}: give a whole number >= {least}"
                )
        for name in ("search_samples", "max_samples"):
            if getattr(self, name) < 5:  # as few as check_samples allows
                raise InputError(f"PolynomialGaussianProcess: {name} {getattr(self, name)!r}: give at least 5")

    def _search(self, evidence: Evidence, y: FloatArray, random: np.random.RandomState) -> FloatArray:
        names = ["scale"] * evidence.x.shape[1] + ["signal", "noise"] + ["trend"] * self.degree
        bounds = [BOUNDS[name] for name in names]
        start = np.array([START[name] for name in names])
        best: tuple[float, FloatArray] = (np.inf, start)
        for trial in range(1 + self.n_restarts):
            guess = start if trial == 0 else np.clip(start + random.normal(size=len(start)), *np.transpose(bounds))
            found = minimize(
                evidence, guess, args=(y,), jac=True, method="L-BFGS-B", bounds=bounds,
                options={"maxiter": self.max_iter},
            )  # fmt: skip
            self.n_iter_ = max(self.n_iter_, int(found.nit))
            if found.fun < best[0]:
                best = (float(found.fun), found.x)
        return best[1]


def _draw(random: np.random.RandomState, n: int, most: int) -> NDArray[np.intp]:
    """Indices of at most `most` of n samples, in their order."""
    return np.arange(n) if n <= most else np.sort(random.choice(n, most, replace=False))
