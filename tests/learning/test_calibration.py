"""Figures of calibration against plain numpy, on made-up predictions that are honest, overconfident, or no numbers."""

import numpy as np
import pytest

from ichain_drake.errors import InputError
from ichain_drake.learning.calibration import conformal_factor, normal_factor, reliability
from ichain_drake.learning.selection import calibration_error


def plain_error(p: np.ndarray, truth: np.ndarray, bins: int) -> float:
    """Expected calibration error, one row after another."""
    total = 0.0
    for k in range(bins):
        inside = [
            i for i, value in enumerate(p) if k / bins <= value < (k + 1) / bins or (value == 1.0 and k == bins - 1)
        ]
        if inside:
            total += abs(np.mean(truth[inside]) - np.mean(p[inside])) * len(inside)
    return total / len(p)


@pytest.mark.parametrize("bins", [1, 4, 16])
def test_figures_are_those_of_plain_numpy(bins: int) -> None:
    rng = np.random.default_rng(bins)
    p = np.concatenate([rng.uniform(size=300), [0.0, 1.0, 0.5, 0.25]])
    truth = rng.uniform(size=304) < p**2
    found = reliability(p, truth, bins)
    assert found.error == pytest.approx(plain_error(p, truth, bins), abs=1e-12)
    assert found.error == calibration_error(p, truth, bins)
    assert found.brier == np.mean([(a - b) ** 2 for a, b in zip(p, truth, strict=True)])
    assert (found.rows.sum(), found.happened.sum()) == (304, truth.sum())
    assert found.predicted.sum() == pytest.approx(p.sum())
    assert len(found.rows) == len(found.predicted) == len(found.happened) == bins
    for k in range(bins - 1):
        inside = (p >= k / bins) & (p < (k + 1) / bins)
        assert (found.rows[k], found.happened[k]) == (inside.sum(), truth[inside].sum())


def test_what_is_honest_scores_none_and_what_is_overconfident_is_caught() -> None:
    rng = np.random.default_rng(0)
    p = rng.uniform(size=50_000)
    truth = rng.uniform(size=50_000) < p
    assert reliability(p, truth).error < 0.01
    assert reliability(np.clip(2 * p - 0.5, 0, 1), truth).error > 0.1


@pytest.mark.parametrize("level", [0.5, 0.9])
def test_overconfident_intervals_are_corrected_and_honest_ones_stay(level: float) -> None:
    rng = np.random.default_rng(1)
    aside, new = rng.normal(size=4000), rng.normal(size=20_000)
    assert conformal_factor(np.abs(aside), level) == pytest.approx(normal_factor(level), rel=0.05)
    for spread in (0.4, 3.0):  # what the model thinks of residuals with a standard deviation of 1
        raw = np.mean(np.abs(new) <= normal_factor(level) * spread)
        assert abs(raw - level) > 0.08
        factor = conformal_factor(np.abs(aside) / spread, level)
        assert np.mean(np.abs(new) <= factor * spread) == pytest.approx(level, abs=0.02)


def test_a_factor_covers_what_it_promises_whatever_the_distribution_is() -> None:
    """Exactly in the mean over draws, also of few scores and heavy tails: ceil((n + 1) level) / (n + 1)."""
    rng = np.random.default_rng(2)
    draws = np.abs(rng.standard_cauchy(size=(20_000, 12)))
    covered = [new <= conformal_factor(aside, 0.9) for *aside, new in draws]
    assert np.mean(covered) == pytest.approx(11 / 12, abs=0.006)


def test_a_factor_is_the_rank_that_is_due() -> None:
    scores = np.random.default_rng(3).permutation(np.arange(1.0, 10.0))  # 9 scores: 10 places for the next one
    assert [conformal_factor(scores, level) for level in (0.1, 0.5, 0.55, 0.9)] == [1.0, 5.0, 6.0, 9.0]
    assert conformal_factor(scores, 0.91) == np.inf
    assert conformal_factor([], 0.5) == np.inf


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (
            lambda: reliability([0.5], [True, False]),
            r"reliability: shape \(n,\) with n >= 1 needed of both, \(1,\) and",
        ),
        (lambda: reliability([], []), "n >= 1 needed"),
        (lambda: reliability([[0.5]], [[True]]), "n >= 1 needed"),
        (lambda: reliability([0.5, 1.2], [True, True]), "reliability: 1.2 is no probability; give numbers in"),
        (lambda: reliability([np.nan], [True]), "reliability: nan is no probability"),
        (lambda: reliability([0.5], [True], 0), "reliability: 0 bins given"),
        (lambda: normal_factor(1.0), "level 1.0: a predictive interval covers a share between 0 and 1"),
        (lambda: conformal_factor([1.0], 0.0), "level 0.0: a predictive interval covers"),
        (lambda: conformal_factor([1.0, -0.1], 0.5), "scores of shape"),
        (lambda: conformal_factor([np.nan], 0.5), "from 0 needed"),
    ],
)
def test_what_is_no_prediction_is_refused_in_one_line(call, words: str) -> None:
    with pytest.raises(InputError, match=words) as refused:
        call()
    assert "\n" not in str(refused.value)
