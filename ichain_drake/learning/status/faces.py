"""The faces of a box around one class of samples: placed by counting, then by likelihood under the readings' noise."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from ichain_drake.learning.selection import log_probability
from ichain_drake.learning.settings import LEARNING
from ichain_drake.state import FloatArray, IntArray

_PLACES = 33  # places of a face that are compared


class Faces:
    """A box that is being fitted.

    Args:
        x: samples, shape (n, n_features).
        positive: whether each is one to be inside, shape (n,).
        reach: see `BoxClassifier`.
        weight: of a sample to be inside, where one to be outside counts 1.
        order: that of another box around the same samples: sorting is most of the work where they are many.

    Attributes:
        low, high: the faces, shape (n_features,).
        order: samples in ascending order of each feature, shape (n_features, n).
    """

    def __init__(
        self,
        x: FloatArray,
        positive: NDArray[np.bool_],
        reach: float,
        weight: float = 1.0,
        order: IntArray | None = None,
    ) -> None:
        self.x, self.positive, self.reach, self.weight = x, positive, reach, weight
        self.low, self.high = x[positive].min(axis=0), x[positive].max(axis=0)
        self.order = np.argsort(x.T, axis=1, kind="stable") if order is None else order

    def inside(self, but: int = -1) -> NDArray[np.bool_]:
        """Whether each sample lies within all intervals, but for that of one feature, shape (n,)."""
        within = (self.x >= self.low) & (self.x <= self.high)
        if but >= 0:
            within[:, but] = True
        return within.all(axis=1)

    def count(self) -> None:
        """Move one face after the other to where most samples lie on the right side."""
        beyond = ((self.x < self.low) | (self.x > self.high)).T.copy()  # a row a feature
        faces = beyond.sum(axis=0)  # of a sample: how many features are beyond their interval
        counted: dict[tuple[int, int], NDArray[np.bool_]] = {}  # among which samples a face was placed last
        for _ in range(LEARNING.sweeps):
            before = self.low.copy(), self.high.copy()
            for j, column in enumerate(self.x.T):
                others = faces == beyond[j]
                if not (others & self.positive).any():
                    continue
                for sign in (-1, 1):
                    among = others & (column <= self.high[j] if sign < 0 else column >= self.low[j])
                    if (j, sign) not in counted or not np.array_equal(counted[j, sign], among):
                        self._place(j, sign, among)
                        counted[j, sign] = among
                faces -= beyond[j]
                beyond[j] = (column < self.low[j]) | (column > self.high[j])
                faces += beyond[j]
            if np.array_equal(before[0], self.low) and np.array_equal(before[1], self.high):
                break

    def _place(self, j: int, sign: int, among: NDArray[np.bool_]) -> None:
        """Place a feature's upper face, or with sign -1 its lower one, by counting among some samples."""
        order = self.order[j][::sign]
        rows = order[among[order]]
        if sign > 0:
            self.high[j] = self._counted(self.x[rows, j], self.positive[rows], self.high[j])
        else:
            self.low[j] = -self._counted(-self.x[rows, j], self.positive[rows], -self.low[j])

    def _counted(self, values: FloatArray, on: NDArray[np.bool_], now: float) -> float:
        """The best upper threshold of a column, given ascending samples that lie within all other faces."""
        if not on.any():
            return now
        # Right if the threshold lies after sample k: positives up to k, negatives beyond it.
        inside = np.cumsum(on)
        right = self.weight * inside + (len(on) - inside[-1]) - (np.arange(1, len(on) + 1) - inside)
        right[:-1][values[1:] <= values[:-1]] = -1.0  # a threshold can't part equal values
        k = int(len(right) - 1 - np.argmax(right[::-1]))
        within = values[: k + 1][on[: k + 1]]
        if not len(within):
            return now
        top, width = float(within[-1]), float(within[-1] - within[0])
        gap = float(values[k + 1] - top) if k + 1 < len(values) else np.inf
        free = self.reach * width if width > 0 else (gap if np.isfinite(gap) else 1.0)
        return top + min(0.5 * gap, free) + 1e-12 * max(1.0, abs(top))

    def shown(self) -> NDArray[np.bool_]:
        """Beyond which faces negatives were seen, lower faces then upper, shape (2, n_features)."""
        negative = self.x[~self.positive]
        return np.stack([(negative < self.low).any(axis=0), (negative > self.high).any(axis=0)])

    def settle(self, noise: FloatArray, slip: float, shown: NDArray[np.bool_]) -> None:
        """Move the faces that are shown to the mean of their likelihood.

        Args:
            noise: standard deviation of a reading of each feature, shape (n_features,).
            slip: probability of a wrong class.
            shown: see there.
        """
        for j in np.flatnonzero(noise > 0).tolist():
            others = self.inside(but=j)
            column, truth = self.x[others, j], self.positive[others]
            if not truth.any():
                continue
            middle = 0.5 * (self.low[j] + self.high[j])
            if shown[1, j]:
                keep = column >= middle
                self.high[j] = _likely(column[keep], truth[keep], self.high[j], noise[j], slip)
            if shown[0, j]:
                keep = column <= middle
                self.low[j] = -_likely(-column[keep], truth[keep], -self.low[j], noise[j], slip)


def _likely(column: FloatArray, truth: NDArray[np.bool_], face: float, noise: float, slip: float) -> float:
    """Mean of an upper face under its likelihood, from the gap around where it is and what noise may hide."""
    inside, outside = column[truth & (column <= face)], column[~truth & (column > face)]
    if not len(inside) or not len(outside):
        return face
    # As far on the one side as on the other: a face that `reach` holds back isn't pushed on.
    half = min(face - inside.max(), outside.min() - face) + 4.0 * noise
    places = np.linspace(face - half, face + half, _PLACES)
    near = np.abs(column - face) < half + 6.0 * noise
    phi = ndtr((places[:, None] - column[near]) / noise)
    weight = log_probability(truth[near], phi, slip).sum(axis=1)
    weight = np.exp(weight - weight.max())
    return float(places @ weight / weight.sum())
