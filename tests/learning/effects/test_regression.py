"""Which columns and which estimator describe a change, and when there is none."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ichain_drake.learning import InteractionSpec
from ichain_drake.learning.blocks import windows
from ichain_drake.learning.chain.link import EstimatorSpec
from ichain_drake.learning.effects import regression
from ichain_drake.learning.effects.fitted import Regression
from ichain_drake.learning.effects.regression import (
    _column_sets,
    _dead_band,
    _fitted,
    _left_out_mean,
    _only_way,
    _rectified_columns,
    _Sample,
    _window_gains,
    choose_regression,
    instrumented,
)
from ichain_drake.learning.settings import LEARNING

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


def test_each_column_is_what_its_own_earlier_reading_says() -> None:
    """Two regressions of one column each, beside least squares; what never varied stays in the middle."""
    rng = np.random.default_rng(0)
    earlier = rng.normal(size=(50, 3)) * [1.0, 5.0, 0.0] + [0.0, 3.0, 2.0]
    now = 0.7 * earlier + rng.normal(size=(50, 3)) + 1.0
    out = instrumented(now, earlier)
    for k in range(2):
        design = np.column_stack([np.ones(50), earlier[:, k]])
        np.testing.assert_allclose(out[:, k], design @ np.linalg.lstsq(design, now[:, k], rcond=None)[0])
    np.testing.assert_allclose(out[:, 2], now[:, 2].mean())


def sample(y: np.ndarray, x: np.ndarray | None = None, window: int = 4) -> _Sample:
    """Of three groups in a row, judged by windows of so many rows."""
    group = np.repeat(np.arange(3), len(y) // 3)
    judge = windows(group, np.tile(np.arange(len(y) // 3), 3), window)
    marks = {1: [(k, k + 1) for k in range(len(y))], window: judge}
    return _Sample(np.zeros((len(y), 1)) if x is None else x, y, group, marks, judge)


def test_what_a_prediction_adds_is_the_likelihood_of_mean_residuals_window_by_window() -> None:
    rng = np.random.default_rng(1)
    y, before, after = rng.normal(size=(3, 36))
    made = sample(y, window=5)
    by_noise = 0.1 + 0.05 * np.arange(len(made.judge))
    n = np.array([b - a for a, b in made.judge], dtype=float)
    assert len(set(n)) > 1 or n[0] != 5, "windows fill their group"
    means = [np.array([(y - p)[a:b].mean() for a, b in made.judge]) for p in (before, after)]
    left = min(np.mean(n * (m**2 - by_noise)) for m in means)
    assert left > 0
    each = 0.5 * (means[0] ** 2 - means[1] ** 2) / (by_noise + left / n)
    np.testing.assert_allclose(_window_gains(made, before, after, by_noise), each)
    loud = np.full(len(n), 50.0)  # more than all that is left
    np.testing.assert_allclose(
        _window_gains(made, before, after, loud).sum(), (0.5 * (means[0] ** 2 - means[1] ** 2) / 50.0).sum(), rtol=1e-6
    )


def test_of_a_mean_a_window_is_left_out_at_a_time() -> None:
    rng = np.random.default_rng(5)
    y = rng.normal(size=36)
    made = sample(y, window=5)
    out = _left_out_mean(made)
    for a, b in made.judge:
        np.testing.assert_allclose(out[a:b], np.delete(y, np.arange(a, b)).mean())
    one = _Sample(np.zeros((4, 1)), y[:4], np.zeros(4, dtype=int), {1: []}, [(0, 4)])
    np.testing.assert_array_equal(_left_out_mean(one), 0.0)


@pytest.mark.parametrize("seed", [0, 11, 30, 76, 94])
def test_a_slow_constant_change_is_no_function_of_what_differs_between_three_pieces(seed: int) -> None:
    """It is as large as a reading's noise; one piece is long, one of two ticks at a time, each at its own level."""
    rng = np.random.default_rng(seed)
    stretches = [(0, 7), *[(1, 2)] * 6, (2, 38)]
    piece = np.concatenate([np.full(n, k) for k, n in stretches])
    row = np.concatenate([np.arange(7), *(5 * k + np.arange(2) for k in range(6)), np.arange(38)])
    y = np.concatenate([0.005 + np.diff(NOISE * rng.normal(size=n + 1)) for _, n in stretches])
    starts = rng.uniform(size=2).tolist() + [float(rng.uniform(0.0, 0.5))]
    level = np.concatenate([start + 0.005 * np.arange(n) for start, n in zip(starts, (7, 12, 38), strict=True)])
    ofs = [rng.uniform(size=3)[piece], rng.uniform(size=3)[piece] + 0.01 * rng.normal(size=57)]
    x = np.column_stack([level + NOISE * rng.normal(size=57), *ofs])
    found = choose_regression(x, y, piece, row, ESTIMATORS, 12, np.zeros(3, dtype=bool), NOISE)
    assert found is not None
    assert found.columns == ()


@pytest.mark.parametrize(("up", "down", "way"), [(1.0, 0.0, 1), (0.0, 1.0, -1), (1.0, 1.0, 0)])
def test_a_change_that_only_went_one_way_is_told(up: float, down: float, way: int) -> None:
    rng = np.random.default_rng(2)
    truth = np.where(np.arange(60) % 2 == 0, up, -down) * rng.uniform(0.5, 1.0, 60)
    made = sample(truth + 0.01 * rng.normal(size=60), window=1)
    bent = truth + 0.03 * rng.normal(size=60)  # a fit that bends a little to the other side
    assert _only_way(made, bent, np.full(60, 1e-4)) == way


@pytest.mark.parametrize("small", [0.02, 0.12, 0.3, 0.6])
def test_a_dead_band_is_the_one_that_leaves_least(small: float) -> None:
    """Predictions of 1 are right; those of `small` are a bias where nothing happens."""
    prediction = np.where(np.arange(60) % 3 == 0, 1.0, small)
    truth = np.where(prediction == 1.0, 1.0, 0.0)
    size = np.sqrt(np.mean(prediction**2))
    band = _dead_band(sample(truth, window=1), prediction)
    enough = [s * size for s in LEARNING.dead_bands if s * size > small]
    assert band == pytest.approx(enough[0] if enough else 0.0)
    assert _dead_band(sample(prediction, window=1), prediction) == 0.0


def test_too_few_rows_or_a_single_group_tell_nothing() -> None:
    x, rng = columns(1)
    y = 0.1 * x[:, 2] + readings_noise(rng)
    few = np.arange(LEARNING.rows - 1)
    args: tuple[Any, ...] = (ESTIMATORS, 12, np.zeros(x.shape[1], dtype=bool), NOISE)
    assert choose_regression(x[few], y[few], PIECE[few], ROW[few], *args) is None
    one = np.arange(LEARNING.short + 1)
    assert choose_regression(x[one], y[one], PIECE[one], ROW[one], *args) is None
    assert choose_regression(x, y, PIECE, ROW, *args) is not None


@pytest.mark.parametrize(("noises", "found"), [(1.0, False), (9.0, True)])
def test_a_change_that_noise_alone_may_give_is_none(noises: float, found: bool) -> None:
    """Over 12 ticks readings alone give a mean change of a root of 2 of their noise, over 12."""
    per_tick = noises * np.sqrt(2.0) * NOISE / 12.0
    x, rng = columns(6)
    chosen_ = chosen(x, np.full(len(x), per_tick) + readings_noise(rng))
    assert (chosen_ is not None) is found
    if chosen_ is not None:
        assert (chosen_.estimator, chosen_.columns) == ("constant", ())
        assert chosen_.constant == pytest.approx(per_tick, rel=0.1)
        assert chosen_.scale == pytest.approx(per_tick, rel=0.1)
        assert chosen_.drift == pytest.approx(np.sqrt(2.0) * NOISE / 12.0, rel=0.4)
        assert (chosen_.samples, chosen_.pieces) == (len(x), PIECES)


def test_columns_of_a_threshold_are_looked_for_where_few_rows_stand_out() -> None:
    rng = np.random.default_rng(3)
    x = rng.uniform(-1.0, 1.0, (90, 2))
    quiet = 0.01 * rng.normal(size=90)
    for count, looked in ((LEARNING.several - 1, False), (LEARNING.several, True)):
        far = np.argsort(x[:, 1])[-count:]
        y = quiet.copy()
        y[far] += 1.0 + x[far, 1]
        assert bool(_rectified_columns(sample(y, x, window=1))) is looked
    (first, *_) = _rectified_columns(sample(y, x, window=1))
    assert first == (1,)


def test_columns_that_roles_ask_for_are_tried_alone_first() -> None:
    x, rng = columns(7, 3)
    y = 0.3 * x[:, 0] + 0.2 * x[:, 1] + 0.01 * rng.normal(size=len(x))
    group = PIECE
    marks = windows(PIECE, ROW, 12)
    made = _Sample(x, y, group, {1: windows(PIECE, ROW, 1), 12: marks}, marks)
    sets = _column_sets(made, np.array([False, True, False]))
    assert sets[0][0] == (1,)
    assert any(set(c) == {0, 1} for c, _ in sets)
    assert len(sets) == len(set(sets)) and all(c for c, _ in sets)
    lengths = [n for c, n in sets if c == (1,)]
    assert lengths[0] == 12, "noise in inputs biases single ticks"


@pytest.mark.parametrize("rows", [LEARNING.most_rows, 3 * LEARNING.most_rows])
def test_of_more_rows_than_one_fit_needs_some_are_drawn_evenly_with_both_ends(rows: int) -> None:
    seen: list[np.ndarray] = []

    class Notes:
        def fit(self, x: np.ndarray, y: np.ndarray) -> None:
            seen.append(np.column_stack([x, y]))
            raise ValueError("noted")

    spec: Any = SimpleNamespace(make=Notes)
    number = np.arange(float(rows))
    assert _fitted(spec, number[:, None], -number) is None, "what can't be fitted is no candidate"
    drawn = seen[0][:, 0]
    assert len(drawn) == LEARNING.most_rows
    assert (drawn[0], drawn[-1]) == (0.0, rows - 1.0)
    assert np.ptp(np.diff(drawn)) <= 1.0
    np.testing.assert_array_equal(seen[0][:, 1], -drawn)


@pytest.mark.parametrize("window", [1, 2, 12])
def test_readings_noise_is_that_of_a_mean_change_or_of_a_reading_where_nothing_is_remembered(
    window: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    noises: list[tuple[np.ndarray, np.ndarray]] = []

    def gains(sample: _Sample, before: np.ndarray, after: np.ndarray, by_noise: np.ndarray) -> np.ndarray:
        noises.append((by_noise, np.array([b - a for a, b in sample.judge], dtype=float)))
        return np.zeros(len(by_noise))

    monkeypatch.setattr(regression, "_window_gains", gains)
    x, _ = columns(8)
    assert choose_regression(x, x[:, 0], PIECE, ROW, ESTIMATORS, window, np.zeros(6, dtype=bool), 0.01) is None
    by_noise, length = noises[0]
    assert length.max() == pytest.approx(window, abs=2)
    np.testing.assert_allclose(by_noise, 1e-4 if window == 1 else 2e-4 / length**2)
