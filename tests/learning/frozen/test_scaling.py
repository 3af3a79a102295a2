"""Scalings of inputs: one after another, and what clipping leaves of a derivative."""

import numpy as np
import pytest

from ichain_drake.learning.frozen.scaling import InputScaling

MEAN, SCALE = np.array([1.0, -2.0]), np.array([2.0, 0.5])


@pytest.mark.parametrize("clip", [np.inf, 1.5])
def test_one_after_another_is_both(clip: float) -> None:
    second = InputScaling(np.array([0.5, 3.0]), np.array([4.0, 0.1]), clip)
    x = np.random.default_rng(0).normal(size=(9, 2))
    joined = second.after(MEAN, SCALE)
    np.testing.assert_allclose(joined.apply(x), second.apply((x - MEAN) / SCALE))
    np.testing.assert_allclose(InputScaling.identity(2).after(MEAN, SCALE).apply(x), (x - MEAN) / SCALE)


def test_beyond_its_clip_an_input_has_no_effect() -> None:
    scaling = InputScaling(MEAN, SCALE, 2.0)
    np.testing.assert_allclose(scaling.apply(np.array([[1.0, 0.0], [-9.0, -2.5]])), [[0.0, 2.0], [-2.0, -1.0]])
    jacobian = np.ones((1, 2))
    np.testing.assert_allclose(scaling.pull_back(jacobian, np.array([0.5, 1.0])), [[0.5, 2.0]])
    np.testing.assert_allclose(scaling.pull_back(jacobian, np.array([0.5, -2.0])), [[0.5, 0.0]])
    np.testing.assert_allclose(InputScaling(MEAN, SCALE).pull_back(jacobian, np.array([9.0, 9.0])), [[0.5, 2.0]])


def test_scalings_are_the_same_only_bit_by_bit() -> None:
    one = InputScaling(MEAN, SCALE, 0.7)
    assert one.same_as(InputScaling(MEAN.copy(), SCALE.copy(), 0.7))
    for other in (
        InputScaling(MEAN + 1e-12, SCALE, 0.7),
        InputScaling(MEAN, 2 * SCALE, 0.7),
        InputScaling(MEAN, SCALE),
    ):
        assert not one.same_as(other)
