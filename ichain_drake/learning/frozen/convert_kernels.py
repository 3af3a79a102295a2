"""From fitted scikit-learn kernel models to `KernelSum` and `GaussianProcess`."""

from __future__ import annotations

from typing import Any

import numpy as np
from sklearn.base import is_classifier
from sklearn.gaussian_process.kernels import RBF, ConstantKernel, Product, Sum, WhiteKernel

from ichain_drake.errors import InputError
from ichain_drake.learning.frozen.gaussian_process import GaussianProcess
from ichain_drake.learning.frozen.kernel import KernelSum
from ichain_drake.learning.frozen.model import FrozenModel
from ichain_drake.learning.frozen.polynomial import Polynomial
from ichain_drake.learning.frozen.scaling import FloatArray, InputScaling


def kernel_ridge(estimator: Any) -> KernelSum:
    """Kernel ridge regression with an RBF kernel."""
    if estimator.kernel != "rbf":
        raise InputError(f"KernelRidge can be frozen with kernel='rbf' only, not {estimator.kernel!r}")
    centres = np.asarray(estimator.X_fit_, dtype=float)
    gamma = 1.0 / centres.shape[1] if estimator.gamma is None else float(estimator.gamma)
    dual = np.asarray(estimator.dual_coef_, dtype=float)
    weights = dual.reshape(len(centres), -1).T
    return _bumps(centres, gamma, weights, np.zeros(len(weights)))


def support_vectors(estimator: Any) -> FrozenModel:
    """Support vector regression, or the decision function of a binary support vector classifier."""
    name = type(estimator).__name__
    intercept = np.asarray(estimator.intercept_, dtype=float)
    if estimator.kernel == "linear":
        coef = np.asarray(estimator.coef_, dtype=float)
        return Polynomial.from_terms(np.eye(coef.shape[1], dtype=np.int64), coef, intercept)
    if estimator.kernel != "rbf":
        raise InputError(f"{name} can be frozen with kernel='rbf' or 'linear' only, not {estimator.kernel!r}")
    if is_classifier(estimator) and estimator.break_ties:
        raise InputError(f"{name} with break_ties can't be frozen; leave break_ties False")
    centres = np.asarray(estimator.support_vectors_, dtype=float)
    weights = np.asarray(estimator.dual_coef_, dtype=float)
    if len(centres) == 0:  # all training points inside the tube: a constant
        centres, weights = np.zeros((1, estimator.n_features_in_)), np.zeros((1, 1))
    return _bumps(centres, float(estimator._gamma), weights, intercept)


def gaussian_process(estimator: Any) -> GaussianProcess:
    """A Gaussian process with kernel Constant * RBF (+ White); its spread is that of `predict(return_std=True)`."""
    signal, length_scale, white = _kernel_parts(estimator.kernel_)
    centres = np.asarray(estimator.X_train_, dtype=float)
    n, d = centres.shape
    weights = np.asarray(estimator.alpha_, dtype=float).reshape(n, -1).T
    n_out = len(weights)
    nugget = np.broadcast_to(np.asarray(estimator.alpha, dtype=float) + white, (n_out, n))
    return GaussianProcess(
        inputs=InputScaling.identity(d),
        centres=centres,
        length_scales=np.broadcast_to(length_scale, (d,))[None],
        signal_variance=np.full(n_out, signal),
        noise_variance=np.full(n_out, white),
        nugget=nugget,
        weights=weights,
        exponents=np.zeros((1, d), dtype=np.int64),
        trend_variance=np.zeros((n_out, 1)),
        scale=np.broadcast_to(np.asarray(estimator._y_train_std, dtype=float), (n_out,)),
        offset=np.broadcast_to(np.asarray(estimator._y_train_mean, dtype=float), (n_out,)),
    )


def _bumps(centres: FloatArray, gamma: float, weights: FloatArray, offset: FloatArray) -> KernelSum:
    d = centres.shape[1]
    return KernelSum(
        inputs=InputScaling.identity(d),
        centres=centres[None],
        length_scales=np.full((1, d), np.sqrt(0.5 / gamma)),
        weights=weights,
        offset=offset,
    )


def _kernel_parts(kernel: Any) -> tuple[float, FloatArray, float]:
    """Signal variance, length scale and white noise of Constant * RBF (+ White), in any order."""
    terms, white, bumps = [kernel], 0.0, []
    while terms:
        term = terms.pop()
        if isinstance(term, Sum):
            terms += [term.k1, term.k2]
        elif isinstance(term, WhiteKernel):
            white += float(term.noise_level)
        else:
            bumps.append(term)
    signal, scales = 1.0, []
    factors = list(bumps)
    while factors:
        factor = factors.pop()
        if isinstance(factor, Product):
            factors += [factor.k1, factor.k2]
        elif isinstance(factor, ConstantKernel):
            signal *= float(factor.constant_value)
        elif type(factor) is RBF:
            scales.append(np.asarray(factor.length_scale, dtype=float))
        else:
            scales.clear()
            break
    if len(bumps) != 1 or len(scales) != 1:
        raise InputError(
            f"GaussianProcessRegressor with kernel {kernel} can't be frozen; use ConstantKernel * RBF, or that + "
            "WhiteKernel"
        )
    return signal, scales[0], white
