"""From fitted scikit-learn estimators to frozen models."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike
from sklearn import ensemble, gaussian_process, kernel_ridge, linear_model, neighbors, neural_network, svm, tree
from sklearn.base import is_classifier
from sklearn.compose import TransformedTargetRegressor
from sklearn.exceptions import NotFittedError
from sklearn.model_selection import GridSearchCV, RandomizedSearchCV
from sklearn.multioutput import MultiOutputRegressor
from sklearn.pipeline import Pipeline
from sklearn.preprocessing import PolynomialFeatures, StandardScaler
from sklearn.utils.validation import check_is_fitted

from ichain_drake.errors import InputError
from ichain_drake.learning.frozen import convert_kernels, convert_trees
from ichain_drake.learning.frozen.model import FrozenModel
from ichain_drake.learning.frozen.neighbours import Neighbours
from ichain_drake.learning.frozen.network import Network
from ichain_drake.learning.frozen.polynomial import Polynomial
from ichain_drake.learning.frozen.scaling import FloatArray, InputScaling
from ichain_drake.learning.frozen.stacked import stack

# Linear in their inputs, with `coef_` and `intercept_` and no link function.
_LINEAR = (
    "LinearRegression",
    "Ridge",
    "RidgeCV",
    "Lasso",
    "LassoCV",
    "LassoLars",
    "LassoLarsCV",
    "LassoLarsIC",
    "Lars",
    "LarsCV",
    "ElasticNet",
    "ElasticNetCV",
    "MultiTaskLasso",
    "MultiTaskLassoCV",
    "MultiTaskElasticNet",
    "MultiTaskElasticNetCV",
    "BayesianRidge",
    "ARDRegression",
    "HuberRegressor",
    "TheilSenRegressor",
    "QuantileRegressor",
    "OrthogonalMatchingPursuit",
    "OrthogonalMatchingPursuitCV",
    "SGDRegressor",
    "LogisticRegression",
    "LogisticRegressionCV",
    "RidgeClassifier",
    "RidgeClassifierCV",
    "SGDClassifier",
)

FREEZABLE = (
    "Pipelines of StandardScaler and PolynomialFeatures before linear models (LinearRegression, Ridge, Lasso, "
    "BayesianRidge, HuberRegressor, LogisticRegression, ...), StandardScaler before KernelRidge, SVR, SVC and "
    "GaussianProcessRegressor with RBF kernels, MLPRegressor, decision trees, random forests, extra trees, "
    "GradientBoostingRegressor, KNeighborsRegressor; MultiOutputRegressor and TransformedTargetRegressor of these; any "
    "estimator with a to_frozen() method"
)


@runtime_checkable
class Freezable(Protocol):
    """An estimator that knows how to freeze itself: the way to make one of your own usable in a learned graph."""

    def to_frozen(self) -> FrozenModel:
        """The fitted estimator as a frozen model."""


def freeze(estimator: Any, residual_std: ArrayLike | None = None) -> FrozenModel:
    """Turn a fitted estimator into plain numpy.

    A regressor's frozen value is its prediction. A binary classifier's is its decision function (for trees: the
    probability of class 1, minus 0.5): >= 0 means the second of its classes.

    Args:
        estimator: a fitted estimator.
        residual_std: standard deviation of the prediction error, a number or shape (n_out,), in the units of the
            outputs: the spread of estimators that have no predictive distribution of their own.

    Raises:
        InputError: if the estimator isn't fitted or can't be frozen; names its class and lists what can be.
    """
    try:
        check_is_fitted(estimator)
    except NotFittedError:
        raise InputError(f"{type(estimator).__name__} is not fitted: call fit before freezing it") from None
    except TypeError:
        raise InputError(f"{estimator!r} is not an estimator; what can be frozen: {FREEZABLE}") from None
    model = _convert(estimator)
    return model if residual_std is None else replace(model, residual_std=np.asarray(residual_std, dtype=float))


def _convert(estimator: Any) -> FrozenModel:
    if isinstance(estimator, Freezable):
        return estimator.to_frozen()
    for types, rule in _RULES:
        if isinstance(estimator, types):
            if is_classifier(estimator):
                _check_binary(estimator)
            return rule(estimator)
    raise InputError(f"{type(estimator).__name__} can't be frozen; what can be: {FREEZABLE}")


def _check_binary(classifier: Any) -> None:
    name = type(classifier).__name__
    if isinstance(classifier.classes_, list):
        raise InputError(f"{name} was fitted on several outputs; freeze one classifier an output")
    n = len(classifier.classes_)
    if n != 2:  # binary
        raise InputError(f"{name} was fitted on {n} class(es); a classifier to be frozen has exactly two")


def _pipeline(pipeline: Any) -> FrozenModel:
    steps = [step for _, step in pipeline.steps if step is not None and step != "passthrough"]
    model = _convert(steps[-1])
    for step in reversed(steps[:-1]):
        if isinstance(step, StandardScaler):
            model = _scaled(step, model)
        elif isinstance(step, PolynomialFeatures) and isinstance(model, Polynomial) and model.is_linear:
            model = model.of_features(np.asarray(step.powers_, dtype=np.int64))
        else:
            raise InputError(
                f"{type(step).__name__} before {type(steps[-1]).__name__} can't be frozen; what can be: {FREEZABLE}"
            )
    return model


def _mean_and_scale(scaler: Any) -> tuple[FloatArray, FloatArray]:
    n = scaler.n_features_in_
    mean = np.asarray(scaler.mean_, dtype=float) if scaler.with_mean else np.zeros(n)
    scale = np.asarray(scaler.scale_, dtype=float) if scaler.with_std else np.ones(n)
    return mean, scale


def _scaled(scaler: Any, model: FrozenModel) -> FrozenModel:
    mean, scale = _mean_and_scale(scaler)
    return replace(model, inputs=model.inputs.after(mean, scale))


def _transformed_target(estimator: Any) -> FrozenModel:
    if estimator.func is not None or not isinstance(estimator.transformer_, StandardScaler):
        raise InputError("TransformedTargetRegressor can be frozen with a StandardScaler transformer only")
    mean, scale = _mean_and_scale(estimator.transformer_)
    return _convert(estimator.regressor_).rescaled(scale, mean)


def _linear(estimator: Any) -> FrozenModel:
    coef = np.atleast_2d(np.asarray(estimator.coef_, dtype=float))
    intercept = np.broadcast_to(np.asarray(estimator.intercept_, dtype=float), (len(coef),))
    return Polynomial.from_terms(np.eye(coef.shape[1], dtype=np.int64), coef, intercept)


def _network(estimator: Any) -> FrozenModel:
    if estimator.out_activation_ != "identity":
        raise InputError("MLPRegressor can be frozen with loss='squared_error' only")
    return Network(
        inputs=InputScaling.identity(estimator.n_features_in_),
        activation=estimator.activation,
        matrices=[m.T for m in estimator.coefs_],
        biases=list(estimator.intercepts_),
    )


def _neighbours(estimator: Any) -> FrozenModel:
    euclidean = estimator.effective_metric_ in {"euclidean", "l2"}
    if estimator.weights not in {"uniform", "distance"} or not euclidean:
        raise InputError("KNeighborsRegressor can be frozen with uniform or distance weights and Euclidean metric only")
    targets = np.asarray(estimator._y, dtype=float)
    return Neighbours(
        inputs=InputScaling.identity(estimator.n_features_in_),
        points=np.asarray(estimator._fit_X, dtype=float),
        targets=targets.reshape(len(targets), -1),
        n_neighbours=np.array(estimator.n_neighbors, dtype=np.int64),
        by_distance=np.array(estimator.weights == "distance"),
    )


_RULES: list[tuple[Any, Callable[[Any], FrozenModel]]] = [
    (Pipeline, _pipeline),
    ((GridSearchCV, RandomizedSearchCV), lambda e: _convert(e.best_estimator_)),
    (MultiOutputRegressor, lambda e: stack([_convert(part) for part in e.estimators_])),
    (TransformedTargetRegressor, _transformed_target),
    (tuple(getattr(linear_model, name) for name in _LINEAR), _linear),
    ((svm.LinearSVR, svm.LinearSVC), _linear),
    (kernel_ridge.KernelRidge, convert_kernels.kernel_ridge),
    ((svm.SVR, svm.NuSVR, svm.SVC, svm.NuSVC), convert_kernels.support_vectors),
    (gaussian_process.GaussianProcessRegressor, convert_kernels.gaussian_process),
    (neural_network.MLPRegressor, _network),
    ((tree.DecisionTreeRegressor, tree.DecisionTreeClassifier), lambda e: convert_trees.mean_of_trees(e, [e])),
    (
        (
            ensemble.RandomForestRegressor,
            ensemble.ExtraTreesRegressor,
            ensemble.RandomForestClassifier,
            ensemble.ExtraTreesClassifier,
        ),
        lambda e: convert_trees.mean_of_trees(e, e.estimators_),
    ),
    (ensemble.GradientBoostingRegressor, convert_trees.boosted_trees),
    (neighbors.KNeighborsRegressor, _neighbours),
]
