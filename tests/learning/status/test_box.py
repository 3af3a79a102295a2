"""The box: an estimator like any other, frozen to the same values, and faces where the data put them."""

import numpy as np
import pytest
from scipy.stats import norm
from sklearn.base import BaseEstimator
from sklearn.utils.estimator_checks import parametrize_with_checks

from ichain_drake.errors import InputError
from ichain_drake.learning.frozen import InputScaling, freeze, from_arrays
from ichain_drake.learning.status.box import Box, BoxClassifier


@parametrize_with_checks([BoxClassifier()])
def test_scikit_learns_contract(estimator: BaseEstimator, check: object) -> None:
    check(estimator)  # type: ignore[operator]


@pytest.fixture
def fitted() -> tuple[BoxClassifier, np.ndarray]:
    rng = np.random.default_rng(0)
    x = rng.uniform(-2, 2, (800, 3))
    y = (np.abs(x[:, 0]) < 0.5) & (x[:, 1] > -1)
    return BoxClassifier().fit(x, y), x


def test_faces_are_found(fitted: tuple[BoxClassifier, np.ndarray]) -> None:
    box, x = fitted
    np.testing.assert_allclose([box.lower_[0], box.upper_[0], box.lower_[1]], [-0.5, 0.5, -1.0], atol=0.05)
    assert np.mean(box.predict(x) == ((np.abs(x[:, 0]) < 0.5) & (x[:, 1] > -1))) > 0.99


def test_a_face_is_near_the_middle_of_a_gap_without_samples() -> None:
    """Nothing is known inside the gap; what is close to either side belongs to that side."""
    rng = np.random.default_rng(3)
    active, beside = rng.uniform(-1.0, 1.0, (300, 1)), rng.uniform(1.2, 3.0, (300, 1))
    x = np.vstack([active, [[1.0], [1.2]], beside, -beside, [[-1.0], [-1.2]]])
    y = np.abs(x[:, 0]) < 1.1
    box = BoxClassifier().fit(x, y)
    np.testing.assert_array_equal(box.predict([[1.05], [-1.05]]), True)
    np.testing.assert_array_equal(box.predict([[1.15], [-1.15]]), False)


def test_where_only_a_share_of_what_is_inside_is_active_the_box_is_where_that_share_is_large() -> None:
    """Half of the rows up to 1 are active and a sixteenth of those up to 1.5: to a box around 1, those are slips."""
    inside, beside, outside = np.linspace(-1.0, 1.0, 400), np.linspace(1.01, 1.5, 96), np.linspace(1.51, 3.0, 300)
    x = np.concatenate([inside, beside, outside, -outside])
    y = np.zeros(len(x), dtype=bool)
    y[:400:2], y[400:496:16] = True, True
    box = BoxClassifier(partial=True).fit(x[:, None], y)
    assert 0.95 < box.upper_[0] < 1.1
    assert -1.6 < box.lower_[0] < -0.95


def test_a_few_wrong_labels_move_no_face() -> None:
    rng = np.random.default_rng(1)
    x = rng.uniform(-2, 2, (600, 2))
    y = (np.abs(x) < 1).all(axis=1)
    y[:6] = True  # some of them far outside
    box = BoxClassifier().fit(x, y)
    np.testing.assert_allclose(box.upper_, 1.0, atol=0.15)


def test_frozen_and_saved_it_is_the_same(fitted: tuple[BoxClassifier, np.ndarray]) -> None:
    box, x = fitted
    frozen = freeze(box)
    np.testing.assert_array_equal(frozen.batch(x)[:, 0], box.decision_function(x))
    again = from_arrays(frozen.kind, frozen.arrays())
    np.testing.assert_array_equal(again.batch(x), frozen.batch(x))
    np.testing.assert_allclose(
        frozen.rescaled(np.array([2.0]), np.array([1.0])).batch(x), 2 * frozen.batch(x) + 1, atol=1e-12
    )


def test_the_jacobian_is_that_of_the_nearest_face(fitted: tuple[BoxClassifier, np.ndarray]) -> None:
    frozen, point = freeze(fitted[0]), np.array([0.4, 0.0, 0.1])
    _, jacobian = frozen.value_and_jacobian(point)
    numeric = [(frozen.value(point + h)[0] - frozen.value(point - h)[0]) / 2e-6 for h in 1e-6 * np.eye(3)]
    np.testing.assert_allclose(jacobian[0], numeric, atol=1e-6)


def test_bad_input_is_refused() -> None:
    x = np.arange(8.0)[:, None]
    with pytest.raises(InputError, match="needs two classes, 3 class"):
        BoxClassifier().fit(x, [0, 1, 2, 0, 1, 2, 0, 1])
    with pytest.raises(InputError, match="reach -1: give a number from 0"):
        BoxClassifier(reach=-1).fit(x, x[:, 0] > 3)


BOX = Box(
    inputs=InputScaling.identity(2), middle=np.array([1.0, -2.0]), half=np.array([2.0, 0.5]), gain=np.array([3.0]),
    offset=np.array([0.25]),
)  # fmt: skip


def test_a_box_is_highest_in_its_middle_and_falls_by_the_input_that_is_nearest_to_its_face() -> None:
    rows = np.array([[1.0, -2.0], [3.0, -2.0], [2.0, -2.0], [2.0, -1.6], [1.0, -3.0]])
    least = np.array([1.0, 0.0, 0.5, 0.2, -1.0])
    np.testing.assert_allclose(BOX.batch(rows)[:, 0], 3.0 * least + 0.25, atol=1e-12)
    np.testing.assert_allclose([BOX.value(row)[0] for row in rows], 3.0 * least + 0.25, atol=1e-12)
    for row in rows[2:]:
        _, slope = BOX.value_and_jacobian(row)
        tiny = 1e-6
        numeric = [(BOX.value(row + d)[0] - BOX.value(row - d)[0]) / (2 * tiny) for d in tiny * np.eye(2)]
        np.testing.assert_allclose(slope[0], numeric, atol=1e-6)
    np.testing.assert_allclose(BOX.rescaled(np.array([2.0]), np.array([-1.0])).batch(rows), 2.0 * BOX.batch(rows) - 1.0)


def test_the_likelihood_of_flags_is_that_of_readings_within_the_faces_that_are_shown() -> None:
    box = BoxClassifier(noise=[0.1, 0.2])
    box.lower_, box.upper_ = np.array([0.0, -1.0]), np.array([1.0, 1.0])
    box.shown_ = np.array([[True, False], [True, True]])  # nothing was ever seen below the second
    x = np.array([[0.5, 0.0], [1.1, 0.0], [-0.1, 0.0], [0.5, 1.2], [0.5, -9.0], [1.05, 1.1]])
    truth = np.array([True, False, True, False, True, True])
    inside = norm.cdf((1.0 - x[:, 0]) / 0.1) * norm.cdf(x[:, 0] / 0.1) * norm.cdf((1.0 - x[:, 1]) / 0.2)
    on = 0.05 + 0.9 * inside
    np.testing.assert_allclose(box.log_likelihood(x, truth, 0.05), np.log(np.where(truth, on, 1.0 - on)))
    sharp = BoxClassifier()
    sharp.lower_, sharp.upper_, sharp.shown_ = box.lower_, box.upper_, box.shown_
    told = np.where((x[:, 0] <= 1.0) & (x[:, 0] >= 0.0) & (x[:, 1] <= 1.0), 0.95, 0.05)
    np.testing.assert_allclose(sharp.log_likelihood(x, truth, 0.05), np.log(np.where(truth, told, 1.0 - told)))


def test_a_slip_is_as_frequent_as_samples_on_the_wrong_side() -> None:
    x = np.array([-2.0, -1.0, 0.0, 1.0, 2.0, 3.0, 4.0, 5.0])[:, None]
    clean = np.array([0, 0, 1, 1, 1, 0, 0, 0])
    assert BoxClassifier().fit(x, clean).slip_ == pytest.approx(1.0 / 10.0)
    stray = np.array([0, 0, 1, 1, 1, 0, 0, 1])
    assert BoxClassifier().fit(x, stray).slip_ == pytest.approx(2.0 / 10.0)
    box = BoxClassifier().fit(x, clean)
    assert box.shown_.tolist() == [[True], [True]]
    frozen = box.to_frozen()
    np.testing.assert_allclose(frozen.middle + [[-1], [1]] * frozen.half, [box.lower_, box.upper_])
    np.testing.assert_allclose(frozen.batch(np.array([box.lower_, box.upper_]))[:, 0], 0.0, atol=1e-9)


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"reach": -0.1}, "reach -0.1: give a number from 0"),
        ({"noise": -1.0}, "noise -1.0: give one number from 0, or one an input"),
        ({"noise": [0.1, 0.1]}, "noise .*: give one number from 0, or one an input"),
    ],
)
def test_parameters_that_can_not_be_are_refused(parameters: dict, message: str) -> None:
    with pytest.raises(InputError, match=message):
        BoxClassifier(**parameters).fit(np.arange(4.0)[:, None], [0, 1, 1, 0])
