"""Faces that are placed by counting, on samples that can be counted by hand."""

import numpy as np
import pytest

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
