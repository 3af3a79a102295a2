"""A model's lasting error is found, noise is not, and a plan that reckons with it arrives."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ichain_drake.control.tracking.levels import PredictiveLevel, PredictiveWeights
from ichain_drake.control.tracking.offset import OffsetEstimate
from ichain_drake.control.tracking.tick_model import LinearizedModel
from ichain_drake.state import StateSpace, Variable

SPACE = StateSpace("cart", (Variable("x", "m"), Variable("way", "rad", kind="angle")))


def estimate(errors: np.ndarray, **settings: float) -> np.ndarray:
    """Offset of the next tick after errors of shape (n_ticks, n_variables)."""
    found = OffsetEstimate(errors.shape[1], **settings)
    memory = np.zeros((1, found.memory_size))
    for error in errors:
        memory = found.update(memory, error[None])
    return found.offsets(memory, 3)[0]


def test_it_is_the_weighted_mean_less_what_chance_would_do():
    errors = 1.0 + np.random.default_rng(0).standard_normal((60, 1))
    mean = errors[0]
    for k, error in enumerate(errors[1:], start=2):
        mean = mean + max(0.2, 1 / k) * (error - mean)
    products = np.concatenate([(errors[k:] * errors[:-k])[:, 0] for k in range(2, 10)])
    lasting = products.mean() / np.mean(errors**2) - 2.0 / np.sqrt(len(products))
    assert 0.1 < lasting < 0.9
    believed = lasting / (lasting + 0.2 / 1.8 * (1 - lasting))
    np.testing.assert_allclose(estimate(errors)[:, 0], believed * mean[0] * 0.95 ** np.arange(3), rtol=1e-12)


def test_a_lasting_error_is_found_and_noise_is_left_alone():
    noise = np.random.default_rng(1).standard_normal((400, 300))
    assert np.sqrt(np.mean(estimate(noise)[0] ** 2)) < 0.05  # the mean with these weights: 0.33
    assert np.mean(estimate(2.0 + noise)[0]) == pytest.approx(2.0, abs=0.1)
    jitter = noise[1:] - noise[:-1]  # a reading that is off is off the other way a tick later
    assert np.sqrt(np.mean(estimate(jitter)[0] ** 2)) < 0.05
    assert estimate(np.full((4, 1), 0.3))[0] == 0.0  # four errors prove nothing
    assert estimate(np.full((100, 1), 0.3))[0] > 0.29


@settings(max_examples=50, deadline=None)
@given(st.integers(0, 2**31), st.integers(1, 30), st.floats(1e-6, 1e6))
def test_it_scales_with_the_errors_and_is_never_larger_than_their_mean(seed: int, ticks: int, scale: float):
    errors = np.random.default_rng(seed).standard_normal((ticks, 4))
    offset = estimate(errors)
    np.testing.assert_allclose(estimate(scale * errors), scale * offset, rtol=1e-9, atol=1e-12 * scale)
    assert (np.abs(offset) <= np.abs(errors).max(axis=0) + 1e-12).all()
    np.testing.assert_array_equal(estimate(0 * errors), 0.0)


class Cart(LinearizedModel):
    """Moves by its parent's state; a lasting error of the model is what the world adds."""

    def predict(self, child, parent, parent_next):
        return child + np.concatenate([parent_next, np.zeros_like(parent_next)], axis=1)

    def linearize(self, child, parent, parent_next):
        n = len(child)
        by_next = np.broadcast_to([[1.0], [0.0]], (n, 2, 1))
        eye = np.broadcast_to(np.eye(2), (n, 2, 2))
        return self.predict(child, parent, parent_next), eye, np.zeros((n, 2, 1)), by_next


def follow(gain: float, drift: float, ticks: int = 80) -> np.ndarray:
    """Distance from a line that is followed at .05 a tick, by a cart that drifts, shape (ticks,)."""
    level = PredictiveLevel(
        Cart(), SPACE, (0,), np.array([0.05]), np.array([-0.2]), np.array([0.2]), np.array([0.1]),
        PredictiveWeights(effort=0.3, along=1.0, offset=gain),
    )  # fmt: skip
    rng, memory = np.random.default_rng(3), np.zeros((1, level.memory_size))
    child, parent, off = np.zeros((1, 2)), np.zeros((1, 1)), []
    for k in range(ticks):
        wanted = 0.05 * (k + 1.0 + np.arange(level.lookahead))[None, :, None]
        plan, memory = level.decide(child, parent, wanted, memory)
        parent = plan[:, 0]
        child = Cart().predict(child, parent, parent) + [drift + 1e-4 * rng.standard_normal(), 0.0]
        off.append(child[0, 0] - 0.05 * (k + 1))
    return np.abs(off)


def test_a_plan_that_reckons_with_it_arrives():
    drifting, reckoning = follow(0.0, 0.03)[30:].mean(), follow(0.2, 0.03)[30:].mean()
    assert reckoning < 0.5 * drifting
    assert follow(0.2, 0.0)[30:].mean() < 1.5 * follow(0.0, 0.0)[30:].mean()


def test_without_it_nothing_is_remembered_of_errors():
    assert OffsetEstimate(3, 0.0).memory_size == 0
    np.testing.assert_array_equal(OffsetEstimate(3, 0.0).offsets(np.zeros((2, 0)), 4), np.zeros((2, 4, 3)))
