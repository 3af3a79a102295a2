"""How honest probabilities and predictive intervals are: figures of what was predicted against what was seen.

A probability is calibrated if, of all rows that are given it, that share is active; a predictive interval if it covers
as many readings as it says. Both are asked on pieces that nothing was learned from.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import ndtri

from ichain_drake.errors import InputError
from ichain_drake.learning.selection import calibration_error
from ichain_drake.state import FloatArray


@dataclass(frozen=True)
class Reliability:
    """Probabilities against what happened, in bins of equal width (a reliability diagram; DeGroot and Fienberg 1983).

    Attributes:
        rows: in each bin, shape (n_bins,).
        predicted: sum of the probabilities in each bin, shape (n_bins,).
        happened: rows of each bin that were active, shape (n_bins,).
        error: expected calibration error, in [0, 1].
        brier: mean squared difference (Brier 1950), in [0, 1].
    """

    rows: NDArray[np.intp]
    predicted: FloatArray
    happened: NDArray[np.intp]
    error: float
    brier: float


def reliability(probability: ArrayLike, truth: ArrayLike, bins: int = 10) -> Reliability:
    """How well probabilities are calibrated.

    Args:
        probability: of each row, shape (n,), in [0, 1].
        truth: whether it happened, shape (n,).
        bins: of equal width, 1 or more; ten are usual for the error (Naeini et al. 2015, Guo et al. 2017).

    Raises:
        InputError: on arrays of other shapes or without a row, or numbers that are no probabilities.
    """
    p, happened = np.asarray(probability, dtype=float), np.asarray(truth, dtype=bool)
    if p.ndim != 1 or p.shape != happened.shape or not len(p):
        raise InputError(f"reliability: shape (n,) with n >= 1 needed of both, {p.shape} and {happened.shape} given")
    if not ((p >= 0.0) & (p <= 1.0)).all():
        raise InputError(f"reliability: {p[~((p >= 0.0) & (p <= 1.0))][0]} is no probability; give numbers in [0, 1]")
    if bins < 1:
        raise InputError(f"reliability: {bins} bins given; give at least 1")
    index = np.minimum((p * bins).astype(np.intp), bins - 1)
    return Reliability(
        np.bincount(index, minlength=bins),
        np.asarray(np.bincount(index, weights=p, minlength=bins), dtype=float),
        np.bincount(index[happened], minlength=bins),
        calibration_error(p, happened, bins),
        float(np.mean((p - happened) ** 2)),
    )


def normal_factor(level: float) -> float:
    """Standard deviations to either side that hold a share of a normal distribution.

    Raises:
        InputError: on a level outside (0, 1).
    """
    return float(ndtri(0.5 + 0.5 * checked_level(level)))


def conformal_factor(scores: ArrayLike, level: float) -> float:
    """What residuals that were not learned from say for it: split conformal prediction (Lei et al. 2018).

    Of n scores the ceil((n + 1) level)-th smallest. If the next row is like them, it is within so many spreads with
    at least this probability, whatever the distribution is and however wrong the spread.

    Args:
        scores: size of each residual over its predicted spread, shape (n,), none negative.
        level: share to cover, in (0, 1).

    Returns:
        The factor; infinite where so few scores can't promise that level.

    Raises:
        InputError: on a level outside (0, 1), or scores that are negative or NaN.
    """
    level, found = checked_level(level), np.asarray(scores, dtype=float)
    if found.ndim != 1 or not (found >= 0.0).all():
        raise InputError(f"conformal_factor: scores of shape (n,) and from 0 needed, shape {found.shape} given")
    rank = math.ceil((len(found) + 1) * level - 1e-9)  # what is a whole number stays one
    return float(np.partition(found, rank - 1)[rank - 1]) if rank <= len(found) else math.inf


def checked_level(level: float) -> float:
    """A share to cover.

    Raises:
        InputError: if it is not in (0, 1).
    """
    if not 0.0 < level < 1.0:
        raise InputError(f"level {level}: a predictive interval covers a share between 0 and 1, such as 0.9")
    return level
