"""One regression of a change: which columns, which estimator and whether there is anything to predict at all."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from ichain_drake.errors import InputError
from ichain_drake.learning.blocks import piece_blocks, windows
from ichain_drake.learning.chain.link import EstimatorSpec
from ichain_drake.learning.effects.fitted import Regression, one_way
from ichain_drake.learning.effects.screening import CubicScreening, RectifiedScreening, Screening, window_means
from ichain_drake.learning.frozen import FrozenModel, freeze
from ichain_drake.learning.frozen.polynomial import Polynomial
from ichain_drake.learning.selection import borne_out, by_part, clearly
from ichain_drake.learning.settings import LEARNING
from ichain_drake.state import FloatArray

_IDENTITY = "as declared"  # a column that is the change itself


def _fitted(spec: EstimatorSpec, x: FloatArray, y: FloatArray) -> FrozenModel | None:
    """The frozen fit, or None where there are too few rows for this estimator."""
    if len(x) > LEARNING.most_rows:
        rows = np.linspace(0, len(x) - 1, LEARNING.most_rows).round().astype(int)
        x, y = x[rows], y[rows]
    try:
        return freeze(spec.make().fit(x, y))
    except (InputError, ValueError, TypeError, AttributeError, np.linalg.LinAlgError):
        return None


_AS_IT_IS = Polynomial.from_terms(np.ones((1, 1), dtype=np.int64), np.ones((1, 1)), np.zeros(1))
Fit = EstimatorSpec | str | None  # None: a constant


def _whole(spec: Fit, x: FloatArray, y: FloatArray) -> FrozenModel | None:
    if spec is None or isinstance(spec, str):
        return None if spec is None else _AS_IT_IS
    return _fitted(spec, x, y)


def _is_linear(model: FrozenModel | None) -> bool:
    return model is None or (isinstance(model, Polynomial) and model.monomials.degree <= 1)


@dataclass
class _Sample:
    """Rows with their groups and windows."""

    x: FloatArray
    y: FloatArray
    group: NDArray[np.intp]
    windows: dict[int, list[tuple[int, int]]]
    judge: list[tuple[int, int]]

    def group_of(self, marks: Sequence[tuple[int, int]]) -> NDArray[np.intp]:
        return self.group[[a for a, _ in marks]]

    def judged(self, prediction: FloatArray) -> FloatArray:
        """Mean residual of each window, shape (n_windows,)."""
        return window_means(self.y - prediction, self.judge)


def choose_regression(
    x: FloatArray,
    y: FloatArray,
    piece: NDArray[np.intp],
    row: NDArray[np.intp],
    estimators: Sequence[EstimatorSpec],
    window: int,
    preferred: NDArray[np.bool_],
    noise: float = 0.0,
    declared: Mapping[int, FloatArray] = MappingProxyType({}),
) -> Regression | None:
    """Choose columns and estimator by the error on left-out pieces or blocks; None where nothing can be predicted.

    Args:
        x: candidate columns, shape (n, n_columns).
        y: the change beyond what is known, shape (n,).
        piece: piece that each row comes from, shape (n,).
        row: row of its piece, shape (n,).
        estimators: candidates, simpler ones first.
        window: errors are judged over so many ticks; 1 where the variable has no memory.
        preferred: columns that win ties, shape (n_columns,).
        noise: standard deviation of a reading of the variable: a change that is not larger is none.
        declared: columns that are the change itself by the roles of both variables: taken as they are where they
            explain it, since their own noise would bias any fit to them. With the variance of each row's value, shape
            (n,): where readings leave it open, a row tells neither for nor against it.
    """
    if len(y) < LEARNING.rows:
        return None
    group = piece_blocks(piece, row)
    key = piece * (group.max() + 1) + group
    lengths = (1,) if window == 1 else (1, window)
    marks = {n: windows(key, row, n) for n in lengths}
    sample = _Sample(x, y, group, marks, marks[lengths[-1]])
    if len(np.unique(group)) < 2:
        return None
    length = np.array([b - a for a, b in sample.judge], dtype=float)
    nothing = np.zeros(len(y))

    def error(prediction: FloatArray) -> float:
        return float(np.sum(length * sample.judged(prediction) ** 2))

    zero = error(nothing)
    # What readings alone would give: the mean change over a window is the difference of two of them over its length;
    # what has no memory is not judged by differences.
    by_noise = 2.0 * noise**2 / length**2 if window > 1 else np.full(len(length), noise**2)
    if window > 1 and zero < LEARNING.noisy * float(np.sum(length * by_noise)):
        return None
    best: Regression | None = None
    best_prediction = nothing
    for column, variance in declared.items():
        # Roles are priors: what they declare needs to be likelier than chance, not clear in every part.
        by_both = by_noise + window_means(variance, sample.judge) / length
        if _window_gains(sample, best_prediction, x[:, column], by_both).sum() > np.log(1.0 + x.shape[1]):
            best_prediction = x[:, column]
            best = _describe(_IDENTITY, sample, (column,), 1, piece)
    taken = best is not None
    for columns, fit_length, specs in () if taken else _candidates(sample, estimators, preferred):
        # Any of the columns might have been picked, and any of the estimators.
        more = len(columns) - (len(best.columns) if best is not None else 0)
        tried = (1 + len(estimators)) * x.shape[1] ** max(more, 0)
        for spec in specs:
            prediction = _left_out(spec, sample, columns, fit_length)
            if prediction is None:
                continue
            gains = _window_gains(sample, best_prediction, prediction, by_noise)
            if not _is_clear(spec, sample, gains, more, tried):
                continue
            # A column more is one more that a planner must know: what hardly explains more isn't worth it.
            if best is None or error(prediction) < LEARNING.simpler * error(best_prediction):
                best_prediction = prediction
                best = _describe(spec, sample, columns, fit_length, piece)
    if best is None:
        return None
    sign = 0 if taken or _is_linear(best.frozen) else _only_way(sample, best_prediction, by_noise)
    best_prediction = one_way(best_prediction, sign)
    dead = _dead_band(sample, best_prediction) if best.frozen is not None and window > 1 and not taken else 0.0
    residual = y - np.where(np.abs(best_prediction) < dead, 0.0, best_prediction)
    return replace(
        best,
        dead_band=dead,
        sign=sign,
        std=float(np.sqrt(np.mean(residual**2))),
        drift=float(np.sqrt(np.average(window_means(residual, sample.judge) ** 2, weights=length))),
        explained=1.0 - error(best_prediction) / max(zero, 1e-300),
        scale=float(np.sqrt(zero / length.sum())),
    )


def instrumented(now: FloatArray, earlier: FloatArray) -> FloatArray:
    """Each column as its own earlier reading predicts it: two-stage least squares, free of the reading's own noise.

    Args:
        now: columns, shape (n, n_columns).
        earlier: the same, read one row before.
    """
    middle_now, middle = now.mean(axis=0), earlier.mean(axis=0)
    spread = np.sum((earlier - middle) ** 2, axis=0)
    slope = np.sum((now - middle_now) * (earlier - middle), axis=0) / np.where(spread > 0, spread, 1.0)
    return middle_now + slope * (earlier - middle)


def _window_gains(sample: _Sample, before: FloatArray, after: FloatArray, by_noise: FloatArray) -> FloatArray:
    """What a left-out prediction adds to the log-likelihood of each window over another, shape (n_windows,) [nat].

    The mean residual of a window of n ticks is normal: readings give it the variance `by_noise`, and what neither
    prediction explains a share of 1 / n.
    """
    length = np.array([b - a for a, b in sample.judge], dtype=float)
    squares = [sample.judged(prediction) ** 2 for prediction in (before, after)]
    left = min(float(np.mean(length * (q - by_noise))) for q in squares)
    variance = by_noise + max(left, 1e-12 * float(np.mean(length * squares[0])), 1e-300) / length
    return 0.5 * (squares[0] - squares[1]) / variance


def _candidates(
    sample: _Sample, estimators: Sequence[EstimatorSpec], preferred: NDArray[np.bool_]
) -> list[tuple[tuple[int, ...], int, Sequence[EstimatorSpec | None]]]:
    """Columns, window length to fit at, and how to fit; the simplest first."""
    out: list[tuple[tuple[int, ...], int, Sequence[EstimatorSpec | None]]] = [((), 1, (None,))]
    rectified = [e for e in estimators if e.name == "rectified_linear"]
    smooth = [e for e in estimators if e.name != "rectified_linear"]
    sets = _column_sets(sample, preferred)
    if rectified:
        out += [(columns, 1, rectified) for columns in _rectified_columns(sample)]
    # Means over windows stand for their rows only where the fit is linear.
    return out + [(columns, n, smooth[: 1 if n > 1 else None]) for columns, n in sets]


def _rectified_columns(sample: _Sample) -> list[tuple[int, ...]]:
    """Columns of a threshold beyond which there is a change, if there are rows that clearly are beyond one."""
    size = np.abs(sample.y)
    if np.sum(size > LEARNING.outstanding * np.median(size)) < LEARNING.several:
        return []
    chosen = RectifiedScreening(sample.x, sample.y, sample.group, sample.judge).select()
    return [tuple(chosen[:n]) for n in range(1, len(chosen) + 1)]


def _column_sets(sample: _Sample, preferred: NDArray[np.bool_]) -> list[tuple[tuple[int, ...], int]]:
    """Sets of columns worth fitting, with the window length to fit at."""
    judge_group = sample.group_of(sample.judge)
    sets: list[tuple[tuple[int, ...], int]] = []
    for degree in (1, 2):
        for length, marks in sorted(sample.windows.items(), reverse=True):  # noise in inputs biases single ticks
            fit_group = sample.group_of(marks)
            screen = Screening(sample.x, sample.y, marks, fit_group, sample.judge, judge_group, degree, preferred)
            sets.append((tuple(screen.select()), length))
    cubic_screen = CubicScreening(sample.x, sample.y, sample.group, sample.judge)
    cubic = tuple(cubic_screen.select())
    sets += [(cubic[:2], 1), (cubic, 1)]
    # Columns built from roles say by themselves what they are there for; what comes on top must pay for it.
    alone = [(tuple(c for c in columns if preferred[c]), n) for columns, n in sets]
    return list(dict.fromkeys([*((c, n) for c, n in alone if c), *((c, n) for c, n in sets if c)]))


def _left_out(
    spec: EstimatorSpec | None, sample: _Sample, columns: tuple[int, ...], fit_length: int
) -> FloatArray | None:
    """Prediction of every row by a fit that has not seen its group, shape (n,)."""
    if spec is None:
        return _left_out_mean(sample)
    marks = sample.windows[fit_length]
    x, y = window_means(sample.x[:, list(columns)], marks), window_means(sample.y, marks)
    group = sample.group_of(marks)
    out = np.empty(len(sample.y))
    for g in np.unique(sample.group):
        train, test = group != g, sample.group == g
        model = _fitted(spec, x[train], y[train])
        if model is None:
            return None
        out[test] = model.batch(sample.x[test][:, list(columns)])[:, 0]
    return out


def _is_clear(spec: EstimatorSpec | None, sample: _Sample, gains: FloatArray, more: int, tried: int) -> bool:
    """Whether gains of windows, shape (n_windows,), speak for an estimator, with so many more columns than before."""
    if spec is None:
        return clearly(gains, tried)  # a mean has no column, of which a group's values could be taken for the group
    groups = by_part(gains, sample.group_of(sample.judge))
    # The rows beyond a threshold, which tell it, may well be of one group.
    return (borne_out if more > 0 and spec.name != "rectified_linear" else clearly)(groups, tried)


def _left_out_mean(sample: _Sample) -> FloatArray:
    """The mean change of all rows but those of the same window, for every row, shape (n,).

    No more need be left out of what no column tells apart.
    """
    out, total, count = np.zeros(len(sample.y)), float(sample.y.sum()), len(sample.y)
    for a, b in sample.judge:
        if b - a < count:
            out[a:b] = (total - float(sample.y[a:b].sum())) / (count - (b - a))
    return out


def _describe(
    spec: Fit,
    sample: _Sample,
    columns: tuple[int, ...],
    fit_length: int,
    piece: NDArray[np.intp],
) -> Regression | None:
    marks = sample.windows[fit_length]
    x, y = window_means(sample.x[:, list(columns)], marks), window_means(sample.y, marks)
    frozen = _whole(spec, x, y)
    if spec is not None and frozen is None:
        return None
    weights = np.array([b - a for a, b in marks], dtype=float)
    return Regression(
        columns=columns,
        frozen=frozen,
        constant=float(np.average(y, weights=weights)),
        low=None if _is_linear(frozen) else sample.x[:, list(columns)].min(axis=0),
        high=None if _is_linear(frozen) else sample.x[:, list(columns)].max(axis=0),
        dead_band=0.0,
        sign=0,
        estimator="constant" if spec is None else str(spec),
        std=0.0,
        drift=0.0,
        explained=0.0,
        samples=len(sample.y),
        pieces=len(np.unique(piece)),
        scale=0.0,
    )


def _only_way(sample: _Sample, prediction: FloatArray, by_noise: FloatArray) -> int:
    """The way that a change only ever goes, 1 or -1, where that is as likely; else 0.

    A fit that is not linear bends to either side of no change, also where nothing was shown: a vessel that only ever
    lost something would fill itself.
    """
    gains = {s: float(_window_gains(sample, prediction, one_way(prediction, s), by_noise).sum()) for s in (1, -1)}
    way = max(gains, key=gains.__getitem__)
    return way if gains[way] >= -LEARNING.surprise * len(prediction) else 0


def _dead_band(sample: _Sample, prediction: FloatArray) -> float:
    length = np.array([b - a for a, b in sample.judge], dtype=float)
    size = float(np.sqrt(np.mean(prediction**2)))
    errors = []
    for share in LEARNING.dead_bands:
        cut = np.where(np.abs(prediction) < share * size, 0.0, prediction)
        errors.append(float(np.sum(length * sample.judged(cut) ** 2)))
    return LEARNING.dead_bands[int(np.argmin(errors))] * size
