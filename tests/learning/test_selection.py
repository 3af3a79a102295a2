"""The one criterion, beside plain numpy: what a likelihood is, and when a gain of it is clear."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.special import ndtr

from ichain_drake.learning.selection import (
    borne_out,
    by_part,
    calibrated,
    calibration_error,
    clearly,
    least_slip,
    log_probability,
)

GAINS = st.lists(st.floats(-5.0, 5.0), min_size=1, max_size=12)


@given(GAINS, st.integers(0, 20))
def test_parts_that_tell_nothing_change_nothing(gains: list[float], more: int) -> None:
    assert clearly(gains) == clearly([*gains, *[0.0] * more])


@given(GAINS)
def test_one_of_two_models_at_most_is_clearly_better(gains: list[float]) -> None:
    assert not (clearly(gains) and clearly([-g for g in gains]))


@pytest.mark.parametrize(("gains", "clear"), [([2.0], False), ([2.0, -1e-3], False), ([2.0, 0.5], True), ([], False)])
def test_one_part_alone_is_never_clear(gains: list[float], clear: bool) -> None:
    assert clearly(gains) is clear


def test_who_was_picked_from_many_has_to_gain_more() -> None:
    gains = [1.0, 1.0, 1.0]
    assert clearly(gains, tried=20)  # log 20 is 2.996
    assert not clearly(gains, tried=21)
    assert clearly([1e-3, 1e-3], tried=0)


def test_a_second_part_has_to_bear_out_what_one_shows() -> None:
    assert clearly([20.0, 1.0, 0.5], tried=5)  # log 5 is 1.609
    assert not borne_out([20.0, 1.0, 0.5], tried=5)
    assert borne_out([20.0, 1.0, 0.7], tried=5)
    assert borne_out([20.0, 1.0])
    assert not borne_out([2.0, 2.0, -1.0, -3.0]), "it is clear, besides"
    assert not borne_out([])


def test_values_are_summed_by_part_and_parts_without_rows_have_none() -> None:
    np.testing.assert_array_equal(by_part(np.array([1.0, 2.0, 4.0]), np.array([3, 0, 3])), [2.0, 0.0, 0.0, 5.0])
    assert by_part(np.zeros(0), np.zeros(0, dtype=np.intp)).shape == (0,)


def test_the_likelihood_of_flags_is_that_of_a_slip_either_way() -> None:
    truth, inside = np.array([True, True, False, False]), np.array([1.0, 0.0, 1.0, 0.25])
    on = 0.1 + 0.8 * inside
    np.testing.assert_allclose(np.exp(log_probability(truth, inside, 0.1)), [on[0], on[1], 1 - on[2], 1 - on[3]])


@pytest.mark.parametrize(("flags", "slip"), [("0000", 1 / 6), ("0011", 2 / 6), ("0101", 4 / 6), ("1", 1 / 3)])
def test_a_flag_beside_a_switch_may_be_of_either_side(flags: str, slip: float) -> None:
    assert least_slip(np.array([f == "1" for f in flags])) == pytest.approx(slip)


def test_decisions_are_read_as_sharply_as_their_flags_are() -> None:
    rng = np.random.default_rng(0)
    decisions = rng.uniform(-1.0, 1.0, 4000)
    soft = rng.random(4000) < ndtr(decisions / 0.3)
    spread, slip, rows = calibrated(decisions, soft, 1e-3)
    assert spread == pytest.approx(0.3, rel=0.35)  # its grid's step is a third
    assert slip < 0.01
    np.testing.assert_allclose(rows, log_probability(soft, ndtr(decisions / spread), slip))
    wrong = (decisions > 0) ^ (rng.random(4000) < 0.2)
    sharp, often, _ = calibrated(decisions, wrong, 1e-3)
    assert sharp < 0.02
    assert often == pytest.approx(0.2, rel=0.5)


def test_slips_are_no_rarer_than_told() -> None:
    decisions = np.linspace(-1.0, 1.0, 100)
    assert calibrated(decisions, decisions > 0, 0.05)[1] == pytest.approx(0.05)
    even = calibrated(np.zeros(4), np.array([True, False, True, False]), 0.6)[1]
    assert 0.4 <= even < 0.5, "no more than half is ever wrong"


def test_calibration_is_judged_by_bins_of_equal_width() -> None:
    probability, truth = np.array([0.05, 0.05, 0.95, 1.0]), np.array([False, True, True, True])
    expected = (abs(1 - 0.1) + abs(2 - 1.95)) / 4
    assert calibration_error(probability, truth) == pytest.approx(expected)
    assert calibration_error(np.array([0.95, 1.0]), np.array([True, False])) == pytest.approx(0.95 / 2), "1 is no bin"
    assert calibration_error(np.array([0.2, 0.8]), np.array([False, True]), bins=1) == pytest.approx(0.0)
    assert calibration_error(np.array([0.25]), np.array([True])) == pytest.approx(0.75)
    assert calibration_error(np.zeros(0), np.zeros(0, dtype=bool)) == 0.0
