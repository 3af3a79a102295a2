"""A classifier that is a conjunction of intervals: every input must lie between two thresholds.

Conditions of activation often are of this sort (a place within reach, a level above a threshold). Few demonstrations
then pin down every face by itself, where a kernel machine would need examples of every corner. A face that no inactive
example pins down stays close to the active ones.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike
from sklearn.base import BaseEstimator, ClassifierMixin
from sklearn.utils import Tags
from sklearn.utils.multiclass import check_classification_targets
from sklearn.utils.validation import check_is_fitted, validate_data

from ichain_drake.errors import InputError
from ichain_drake.learning.frozen import FrozenModel, InputScaling
from ichain_drake.state import FloatArray

_SWEEPS = 6


@dataclass(eq=False, kw_only=True)
class Box(FrozenModel):
    """`y = min over inputs of (1 - |z - middle| / half)`: 1 in the middle, 0 at the faces, negative outside.

    Attributes:
        middle: shape (n_in,).
        half: half-widths, shape (n_in,), > 0.
        gain: factor on the value, shape (1,).
        offset: added to it, shape (1,).
    """

    kind: ClassVar[str] = "box"

    middle: FloatArray
    half: FloatArray
    gain: FloatArray
    offset: FloatArray

    @property
    def n_out(self) -> int:
        """One decision value."""
        return 1

    def _value(self, z: FloatArray) -> FloatArray:
        return self._batch(z[None])[0]

    def _batch(self, z: FloatArray) -> FloatArray:
        inside = (1.0 - np.abs(z - self.middle) / self.half).min(axis=1, keepdims=True)
        return inside * self.gain + self.offset

    def _value_and_jacobian(self, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        k = int(np.argmin(1.0 - np.abs(z - self.middle) / self.half))
        jacobian = np.zeros((1, self.n_in))
        jacobian[0, k] = -np.sign(z[k] - self.middle[k]) / self.half[k] * self.gain[0]
        return self._value(z), jacobian

    def rescaled(self, scale: FloatArray, offset: FloatArray) -> Box:
        """The model with outputs `y * scale + offset`."""
        return replace(
            self,
            gain=self.gain * scale,
            offset=self.offset * scale + offset,
            residual_std=self._std_times(scale),
        )


class BoxClassifier(ClassifierMixin, BaseEstimator):
    """Intervals on every input, fitted to the second class by moving one threshold at a time.

    Each threshold goes where most samples that lie within all other intervals are classified rightly; then to the
    middle of the gap there, but no further from the samples of the second class than `reach`.

    Args:
        reach: how far a face may lie beyond the samples of the second class, as a share of their range.

    Attributes:
        classes_: the two classes.
        lower_: thresholds, shape (n_features,).
        upper_: thresholds, shape (n_features,).
    """

    def __init__(self, reach: float = 0.3) -> None:
        self.reach = reach

    def fit(self, X: ArrayLike, y: ArrayLike) -> Self:
        """Fit.

        Args:
            X: inputs, shape (n_samples, n_features).
            y: classes, shape (n_samples,).

        Raises:
            InputError: on more or fewer than two classes, or a negative reach.
        """
        x, labels = validate_data(self, X, y, dtype=np.float64)
        check_classification_targets(labels)
        self.classes_, code = np.unique(labels, return_inverse=True)
        if len(self.classes_) != 2:  # noqa: PLR2004
            # The second sentence is what scikit-learn's contract asks for.
            raise InputError(
                f"BoxClassifier: needs two classes, {len(self.classes_)} class(es) given. "
                "Only binary classification is supported."
            )
        if not self.reach >= 0:
            raise InputError(f"BoxClassifier: reach {self.reach!r}: give a number from 0")
        positive = code == 1
        low, high = x[positive].min(axis=0), x[positive].max(axis=0)
        for _ in range(_SWEEPS):
            before = low.copy(), high.copy()
            for j in range(x.shape[1]):
                others = np.ones(len(x), dtype=bool)
                for i in range(x.shape[1]):
                    if i != j:
                        others &= (x[:, i] >= low[i]) & (x[:, i] <= high[i])
                column, truth = x[others, j], positive[others]
                if not truth.any():
                    continue
                keep = column <= high[j]
                low[j] = -self._face(-column[keep], truth[keep], -low[j])
                keep = column >= low[j]
                high[j] = self._face(column[keep], truth[keep], high[j])
            if np.array_equal(before[0], low) and np.array_equal(before[1], high):
                break
        self.lower_, self.upper_ = low, high
        return self

    def _face(self, column: FloatArray, truth: np.ndarray, now: float) -> float:
        """The best upper threshold of a column, given samples that lie within all other faces."""
        if not truth.any():
            return now
        order = np.argsort(column, kind="stable")
        values, on = column[order], truth[order]
        # Right if the threshold lies after sample k: positives up to k, negatives beyond it.
        right = np.cumsum(on) + (len(on) - on.sum()) - np.cumsum(~on)
        last = np.append(values[1:] > values[:-1], True)  # a threshold can't part equal values
        right = np.where(last, right, -1)
        k = int(len(right) - 1 - np.argmax(right[::-1]))
        inside = values[: k + 1][on[: k + 1]]
        if not len(inside):
            return now
        top, width = float(inside[-1]), float(inside[-1] - inside[0])
        gap = float(values[k + 1] - top) if k + 1 < len(values) else np.inf
        free = self.reach * width if width > 0 else (gap if np.isfinite(gap) else 1.0)
        return top + min(0.5 * gap, free) + 1e-12 * max(1.0, abs(top))

    def decision_function(self, X: ArrayLike) -> FloatArray:
        """Decision values, shape (n_samples,): >= 0 inside."""
        check_is_fitted(self)
        x = validate_data(self, X, reset=False, dtype=np.float64)
        return self.to_frozen().batch(x)[:, 0]

    def predict(self, X: ArrayLike) -> np.ndarray:
        """Classes, shape (n_samples,)."""
        check_is_fitted(self)
        return self.classes_[(self.decision_function(X) >= 0).astype(int)]

    def __sklearn_tags__(self) -> Tags:
        tags = super().__sklearn_tags__()
        tags.classifier_tags.multi_class = False
        tags.classifier_tags.poor_score = True
        return tags

    def to_frozen(self) -> Box:
        """The fitted box for `freeze`."""
        check_is_fitted(self)
        half = np.maximum(0.5 * (self.upper_ - self.lower_), 1e-9)
        return Box(
            inputs=InputScaling.identity(len(half)),
            middle=0.5 * (self.lower_ + self.upper_),
            half=half,
            gain=np.ones(1),
            offset=np.zeros(1),
        )
