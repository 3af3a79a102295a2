"""Faces that are placed by counting, on samples that can be counted by hand."""

import numpy as np
import pytest
from scipy.stats import norm

from ichain_drake.learning.status.faces import Faces


def counted(values: list[float], positive: str, reach: float = 0.3, weight: float = 1.0) -> tuple[float, float]:
    faces = Faces(np.array(values, dtype=float)[:, None], np.array([c == "1" for c in positive]), reach, weight)
    faces.count()
    return float(faces.low[0]), float(faces.high[0])


def test_a_face_does_not_part_equal_values() -> None:
    assert counted([0, 1, 1, 1, 2], "11100") == pytest.approx((-0.3, 1.3))


def test_a_face_lies_in_the_middle_of_its_gap_but_no_further_than_its_reach() -> None:
    assert counted([0, 1, 1.4, 5, -0.2], "11000") == pytest.approx((-0.1, 1.2))
    assert counted([0, 1, 3, 5, -2], "11000") == pytest.approx((-0.3, 1.3))
    assert counted([0, 1, 3, 5, -2], "11000", reach=0.1) == pytest.approx((-0.1, 1.1))
    assert counted([0, 2, -4], "100", reach=0.3) == pytest.approx((-2.0, 1.0)), "of one sample there is no width"


def test_a_stray_sample_stays_outside_unless_it_counts_for_more() -> None:
    values, positive = [0, 1, 2, 3, 4, 5, 6], "1110001"
    assert counted(values, positive)[1] == pytest.approx(2.5)
    assert counted(values, positive, weight=4.0)[1] == pytest.approx(7.8)


def test_beyond_which_faces_something_was_seen() -> None:
    faces = Faces(np.array([[0.0, 5.0], [1.0, 6.0], [0.0, 7.0]]), np.array([True, True, False]), 0.3)
    assert faces.shown().tolist() == [[False, False], [False, True]], "what lies on a face is not beyond it"
    assert faces.inside().tolist() == [True, True, False]
    assert faces.inside(but=1).tolist() == [True, True, True]


def test_noise_moves_a_face_that_is_shown_to_the_middle_of_what_it_leaves_open() -> None:
    """Samples far from each other on both sides: any face between them explains them alike."""
    values = np.array([[-1.0], [-0.9], [0.9], [1.0], [2.0], [2.1]])
    faces = Faces(values, np.array([True, True, True, True, False, False]), 0.3)
    faces.count()
    before = faces.low.copy(), faces.high.copy()
    faces.settle(np.array([0.0]), 0.01, faces.shown())
    np.testing.assert_array_equal([faces.low, faces.high], before)
    faces.settle(np.array([0.05]), 0.01, faces.shown())
    np.testing.assert_array_equal(faces.low, before[0])
    assert faces.high[0] == pytest.approx(1.5, abs=0.02)


def wrong(faces: Faces, low: np.ndarray, high: np.ndarray, weight: float) -> float:
    """Weight of the samples on the wrong side of a box."""
    inside = ((faces.x >= low) & (faces.x <= high)).all(axis=1)
    return float(weight * (faces.positive & ~inside).sum() + (~faces.positive & inside).sum())


@pytest.mark.parametrize("weight", [1.0, 2.5])
@pytest.mark.parametrize("seed", range(4))
def test_no_face_by_itself_could_lie_better(seed: int, weight: float) -> None:
    rng = np.random.default_rng(seed)
    x = rng.integers(0, 12, (80, 3)).astype(float)
    positive = (np.abs(x[:, :2] - 5.0) < 3.2).all(axis=1) ^ (rng.uniform(size=80) < 0.1)
    faces = Faces(x, positive, 0.3, weight)
    start = wrong(faces, faces.low.copy(), faces.high.copy(), weight)
    faces.count()
    best = wrong(faces, faces.low, faces.high, weight)
    assert best < start
    for j in range(3):
        for place in np.arange(-0.5, 12.0):
            for side in ("low", "high"):
                moved = {"low": faces.low.copy(), "high": faces.high.copy()}
                moved[side][j] = place
                if positive[((x >= moved["low"]) & (x <= moved["high"])).all(axis=1)].any():
                    assert wrong(faces, moved["low"], moved["high"], weight) >= best, (j, side, place)


def test_what_lies_beyond_another_face_holds_none_back() -> None:
    """A negative sample right beside the box in one feature, but far off in the other, says nothing of the one."""
    x = np.array([[0.0, 0.0], [1.0, 1.0], [1.1, 5.0], [-0.1, -5.0], [1.4, 0.5]])
    faces = Faces(x, np.array([True, True, False, False, False]), 0.3)
    faces.count()
    assert faces.high[0] == pytest.approx(1.2), "half way to the one beside it in both"
    assert faces.low[0] == pytest.approx(-0.3)
    assert (faces.low[1], faces.high[1]) == pytest.approx((-0.3, 1.3))


def test_samples_that_were_sorted_need_not_be_sorted_again() -> None:
    rng = np.random.default_rng(0)
    x, positive = rng.normal(size=(30, 2)), np.arange(30) < 12
    one = Faces(x, positive, 0.3, 3.0)
    again = Faces(x, positive, 0.3, 3.0, one.order)
    assert again.order is one.order
    for j in range(2):
        assert (np.diff(x[one.order[j], j]) >= 0).all()
    one.count()
    again.count()
    np.testing.assert_array_equal([again.low, again.high], [one.low, one.high])


def mean_face(values: np.ndarray, on: np.ndarray, face: float, noise: float, slip: float) -> float:
    """Mean of an upper face by its likelihood, place by place and sample by sample."""
    half = min(face - values[on & (values <= face)].max(), values[~on & (values > face)].min() - face) + 4.0 * noise
    places, likely = face + half * np.linspace(-1.0, 1.0, 33), []
    for place in places:
        p = slip + (1.0 - 2.0 * slip) * np.array([norm.cdf(place, loc=v, scale=noise) for v in values])
        likely.append(np.prod(np.where(on, p, 1.0 - p)))
    return float(np.average(places, weights=likely))


@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize("noise", [0.05, 0.2])
def test_a_face_lies_at_the_mean_of_its_likelihood(noise: float, *, mirrored: bool) -> None:
    """Also where a sample lies on the wrong side of it; the other end of the box has nothing to do with it."""
    values = np.array([-3.0, -2.0, 0.0, 0.8, 0.9, 1.15, 1.2, 1.3, 1.8, 2.4])
    on = np.array([True, True, True, True, True, False, True, False, False, False])
    sign = -1.0 if mirrored else 1.0
    faces = Faces(sign * values[:, None], on, 0.3)
    faces.low[:], faces.high[:] = (-1.25, 4.0) if mirrored else (-4.0, 1.25)
    faces.settle(np.array([noise]), 0.02, faces.shown())
    expected = sign * mean_face(values, on, 1.25, noise, 0.02)
    assert (faces.low[0] if mirrored else faces.high[0]) == pytest.approx(expected, abs=1e-6)
    assert (faces.high[0] if mirrored else faces.low[0]) == sign * -4.0, "beyond it nothing was seen"


def test_faces_that_nothing_bounds_stay_where_they_are() -> None:
    values = np.array([0.0, 1.0, 5.0])
    faces = Faces(values[:, None], np.array([True, True, False]), 0.3)
    faces.low[:], faces.high[:] = 6.0, 7.0  # around nothing at all
    faces.settle(np.array([0.1]), 0.01, np.ones((2, 1), dtype=bool))
    assert (faces.low[0], faces.high[0]) == (6.0, 7.0)
    two = Faces(np.column_stack([values, -values]), np.array([True, True, False]), 0.3)
    two.count()
    before = two.low.copy(), two.high.copy()
    two.settle(np.array([0.1, 0.0]), 0.01, two.shown())
    np.testing.assert_array_equal([two.low[1], two.high[1]], [before[0][1], before[1][1]])
    assert two.low[0] == before[0][0]
