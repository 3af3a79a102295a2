"""Fast choice of columns: forward selection by the error on left-out groups, from sums of products alone."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from itertools import combinations_with_replacement

import numpy as np
from numpy.typing import NDArray

from ichain_drake.learning.settings import LEARNING
from ichain_drake.state import FloatArray

_RIDGE = 1e-3
_BEYOND = 0.15  # of the largest target: where an alternation takes rows as beyond a threshold at first


def window_means(values: FloatArray, windows: Sequence[tuple[int, int]]) -> FloatArray:
    """Mean of rows over windows, shape (n, ...) -> (n_windows, ...)."""
    total = np.concatenate([np.zeros((1, *values.shape[1:])), np.cumsum(values, axis=0)])
    a, b = np.array(windows, dtype=np.intp).reshape(-1, 2).T
    size = (b - a).reshape(-1, *(1 for _ in values.shape[1:]))
    return (total[b] - total[a]) / size


class Screening:
    """Errors of ridge regressions on some columns, with each group of windows left out in turn.

    Fitted on windows of one length and judged on windows of another: errors that are noise in one tick average out
    over several, a bias does not. The means of monomials over a window make this exact for polynomials.

    Args:
        x: columns, shape (n, n_columns).
        y: target, shape (n,).
        fit, judge: windows to fit to and to judge by.
        fit_group, judge_group: group of each window, shape (n_windows,).
        degree: 1 or 2.
        preferred: columns that win unless another is clearly better.
    """

    def __init__(
        self,
        x: FloatArray,
        y: FloatArray,
        fit: Sequence[tuple[int, int]],
        fit_group: NDArray[np.intp],
        judge: Sequence[tuple[int, int]],
        judge_group: NDArray[np.intp],
        degree: int,
        preferred: NDArray[np.bool_],
    ) -> None:
        self.usable, z = _standardised(x)
        n = x.shape[1]
        first, second = np.triu_indices(n)
        self.degree = degree
        self.preferred = preferred
        phi = [np.ones((len(x), 1)), z] + ([z[:, first] * z[:, second]] if degree > 1 else [])
        features = np.hstack(phi)
        self._pair = np.zeros((n, n), dtype=np.intp)
        self._pair[first, second] = self._pair[second, first] = 1 + n + np.arange(len(first))
        self.groups = np.unique(judge_group)
        self._fit = self._grams(features, y, fit, fit_group)
        self._judge = self._grams(features, y, judge, judge_group)
        self._total = tuple(part.sum(axis=0) for part in self._fit)

    def _grams(
        self, features: FloatArray, y: FloatArray, windows: Sequence[tuple[int, int]], group: NDArray[np.intp]
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        weight = np.sqrt(np.array([b - a for a, b in windows], dtype=float))
        phi, target = window_means(features, windows) * weight[:, None], window_means(y, windows) * weight
        parts = [(phi[group == g], target[group == g]) for g in self.groups]
        return (
            np.stack([p.T @ p for p, _ in parts]),
            np.stack([p.T @ t for p, t in parts]),
            np.array([t @ t for _, t in parts]),
        )

    def errors(self, columns: Sequence[int]) -> FloatArray:
        """Squared error of each left-out group, shape (n_groups,), for a regression on some columns."""
        chosen = list(columns)
        terms = [0, *(1 + c for c in chosen)]
        if self.degree > 1:
            terms += [int(self._pair[a, b]) for k, a in enumerate(chosen) for b in chosen[k:]]
        index = np.ix_(range(len(self.groups)), terms, terms)
        gram = self._total[0][np.ix_(terms, terms)][None] - self._fit[0][index]
        right = self._total[1][terms][None] - self._fit[1][:, terms]
        ridge = _RIDGE * np.maximum(gram[:, :1, 0], 1.0)[:, :, None] * np.eye(len(terms))
        ridge[:, 0, 0] = 1e-9
        w = np.linalg.solve(gram + ridge, right[..., None])[..., 0]
        judged, cross, square = self._judge
        return square - 2 * np.sum(w * cross[:, terms], axis=1) + np.einsum("ki,kij,kj->k", w, judged[index], w)

    def error(self, columns: Sequence[int]) -> float:
        """Sum of `errors`."""
        return float(self.errors(columns).sum())

    def select(self, most: int = 4) -> list[int]:
        """Forward selection, one column or a pair at a time."""
        chosen: list[int] = []
        best = self.error(chosen)
        while len(chosen) < most:
            free = [c for c in self.usable.tolist() if c not in chosen]
            if not free:
                break
            singles = sorted((self._ranked([*chosen, c]), i, c) for i, c in enumerate(free))
            error = self.error([*chosen, singles[0][2]])
            pairs: list[tuple[float, int, tuple[int, int]]] = []
            if len(chosen) + 2 <= most:
                seeds = [c for _, _, c in singles[: LEARNING.seeds]]
                for k, a in enumerate(seeds):
                    others = [b for b in (free if not chosen else seeds) if b not in seeds[: k + 1]]
                    pairs += [(self._ranked([*chosen, a, b]), len(pairs) + i, (a, b)) for i, b in enumerate(others)]
            if pairs and min(pairs)[0] < LEARNING.pair * min(error, best):
                chosen += list(min(pairs)[2])
            elif error < LEARNING.single * best:
                chosen.append(singles[0][2])
            else:
                break
            best = self.error(chosen)
        return chosen

    def _ranked(self, columns: Sequence[int]) -> float:
        return self.error(columns) * (1.0 if self.preferred[columns[-1]] else LEARNING.preference)


def _standardised(x: FloatArray) -> tuple[NDArray[np.intp], FloatArray]:
    """Columns that vary beyond rounding, and all columns with mean 0 and, of these, standard deviation 1."""
    scale = x.std(axis=0)
    usable = scale > 1e-9 * np.abs(x).max(axis=0)
    return np.flatnonzero(usable), (x - x.mean(axis=0)) / np.where(usable, scale, 1.0)


class CubicScreening:
    """The same for cubic regressions, which see thresholds of two columns together; few columns, single ticks.

    Args:
        x: columns, shape (n, n_columns).
        y: target, shape (n,).
        group: group of each row, shape (n,).
        judge: windows to judge by; each within one group.
    """

    def __init__(self, x: FloatArray, y: FloatArray, group: NDArray[np.intp], judge: Sequence[tuple[int, int]]) -> None:
        self.usable, self._z = _standardised(x)
        self._y, self._group, self._judge = y, group, judge
        self._weight = np.array([b - a for a, b in judge], dtype=float)
        self._groups = [np.flatnonzero(group == g) for g in np.unique(group)]

    def error(self, columns: Sequence[int]) -> float:
        """Squared error over windows, each group left out in turn."""
        z = self._z[:, list(columns)]
        first = np.hstack([np.ones((len(z), 1)), z])
        a, b, c = _cubic_terms(first.shape[1])
        phi = first[:, a] * first[:, b] * first[:, c]
        gram, right = phi.T @ phi, phi.T @ self._y
        parts = [phi[rows] for rows in self._groups]
        grams = np.stack([gram - p.T @ p for p in parts])
        rights = np.stack([right - p.T @ self._y[rows] for p, rows in zip(parts, self._groups, strict=True)])
        ridge = _RIDGE * len(z) * np.eye(phi.shape[1])
        ridge[0, 0] = 1e-9
        w = np.linalg.solve(grams + ridge, rights[..., None])[..., 0]
        prediction = np.empty(len(z))
        for rows, part, k in zip(self._groups, parts, w, strict=True):
            prediction[rows] = part @ k
        return float(np.sum(self._weight * window_means(self._y - prediction, self._judge) ** 2))

    def select(self, most: int = 3) -> list[int]:
        """The best pair of columns, and further ones while they help."""
        pairs = [(int(a), int(b)) for k, a in enumerate(self.usable) for b in self.usable[k + 1 :]]
        if not pairs:
            return []
        errors = [self.error(p) for p in pairs]
        chosen, best = list(pairs[int(np.argmin(errors))]), min(errors)
        while len(chosen) < most:
            more = [int(c) for c in self.usable if c not in chosen]
            errors = [self.error([*chosen, c]) for c in more]
            if not errors or min(errors) > LEARNING.single * best:
                break
            chosen, best = [*chosen, more[int(np.argmin(errors))]], min(errors)
        return chosen


class RectifiedScreening:
    """The same for regressions that are zero up to a threshold and linear beyond it; see `RectifiedLinearRegressor`.

    The rows beyond the threshold are found once from all rows; each left-out group starts from them. That suffices to
    rank columns.

    Args:
        x: columns, shape (n, n_columns).
        y: target, shape (n,).
        group: group of each row, shape (n,).
        judge: windows to judge by; each within one group.
    """

    def __init__(self, x: FloatArray, y: FloatArray, group: NDArray[np.intp], judge: Sequence[tuple[int, int]]) -> None:
        self.usable, self._z = _standardised(x)
        up, down = np.sum(np.maximum(y, 0.0) ** 2), np.sum(np.minimum(y, 0.0) ** 2)
        self._y = y if up >= down else -y
        self._first = self._y > _BEYOND * self._y.max()
        self._judge = judge
        self._weight = np.array([b - a for a, b in judge], dtype=float)
        self._groups = [group == g for g in np.unique(group)]

    def error(self, columns: Sequence[int]) -> float:
        """Squared error over windows, each group left out in turn."""
        phi = np.column_stack([self._z[:, list(columns)], np.ones(len(self._z))])
        rows = self._first
        for _ in range(LEARNING.sweeps):
            beyond = phi @ self._fit(phi, rows) > 0
            if np.array_equal(beyond, rows) or not beyond.any():
                break
            rows = beyond
        prediction = np.zeros(len(phi))
        for out in self._groups:
            kept = rows & ~out
            if not kept.any():
                continue
            w = self._fit(phi, (phi @ self._fit(phi, kept) > 0) & ~out)
            prediction[out] = np.maximum(phi[out] @ w, 0.0)
        return float(np.sum(self._weight * window_means(self._y - prediction, self._judge) ** 2))

    def _fit(self, phi: FloatArray, rows: NDArray[np.bool_]) -> FloatArray:
        part = phi[rows]
        gram = part.T @ part + 1e-6 * (1.0 + len(part)) * np.eye(phi.shape[1])
        return np.asarray(np.linalg.solve(gram, part.T @ self._y[rows]), dtype=float)

    def select(self, most: int = 3) -> list[int]:
        """The best pair that begins with one of the best columns, and further ones while they help."""
        singles = sorted((self.error([c]), c) for c in self.usable.tolist())
        if not singles:
            return []
        pairs = [
            (self.error([c, d]), (c, d))
            for k, (_, c) in enumerate(singles[: LEARNING.seeds])
            for _, d in singles[k + 1 :]
        ]
        if not pairs or min(pairs)[0] > LEARNING.single * singles[0][0]:
            return [singles[0][1]]
        best, first = min(pairs)
        chosen = list(first)
        while len(chosen) < most:
            more = [(self.error([*chosen, int(c)]), int(c)) for c in self.usable if c not in chosen]
            if not more or min(more)[0] > LEARNING.single * best:
                break
            best = min(more)[0]
            chosen.append(min(more)[1])
        return chosen


@cache
def _cubic_terms(n: int) -> tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.intp]]:
    """All products of three of n factors, as three index arrays; the first factor is the constant."""
    terms = np.array(list(combinations_with_replacement(range(n), 3)), dtype=np.intp)
    return terms[:, 0], terms[:, 1], terms[:, 2]
