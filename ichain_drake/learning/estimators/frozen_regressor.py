"""Base classes of estimators whose `fit` makes a frozen model: its checks, `predict`, and what scikit-learn asks."""

from __future__ import annotations

from typing import Generic, Literal, TypeVar, overload

import numpy as np
from numpy.typing import ArrayLike
from sklearn.base import BaseEstimator, RegressorMixin
from sklearn.utils import Tags
from sklearn.utils.validation import check_is_fitted, validate_data

from ichain_drake.learning.frozen.model import FrozenModel
from ichain_drake.learning.frozen.scaling import FloatArray

ModelT = TypeVar("ModelT", bound=FrozenModel)


class FrozenRegressor(RegressorMixin, BaseEstimator, Generic[ModelT]):
    """A regressor of one or several outputs that is a frozen model once it is fitted.

    A subclass has a constructor, and a `fit` that begins with `check_data` and ends with setting `model_`.

    Attributes:
        model_: the frozen model.
    """

    model_: ModelT
    _single: bool

    def check_data(self, X: ArrayLike, y: ArrayLike) -> tuple[FloatArray, FloatArray]:  # noqa: N803 - scikit-learn's
        """Check what `fit` is given, and remember the shape of its outputs for `predict`.

        Args:
            X: inputs, shape (n_samples, n_features).
            y: outputs, shape (n_samples,) or (n_samples, n_outputs).

        Returns:
            Inputs and outputs, the latter of shape (n_samples, n_outputs).

        Raises:
            ValueError: as scikit-learn's `validate_data`.
        """
        x, checked = validate_data(self, X, y, multi_output=True, y_numeric=True, dtype=np.float64)
        targets = np.asarray(checked, dtype=float).reshape(len(x), -1)
        self._single = checked.ndim == 1
        return x, targets

    def predict(self, X: ArrayLike) -> FloatArray:  # noqa: N803 - scikit-learn's name
        """Predict.

        Args:
            X: inputs, shape (n_samples, n_features).

        Returns:
            shape (n_samples,) or (n_samples, n_outputs), as y in `fit`.
        """
        x = self._check_inputs(X)
        return self._as_fitted(self.model_.batch(x))

    def _check_inputs(self, rows: ArrayLike) -> FloatArray:
        check_is_fitted(self)
        return np.asarray(validate_data(self, rows, reset=False, dtype=np.float64))

    def _as_fitted(self, outputs: FloatArray) -> FloatArray:
        return outputs[:, 0] if self._single else outputs

    def __sklearn_tags__(self) -> Tags:
        tags = super().__sklearn_tags__()
        tags.target_tags.multi_output = True
        return tags

    def to_frozen(self) -> ModelT:
        """The fitted model for `freeze`."""
        check_is_fitted(self)
        return self.model_


class SpreadRegressor(FrozenRegressor[ModelT]):
    """A `FrozenRegressor` whose model knows its predictive spread."""

    @overload
    def predict(self, X: ArrayLike, return_std: Literal[False] = False) -> FloatArray: ...  # noqa: N803
    @overload
    def predict(self, X: ArrayLike, return_std: Literal[True]) -> tuple[FloatArray, FloatArray]: ...  # noqa: N803
    def predict(self, X: ArrayLike, return_std: bool = False) -> FloatArray | tuple[FloatArray, FloatArray]:  # noqa: N803
        """Predict.

        Args:
            X: inputs, shape (n_samples, n_features).
            return_std: also give the predictive standard deviation, noise included.

        Returns:
            shape (n_samples,) or (n_samples, n_outputs), as y in `fit`; with `return_std` twice that.
        """
        x = self._check_inputs(X)
        mean = self._as_fitted(self.model_.batch(x))
        return (mean, self._as_fitted(self.model_.batch_spread(x))) if return_std else mean
