"""Scaling of inputs, beside plain numpy."""

import numpy as np
import pytest

from ichain_drake.learning.frozen.scaling import InputScaling

MEAN, SCALE = np.array([1.0, -2.0, 0.5]), np.array([2.0, 0.5, 4.0])
X = np.random.default_rng(0).normal(size=(20, 3)) * 3


@pytest.mark.parametrize("clip", [np.inf, 0.7])
def test_inputs_are_scaled_and_then_clipped(clip: float) -> None:
    np.testing.assert_allclose(InputScaling(MEAN, SCALE, clip).apply(X), np.clip((X - MEAN) / SCALE, -clip, clip))


@pytest.mark.parametrize("clip", [np.inf, 0.7])
def test_one_scaling_after_another_is_both_of_them(clip: float) -> None:
    mean, scale = np.array([0.3, 0.1, -1.0]), np.array([0.2, 3.0, 5.0])
    for last in (InputScaling(MEAN, SCALE, clip), InputScaling.identity(3)):
        np.testing.assert_allclose(last.after(mean, scale).apply(X), last.apply((X - mean) / scale))


@pytest.mark.parametrize(
    "scaling", [InputScaling(MEAN, SCALE), InputScaling(MEAN, SCALE, 0.7), InputScaling.identity(3)]
)
def test_slopes_are_those_of_what_is_scaled(scaling: InputScaling) -> None:
    outer, step = np.arange(6.0).reshape(2, 3), 1e-6
    for x in X[:5]:
        z = scaling.apply(x)
        slope = np.stack([(scaling.apply(x + step * e) - scaling.apply(x - step * e)) / (2 * step) for e in np.eye(3)])
        np.testing.assert_allclose(scaling.pull_back(outer, z), outer * np.diag(slope), atol=1e-6)


def test_scalings_are_the_same_only_bit_by_bit() -> None:
    one = InputScaling(MEAN, SCALE, 0.7)
    assert one.same_as(InputScaling(MEAN.copy(), SCALE.copy(), 0.7))
    for other in (
        InputScaling(MEAN + 1e-12, SCALE, 0.7),
        InputScaling(MEAN, 2 * SCALE, 0.7),
        InputScaling(MEAN, SCALE),
    ):
        assert not one.same_as(other)
