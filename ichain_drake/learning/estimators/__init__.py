"""Estimators for demonstrations: this library's own, and any of scikit-learn's by name."""

from ichain_drake.learning.estimators.gaussian_process import PolynomialGaussianProcess
from ichain_drake.learning.estimators.polynomial import PolynomialRegressor
from ichain_drake.learning.estimators.rectified import RectifiedLinearRegressor
from ichain_drake.learning.estimators.registry import OWN, estimator_names, for_outputs, make_estimator

__all__ = [
    "OWN",
    "PolynomialGaussianProcess",
    "PolynomialRegressor",
    "RectifiedLinearRegressor",
    "estimator_names",
    "for_outputs",
    "make_estimator",
]
