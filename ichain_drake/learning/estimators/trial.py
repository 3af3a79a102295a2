"""Trying an estimator out on a few rows: what can't be fitted or frozen is refused before minutes of other work."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
from sklearn.base import is_classifier, is_regressor

from ichain_drake.errors import InputError
from ichain_drake.learning.estimators.registry import for_outputs
from ichain_drake.learning.frozen import freeze


def try_out(estimator: Any, *, classifier: bool = False) -> None:
    """Fit an estimator to made-up rows and freeze it.

    Args:
        estimator: unfitted; it is fitted.
        classifier: whether it has to classify.

    Raises:
        InputError: if it is of the wrong kind, or can't be fitted or frozen; says why in one line.
    """
    x = np.random.default_rng(0).normal(size=(60, 2))  # two inputs: the fewest that an interaction has
    try:
        if classifier and not is_classifier(estimator):
            raise InputError("it is no classifier, and whether an interaction is active is yes or no")
        if not classifier and not is_regressor(estimator):
            raise InputError("it is no regressor, and effects are numbers")
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # about made-up rows
            if classifier:
                freeze(estimator.fit(x, x[:, 0] > 0.0))
            else:
                freeze(for_outputs(estimator, 2).fit(x, x @ [[1.0, -0.5], [0.0, 2.0]]))
    except Exception as error:  # whatever an estimator of anybody may raise
        text = " ".join(str(error).split())
        if not isinstance(error, InputError):
            why = f"{type(error).__name__}: {text[:300]}"
            text = f"it can't be fitted with these parameters ({why}); change or leave out one"
        raise InputError(text[:600]) from None
