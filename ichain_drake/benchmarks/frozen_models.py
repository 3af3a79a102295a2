"""Frozen numpy evaluation against scikit-learn's `predict`, one row at a time as a callback needs it."""

from __future__ import annotations

import functools
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
from sklearn.exceptions import ConvergenceWarning
from sklearn.linear_model import Ridge
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import PolynomialFeatures, StandardScaler

from ichain_drake.benchmarks.measure import seconds_a_call
from ichain_drake.learning.estimators import make_estimator
from ichain_drake.learning.frozen import freeze

_INPUTS, _OUTPUTS, _SAMPLES = 6, 2, 500


def _ridge(degree: int) -> Any:
    return make_pipeline(StandardScaler(), PolynomialFeatures(degree), Ridge(1e-3))


_MODELS: dict[str, Callable[[], Any]] = {
    "pipeline, degree 2": lambda: _ridge(2),
    "pipeline, degree 3": lambda: _ridge(3),
    "kernel_ridge": lambda: make_estimator("kernel_ridge"),
    "mlp": lambda: make_estimator("mlp"),
    "nearest_neighbours": lambda: make_estimator("nearest_neighbours"),
    "extra_trees": lambda: make_estimator("extra_trees"),
}


def benchmark_frozen_models(repeats: int, models: tuple[str, ...] = tuple(_MODELS)) -> list[dict[str, Any]]:
    """One row a model: time of `predict`, of the frozen value, of value and Jacobian [us], and how far they differ.

    Args:
        repeats: rounds.
        models: which of the models.
    """
    random = np.random.default_rng(0)
    x = random.standard_normal((_SAMPLES, _INPUTS))
    y = np.stack([np.sin(x[:, 0]) * x[:, 1] + x[:, 2], x[:, 3] ** 2 - x[:, 4] * x[:, 5]], axis=1)
    y += 0.05 * random.standard_normal((_SAMPLES, _OUTPUTS))
    row = x[0] + 0.1
    rows = []
    for name in models:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ConvergenceWarning)  # how well it fits is not the question here
            estimator = _MODELS[name]().fit(x, y)
        frozen = freeze(estimator)
        predict = seconds_a_call(functools.partial(estimator.predict, row[None]), repeats, 5)
        value = seconds_a_call(functools.partial(frozen.value, row), repeats, 50)
        jacobian = seconds_a_call(functools.partial(frozen.value_and_jacobian, row), repeats, 20)
        rows.append(
            {
                "model": name,
                "predict_us": 1e6 * predict,
                "frozen_us": 1e6 * value,
                "frozen_jacobian_us": 1e6 * jacobian,
                "speedup": predict / value,
                "difference": float(np.abs(frozen.value(row) - estimator.predict(row[None])[0]).max()),
            }
        )
    return rows
