"""A classifier that is a conjunction of intervals: every input must lie between two thresholds.

Conditions of activation often are of this sort (a place within reach, a level above a threshold). Few demonstrations
then pin down every face by itself, where a kernel machine would need examples of every corner. A face that no inactive
example pins down stays close to the active ones.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import ndtr
from sklearn.base import BaseEstimator, ClassifierMixin
from sklearn.utils import Tags
from sklearn.utils.multiclass import check_classification_targets
from sklearn.utils.validation import check_is_fitted, validate_data

from ichain_drake.errors import InputError
from ichain_drake.learning.frozen import FrozenModel, InputScaling
from ichain_drake.learning.selection import log_probability
from ichain_drake.learning.status.faces import Faces
from ichain_drake.state import FloatArray


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
        inside = (1.0 - np.abs(z - self.middle) / self.half).min(axis=1, keepdims=True, initial=1.0)
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

    Each threshold goes where most samples that lie within all other intervals are classified rightly. Between the last
    sample of the second class and the first beyond it, every place explains the classes equally well, but for the noise
    of readings: a class follows from the true state, of which a sample is a reading (errors in variables). So a face
    lies at the mean of its likelihood there, `Phi((face - reading) / noise)`, no further from the samples of the second
    class than `reach`.

    Args:
        reach: how far a face may lie beyond the samples of the second class, as a share of their range.
        noise: standard deviation of a reading, of every input or shape (n_features,).
        partial: whether the inputs may be some of the conditions only. Few of the samples inside are then of the second
            class, and none of these must be given up to keep the many others out: what a sample on the wrong side
            costs is the likelihood under the share of the second class inside.

    Attributes:
        classes_: the two classes.
        lower_: thresholds, shape (n_features,).
        upper_: thresholds, shape (n_features,).
        shown_: whether samples of the first class lie beyond a face, lower faces then upper, shape (2, n_features).
            What lies beyond another face is not known.
        slip_: probability of a wrong class.
    """

    def __init__(
        self,
        reach: float = 0.3,
        noise: float | Sequence[float] | FloatArray = 0.0,
        partial: bool = False,
    ) -> None:
        self.reach = reach
        self.noise = noise
        self.partial = partial

    def fit(self, X: ArrayLike, y: ArrayLike) -> Self:
        """Fit.

        Args:
            X: inputs, shape (n_samples, n_features).
            y: classes, shape (n_samples,).

        Raises:
            InputError: on more or fewer than two classes, a negative reach, or noise of a wrong shape or sign.
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
        noise = np.asarray(self.noise, dtype=float)
        if noise.shape not in ((), (x.shape[1],)) or not (noise >= 0).all():
            raise InputError(f"BoxClassifier: noise {self.noise!r}: give one number from 0, or one an input")
        return self.fit_flags(x, code == 1)

    def fit_flags(self, x: FloatArray, positive: NDArray[np.bool_]) -> Self:
        """Fit to what was checked before, for `log_likelihood` alone: `fit` without checks and classes.

        With few samples they would be most of the work.

        Args:
            x: finite inputs, shape (n_samples, n_features).
            positive: whether each sample is of the second class, shape (n_samples,); some are, some are not.
        """
        noise = np.broadcast_to(np.asarray(self.noise, dtype=float), (x.shape[1],))
        faces = self._placed(x, positive)
        self.slip_ = (1.0 + np.sum(faces.inside() != positive)) / (2.0 + len(x))
        self.shown_ = faces.shown()
        if noise.any():
            faces.settle(noise, self.slip_, self.shown_)
        self.lower_, self.upper_ = faces.low, faces.high
        return self

    def _placed(self, x: FloatArray, positive: NDArray[np.bool_]) -> Faces:
        """The faces, by counting."""
        faces, slip = Faces(x, positive, self.reach), 1.0 / (2.0 + len(x))
        share, before = float(positive.mean()), -1.0
        while self.partial and share > before:
            weight = np.log(share / slip) / np.log((1.0 - slip) / (1.0 - share))
            faces, before = Faces(x, positive, self.reach, max(float(weight), 1.0), faces.order), share
            faces.count()
            share = min(float(positive[faces.inside()].mean()), 1.0 - slip)
        if not self.partial:
            faces.count()
        return faces

    def log_likelihood(self, X: ArrayLike, truth: NDArray[np.bool_], slip: float) -> FloatArray:
        """Log-likelihood of flags given readings, shape (n_samples,); what is beyond a face not shown stays open.

        Args:
            X: inputs, shape (n_samples, n_features).
            truth: whether each sample is of the second class, shape (n_samples,).
            slip: probability of a wrong flag.
        """
        x = np.asarray(X, dtype=float)
        noise = np.broadcast_to(np.maximum(np.asarray(self.noise, dtype=float), 1e-12), (x.shape[1],))
        inside = np.ones(len(x))
        for j, (low, high) in enumerate(self.shown_.T):
            if high:
                inside *= ndtr((self.upper_[j] - x[:, j]) / noise[j])
            if low:
                inside *= ndtr((x[:, j] - self.lower_[j]) / noise[j])
        return log_probability(truth, inside, slip)

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
