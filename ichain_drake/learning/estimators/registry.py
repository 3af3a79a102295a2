"""Estimators by plain name: short names for what works well here, and scikit-learn's class names."""

from __future__ import annotations

import difflib
import inspect
from collections.abc import Callable, Sequence
from functools import cache
from typing import Any

from sklearn.base import BaseEstimator
from sklearn.compose import TransformedTargetRegressor
from sklearn.ensemble import ExtraTreesRegressor
from sklearn.kernel_ridge import KernelRidge
from sklearn.multioutput import MultiOutputRegressor
from sklearn.neighbors import KNeighborsRegressor
from sklearn.neural_network import MLPRegressor
from sklearn.pipeline import Pipeline, make_pipeline
from sklearn.preprocessing import StandardScaler
from sklearn.svm import SVC
from sklearn.utils import all_estimators, get_tags

from ichain_drake.errors import InputError
from ichain_drake.learning.estimators.gaussian_process import PolynomialGaussianProcess
from ichain_drake.learning.estimators.polynomial import PolynomialRegressor
from ichain_drake.learning.estimators.rectified import RectifiedLinearRegressor


def _scaled(regressor: BaseEstimator) -> BaseEstimator:
    """The regressor on standardised inputs and outputs."""
    return TransformedTargetRegressor(make_pipeline(StandardScaler(), regressor), transformer=StandardScaler())


def kernel_ridge(alpha: float = 0.03, gamma: float | None = 0.03) -> BaseEstimator:
    """Kernel ridge regression with an RBF kernel on standardised data."""
    return _scaled(KernelRidge(kernel="rbf", alpha=alpha, gamma=gamma))


def mlp(
    hidden_layer_sizes: Sequence[int] = (32, 32),
    activation: str = "tanh",
    alpha: float = 0.3,
    max_iter: int = 500,
    random_state: int = 0,
) -> BaseEstimator:
    """A small neural network on standardised data: the data is small, so L-BFGS and a strong penalty."""
    return _scaled(
        MLPRegressor(
            hidden_layer_sizes=tuple(hidden_layer_sizes),
            activation=activation,
            solver="lbfgs",
            alpha=alpha,
            max_iter=max_iter,
            random_state=random_state,
        )
    )


def extra_trees(n_estimators: int = 100, min_samples_leaf: int = 2, random_state: int = 0) -> BaseEstimator:
    """Extremely randomised trees."""
    return ExtraTreesRegressor(n_estimators=n_estimators, min_samples_leaf=min_samples_leaf, random_state=random_state)


def nearest_neighbours(n_neighbors: int = 8, weights: str = "distance") -> BaseEstimator:
    """Nearest neighbours on standardised inputs."""
    return make_pipeline(StandardScaler(), KNeighborsRegressor(n_neighbors=n_neighbors, weights=weights))


# A new estimator of this library: one line here.
OWN: dict[str, Callable[..., BaseEstimator]] = {
    "polynomial": PolynomialRegressor,
    "rectified_linear": RectifiedLinearRegressor,
    "gaussian_process": PolynomialGaussianProcess,
    "kernel_ridge": kernel_ridge,
    "mlp": mlp,
    "extra_trees": extra_trees,
    "nearest_neighbours": nearest_neighbours,
}


# Scikit-learn's that are candidates unless others are asked for: known without a walk through all of its modules.
_USUAL: dict[str, Callable[..., BaseEstimator]] = {"SVC": SVC}


@cache
def _sklearn_classes() -> dict[str, Callable[..., BaseEstimator]]:
    return dict(all_estimators(type_filter=["regressor", "classifier"]))


def estimator_names() -> tuple[str, ...]:
    """All names that `make_estimator` knows: this library's, then scikit-learn's."""
    return (*OWN, *_sklearn_classes())


def make_estimator(name: str, /, **parameters: Any) -> BaseEstimator:
    """An unfitted estimator by plain name; nothing is imported by a path from the name.

    Args:
        name: `polynomial`, `rectified_linear`, `gaussian_process`, `kernel_ridge`, `mlp`, `extra_trees`,
            `nearest_neighbours`, or the class name of a scikit-learn regressor or classifier.
        parameters: its constructor's.

    Raises:
        InputError: on an unknown name (with close ones), an unknown parameter, or one that is missing.
    """
    make = OWN.get(name) or _USUAL.get(name) or _sklearn_classes().get(name)
    if make is None:
        lowered = {known.lower(): known for known in estimator_names()}
        close = [lowered[c] for c in difflib.get_close_matches(name.lower(), lowered, n=3)]
        hint = f"did you mean {' or '.join(close)}?" if close else f"use {', '.join(OWN)} or a scikit-learn class name"
        raise InputError(f"there is no estimator {name!r}; {hint}")
    signature = inspect.signature(make)
    for parameter in parameters:
        if parameter not in signature.parameters:
            raise InputError(
                f"estimator {name} has no parameter {parameter!r}; it has {', '.join(signature.parameters) or 'none'}"
            )
    for needed, declared in signature.parameters.items():
        if declared.default is inspect.Parameter.empty and needed not in parameters:
            raise InputError(f"estimator {name} needs the parameter {needed!r}")
    return make(**parameters)


def for_outputs(estimator: BaseEstimator, n_out: int) -> BaseEstimator:
    """The estimator itself, or one copy an output where it predicts a single output only."""
    # The tags of pipelines and transformed targets say one output only, whatever is inside.
    inner = estimator
    while isinstance(inner, TransformedTargetRegressor | Pipeline):
        inner = inner[-1] if isinstance(inner, Pipeline) else inner.regressor
    # MLPRegressor predicts several outputs, but its tag (scikit-learn 1.9) doesn't say so.
    if n_out == 1 or get_tags(inner).target_tags.multi_output or isinstance(inner, MLPRegressor):
        return estimator
    return MultiOutputRegressor(estimator)
