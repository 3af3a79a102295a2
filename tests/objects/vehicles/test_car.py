"""The car against its equations, written out once more in scalars."""

from math import cos, pi, sin, sqrt, tanh

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ichain_drake.errors import InputError
from ichain_drake.objects import Car, Joystick
from ichain_drake.state import StateSpace, Variable
from ichain_drake.timing import FRAME

CAR = Car("car", {"stick": Joystick.state_space})


def specified(state: np.ndarray, axes: np.ndarray, n: np.ndarray, dt: float) -> list[float]:
    x, y, th, v, w, u = map(float, state)
    jx, jy = map(float, axes)
    steer = jx * (0.65 + 0.35 * jx**2)
    thr = jy * (0.75 + 0.25 * abs(jy))
    acc = 90 * thr * (1 + 0.25 * (1 - tanh(4 * jy)))
    wc = steer * v / 22 / (1 + (v / 80) ** 2)
    v1 = v + dt * (acc - 0.8 * v - 0.006 * v * abs(v) - 0.075 * abs(v * w)) + sqrt(dt) * 10 * n[0]
    w1 = w + dt * (wc - w) / 0.15 + sqrt(dt) * 0.35 * n[1]
    u1 = u + dt * (-0.07 * v * w - u) / 0.12 + sqrt(dt) * 3 * n[2]
    lat, sc = u1 + 3 * sin(2 * th + 0.7), tanh(abs(v1) / 8)
    x1 = x + dt * (v1 * cos(th) - lat * sc * sin(th) + 3 * sc) + sqrt(dt) * 0.5 * n[3]
    y1 = y + dt * (v1 * sin(th) + lat * sc * cos(th) - 2 * sc) + sqrt(dt) * 0.5 * n[4]
    return [x1, y1, (th + dt * w1 + pi) % (2 * pi) - pi, v1, w1, u1]


@settings(max_examples=50)
@given(st.integers(0, 10**6))
def test_one_frame_is_the_specified_one(seed: int) -> None:
    rng = np.random.default_rng(seed)
    state = rng.uniform([0, 0, -3.1, -20, -2, -5], [800, 600, 3.1, 70, 2, 5])
    axes, noise = rng.uniform(-1, 1, 2), rng.standard_normal(5)
    stick = np.array([0.0, 0.0, *axes])
    got = CAR.step(state, {"stick": stick}, {"stick": np.float64(1)}, noise, FRAME)
    np.testing.assert_allclose(got, specified(state, axes, noise, FRAME), rtol=1e-12, atol=1e-12)


def drive(axes: tuple[float, float], frames: int, active: float = 1.0) -> np.ndarray:
    state = CAR.default_state()
    for _ in range(frames):
        state = CAR.step(state, {"stick": np.array([0, 0, *axes])}, {"stick": np.float64(active)}, np.zeros(5), FRAME)
    return state


def test_top_speed_and_smallest_turn() -> None:
    """Figures of the specification: about 73 px/s straight on, a turning radius of about 22 px at low speed."""
    assert drive((0.0, 1.0), 900)[3] == pytest.approx(73, abs=1.5)
    slow = drive((1.0, 0.1), 900)
    assert slow[3] / slow[4] == pytest.approx(22, rel=0.1)


def test_a_car_without_a_stick_rolls_to_a_stop() -> None:
    np.testing.assert_array_equal(drive((1.0, 1.0), 30, active=0.0), drive((0.0, 0.0), 30))


def test_parents_that_do_not_fit_are_refused() -> None:
    with pytest.raises(InputError, match="car: a car has one parent with two observable variables"):
        Car("car", {"knob": StateSpace("knob", (Variable("turn"),))})
    with pytest.raises(InputError, match="one parent"):
        Car("car", {"a": Joystick.state_space, "b": Joystick.state_space})
