"""Which columns and which estimator describe a change, and when there is none."""

from dataclasses import replace

import numpy as np
import pytest

from ichain_drake.learning import InteractionSpec
from ichain_drake.learning.chain.link import EstimatorSpec
from ichain_drake.learning.effects.fitted import Regression
from ichain_drake.learning.effects.regression import choose_regression

ROWS, PIECES, NOISE = 40, 6, 0.004
PIECE = np.repeat(np.arange(PIECES), ROWS)
ROW = np.tile(np.arange(ROWS), PIECES)
ESTIMATORS = InteractionSpec().effect_estimators


def columns(seed: int = 0, n: int = 6) -> tuple[np.ndarray, np.random.Generator]:
    rng = np.random.default_rng(seed)
    return rng.uniform(-1.0, 1.0, (len(ROW), n)), rng


def readings_noise(rng: np.random.Generator) -> np.ndarray:
    """Noise of a change: the difference of two readings' noise."""
    noise = NOISE * rng.normal(size=len(ROW) + 1)
    return noise[1:] - noise[:-1]


def chosen(x: np.ndarray, y: np.ndarray, *declared: int) -> Regression | None:
    preferred = np.isin(np.arange(x.shape[1]), declared)
    sure = dict.fromkeys(declared, np.zeros(len(y)))
    return choose_regression(x, y, PIECE, ROW, ESTIMATORS, 12, preferred, NOISE, sure)


@pytest.mark.parametrize("seed", range(8))
def test_noise_is_no_effect(seed: int) -> None:
    x, rng = columns(seed)
    assert chosen(x, readings_noise(rng)) is None


@pytest.mark.parametrize("seed", range(4))
def test_what_overflows_is_found_with_its_threshold(seed: int) -> None:
    x, rng = columns(seed)
    y = -0.3 * np.maximum(0.0, x[:, 1] + 0.8 * x[:, 4] - 0.7)
    found = chosen(x, y + readings_noise(rng))
    assert found is not None
    assert set(found.columns) == {1, 4}
    assert found.estimator == "rectified_linear()"
    np.testing.assert_allclose(found(x[:, list(found.columns)]), y, atol=0.01)
    shown = x[:, list(found.columns)].max(axis=0)
    np.testing.assert_array_equal(found(shown[None] + 2.0), found(shown[None]))  # a bend ends there


def test_a_linear_change_stays_linear() -> None:
    x, rng = columns(1)
    found = chosen(x, 0.1 * x[:, 2] + readings_noise(rng))
    assert found is not None
    assert found.columns == (2,)
    assert found.estimator.startswith("polynomial(degree=1")
    np.testing.assert_allclose(found(np.array([[5.0]])), 0.5, atol=0.02)  # a line goes on where nothing was shown


def test_what_roles_declare_is_taken_as_it_is_though_its_noise_would_bias_a_fit() -> None:
    x, rng = columns(2)
    true = 0.05 * np.maximum(0.0, x[:, 0])
    x[:, 3] = true + 0.02 * rng.normal(size=len(x))
    found = chosen(x, true + readings_noise(rng), 3)
    assert found is not None
    assert found.columns == (3,)
    assert found.estimator == "as declared"
    np.testing.assert_array_equal(found(x[:, [3]]), x[:, 3])


def test_what_roles_declare_is_not_taken_where_it_explains_nothing() -> None:
    x, rng = columns(3)
    found = chosen(x, 0.1 * x[:, 2] + readings_noise(rng), 3)
    assert found is not None
    assert found.columns == (2,)


def test_rows_in_which_readings_leave_a_declared_change_open_tell_nothing_against_it() -> None:
    x, rng = columns(4)
    open_, true = ROW == ROWS - 1, 0.02 * x[:, 0]
    x[:, 3] = true + np.where(open_, 3.0 * rng.normal(size=len(x)), 0.0)
    y, preferred = true + readings_noise(rng), np.arange(x.shape[1]) == 3
    for variance, expected in ((np.where(open_, 9.0, 0.0), True), (np.zeros(len(x)), False)):
        found = choose_regression(x, y, PIECE, ROW, ESTIMATORS, 12, preferred, NOISE, {3: variance})
        assert found is not None
        assert (found.estimator == "as declared") is expected


def test_what_only_ever_flows_out_flows_out_where_nothing_was_shown() -> None:
    x, rng = columns(5, 2)
    shown = x[:, 1] > 0.2 * x[:, 0]  # what is emptied stays emptied
    x[~shown, 1] = 1.0
    y = -0.1 * np.maximum(x[:, 1] - 0.5 * x[:, 0], 0.0) ** 2 * (1.0 + x[:, 0])
    kernel = (EstimatorSpec.parse("kernel_ridge(alpha=0.03, gamma=0.3)"),)
    found = choose_regression(x, y + readings_noise(rng), PIECE, ROW, kernel, 12, np.zeros(2, dtype=bool), NOISE)
    assert found is not None
    assert found.sign == -1
    never = rng.uniform(-1.0, 1.0, (400, 2))
    assert found.frozen is not None
    assert found.frozen.batch(never[:, list(found.columns)]).max() > 0.0
    assert found(never[:, list(found.columns)]).max() == 0.0
    both = choose_regression(x, 0.3 * x[:, 0] * x[:, 1], PIECE, ROW, kernel, 12, np.zeros(2, dtype=bool), NOISE)
    assert both is not None
    assert both.sign == 0


def test_a_change_within_the_dead_band_is_none_and_one_beyond_it_is_whole() -> None:
    x, rng = columns(1)
    found = chosen(x, 0.1 * x[:, 2] + readings_noise(rng))
    assert found is not None
    rows = np.array([[0.1], [-0.1], [0.9], [-0.9]])
    plain = replace(found, dead_band=0.0)(rows)
    np.testing.assert_allclose(plain, [0.01, -0.01, 0.09, -0.09], atol=0.002)
    np.testing.assert_array_equal(replace(found, dead_band=0.05)(rows), [0.0, 0.0, plain[2], plain[3]])


def test_what_is_left_is_told_in_the_unit_of_the_change_and_as_a_share_of_it() -> None:
    x, rng = columns(1)
    found = chosen(x, 0.5 * x[:, 2] + readings_noise(rng))
    assert found is not None
    assert found.std == pytest.approx(np.sqrt(2.0) * NOISE, rel=0.15)
    assert 0.99 < found.explained < 1.0
