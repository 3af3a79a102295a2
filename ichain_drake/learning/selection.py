"""The one criterion by which learning chooses: log-likelihood of what was left out, and one standard error of it.

Two models are compared by their log-likelihoods on parts of the demonstrations (pieces, or blocks of rows) that neither
has seen. A part that tells nothing about the difference adds a gain of exactly zero, to the sum and to its error alike,
so that demonstrations of other things can neither make a model better nor worse.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import ndtr

from ichain_drake.state import FloatArray


def clearly(gains: ArrayLike, tried: int = 1) -> bool:
    """Whether gains of parts, shape (n_parts,), sum up to more than one standard error of their sum.

    The error is that of a sum whose terms have either sign by chance, the root of the sum of squares. So one part alone
    is never clear, and two that agree are.

    Args:
        gains: log-likelihoods of one model less those of another [nat].
        tried: how many models the one was picked from: as likely as all others together it must be, by log(tried).
    """
    values = np.asarray(gains, dtype=float)
    return bool(values.sum() > max(np.sqrt(np.sum(values**2)) * (1.0 + 1e-9), np.log(max(tried, 1))))


def borne_out(gains: ArrayLike, tried: int = 1) -> bool:
    """Whether gains are clear, and likelier than chance without the part that speaks for them most, too.

    Asked of what a model looks at: what one part shows may be an accident of that part, however likely, and another
    that hardly agrees is no second witness. Arguments as for `clearly`.
    """
    values = np.asarray(gains, dtype=float)
    return clearly(values, tried) and bool(values.sum() - values.max() > np.log(max(tried, 1)))


def by_part(values: FloatArray, part: NDArray[np.intp]) -> FloatArray:
    """Sums over the rows of each part, shape (n_parts,), of values of shape (n,)."""
    return np.asarray(np.bincount(part, weights=values, minlength=int(part.max(initial=-1)) + 1), dtype=float)


def log_probability(truth: NDArray[np.bool_], inside: FloatArray, slip: float | FloatArray) -> FloatArray:
    """Log-likelihood of flags, shape (n,); of several slips, shape (n_slips, n).

    Args:
        truth: flags, shape (n,).
        inside: probability that the state is one in which the flag is set, shape (n,).
        slip: probability that a flag is wrong; several of shape (n_slips, 1).
    """
    on = slip + (1.0 - 2.0 * slip) * inside
    return np.asarray(np.log(np.where(truth, on, 1.0 - on)))


def least_slip(truth: NDArray[np.bool_]) -> float:
    """Probability that a flag is wrong at least: one beside a switch may be of either side of it.

    Args:
        truth: flags of successive rows, shape (n,).
    """
    return (1.0 + float(np.sum(truth[1:] != truth[:-1]))) / (2.0 + len(truth))


def calibrated(decisions: FloatArray, truth: NDArray[np.bool_], least: float) -> tuple[float, float, FloatArray]:
    """The likeliest reading of decision values as probabilities, `slip + (1 - 2 slip) Phi(decision / spread)`.

    Args:
        decisions: of rows that the model has not seen, shape (n,).
        truth: their flags, shape (n,).
        least: slip at least.

    Returns:
        spread, slip, and the log-likelihood of each row, shape (n,).
    """
    unit = float(np.median(np.abs(decisions))) or 1.0
    slips = np.geomspace(min(least, 0.4), 0.49, 9)
    best: tuple[float, float, FloatArray] | None = None
    highest = -np.inf
    for spread in unit * np.geomspace(1e-3, 10.0, 33):
        rows = log_probability(truth, ndtr(decisions / spread), slips[:, None])
        sums = rows.sum(axis=1)
        k = int(np.argmax(sums))
        if best is None or sums[k] > highest:
            best, highest = (float(spread), float(slips[k]), rows[k]), sums[k]
    assert best is not None
    return best


def calibration_error(probability: FloatArray, truth: NDArray[np.bool_], bins: int = 10) -> float:
    """Expected calibration error (Naeini et al. 2015): mean of |share of true - mean probability| over bins, weighted.

    Args:
        probability: of rows that were left out, shape (n,).
        truth: their flags, shape (n,).
        bins: of equal width.
    """
    index = np.minimum((probability * bins).astype(np.intp), bins - 1)
    return float(np.abs(np.bincount(index, weights=truth - probability, minlength=bins)).sum() / max(len(truth), 1))
