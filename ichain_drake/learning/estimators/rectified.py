"""Rectified linear regression: nothing happens below a threshold, and what happens beyond it is linear."""

from __future__ import annotations

from typing import Self

import numpy as np
from numpy.typing import ArrayLike
from sklearn.utils import Tags

from ichain_drake.errors import InputError
from ichain_drake.learning.estimators.frozen_regressor import FrozenRegressor
from ichain_drake.learning.estimators.polynomial import standardisation
from ichain_drake.learning.frozen.network import Network
from ichain_drake.learning.frozen.scaling import FloatArray


class RectifiedLinearRegressor(FrozenRegressor[Network]):
    """`y = s max(0, w x + b)` with s = +-1, one threshold and one slope an output.

    What overflows, leaks or is pushed beyond a stop is of this form, and a few samples pin it down where a smooth
    regression needs many and leaves small flows where there is none. Fitted by alternating between the rows beyond
    the threshold and least squares on them, from several starts, in fixed order; the fit of least squared error over
    all rows is kept.

    Args:
        alpha: ridge penalty a row, > 0, on standardised inputs.
        max_iter: most alternations from each start.
        starts: shares of the largest output, from which on the first fit takes rows as beyond the threshold.

    Attributes:
        n_iter_: alternations of the start that took longest.
        model_: the frozen network of one rectified unit an output.
    """

    def __init__(self, alpha: float = 1e-6, max_iter: int = 30, starts: tuple[float, ...] = (0.05, 0.2, 0.5)) -> None:
        self.alpha = alpha
        self.max_iter = max_iter
        self.starts = starts

    def fit(self, X: ArrayLike, y: ArrayLike) -> Self:  # noqa: N803 - scikit-learn's name
        """Fit.

        Args:
            X: inputs, shape (n_samples, n_features).
            y: outputs, shape (n_samples,) or (n_samples, n_outputs).

        Raises:
            InputError: on a penalty or a number of alternations that is not positive.
        """
        if not self.alpha > 0:
            raise InputError(f"RectifiedLinearRegressor: alpha {self.alpha!r}: give a number > 0")
        if not self.max_iter >= 1:
            raise InputError(f"RectifiedLinearRegressor: max_iter {self.max_iter!r}: give a whole number >= 1")
        x, targets = self.check_data(X, y)
        inputs = standardisation(x, None)
        phi = np.column_stack([inputs.apply(x), np.ones(len(x))])
        self.n_iter_ = 1
        fits = [self._fit_output(phi, target) for target in targets.T]
        weights = np.array([w for w, _ in fits])
        self.model_ = Network(
            inputs=inputs,
            activation="relu",
            matrices=[weights[:, :-1], np.diag([sign for _, sign in fits])],
            biases=[weights[:, -1], np.zeros(len(fits))],
        )
        return self

    def _fit_output(self, phi: FloatArray, y: FloatArray) -> tuple[FloatArray, float]:
        """Weights with the threshold last, shape (n_features + 1,), and the sign."""
        best, best_error = (np.zeros(phi.shape[1]), 1.0), float(y @ y)
        for sign in (1.0, -1.0):
            target = sign * y
            largest = float(target.max())
            if largest <= 0:
                continue
            for share in self.starts:
                rows = target > share * largest
                for iteration in range(self.max_iter):
                    self.n_iter_ = max(self.n_iter_, iteration + 1)
                    w = self._least_squares(phi[rows], target[rows])
                    value = phi @ w
                    error = float(np.sum((target - np.maximum(value, 0.0)) ** 2))
                    if error < best_error:
                        best, best_error = (w, sign), error
                    beyond = value > 0
                    if not beyond.any() or np.array_equal(beyond, rows):
                        break
                    rows = beyond
        return best

    def _least_squares(self, phi: FloatArray, y: FloatArray) -> FloatArray:
        penalty = self.alpha * len(phi) * np.eye(phi.shape[1])
        return np.asarray(np.linalg.solve(phi.T @ phi + penalty, phi.T @ y), dtype=float)

    def __sklearn_tags__(self) -> Tags:
        tags = super().__sklearn_tags__()
        tags.regressor_tags.poor_score = True  # one threshold describes few of scikit-learn's test data
        return tags
