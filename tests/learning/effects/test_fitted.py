"""A fitted change, asked for: within what was shown, one way, and nothing within its dead band."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from ichain_drake.learning.effects.fitted import Regression, one_way


class Twice:
    """A model that doubles its only input."""

    def batch(self, rows: np.ndarray) -> np.ndarray:
        return 2.0 * rows


MODEL: Any = Twice()
PLAIN = Regression((0,), MODEL, 0.7, None, None, 0.0, 0, "twice", 0.1, 0.1, 0.9, 40, 4, 1.0)
ROWS = np.array([[-3.0], [-0.2], [0.1], [2.0]])


def test_without_a_model_it_is_its_constant() -> None:
    assert replace(PLAIN, frozen=None)(ROWS).tolist() == [0.7] * 4
    np.testing.assert_allclose(PLAIN(ROWS), 2.0 * ROWS[:, 0])


def test_a_bend_is_not_asked_beyond_what_was_shown() -> None:
    bent = replace(PLAIN, low=np.array([-1.0]), high=np.array([0.5]))
    np.testing.assert_allclose(bent(ROWS), [-2.0, -0.4, 0.2, 1.0])


@pytest.mark.parametrize(
    ("sign", "kept"), [(0, [-6.0, -0.4, 0.2, 4.0]), (1, [0, 0, 0.2, 4.0]), (-1, [-6.0, -0.4, 0, 0])]
)
def test_what_only_goes_one_way_never_goes_the_other(sign: int, kept: list[float]) -> None:
    np.testing.assert_allclose(replace(PLAIN, sign=sign)(ROWS), kept)
    np.testing.assert_allclose(one_way(2.0 * ROWS[:, 0], sign), kept)


def test_less_than_the_dead_band_is_nothing_and_as_much_is_all_of_it() -> None:
    np.testing.assert_allclose(replace(PLAIN, dead_band=0.3)(ROWS), [-6.0, -0.4, 0.0, 4.0])
    np.testing.assert_allclose(replace(PLAIN, dead_band=0.4)(ROWS), [-6.0, -0.4, 0.0, 4.0])
    np.testing.assert_allclose(replace(PLAIN, dead_band=0.3, sign=1)(ROWS), [0.0, 0.0, 0.0, 4.0])
