"""The hovercraft against its equations, written out once more in scalars, and against what a thing that slides does."""

from math import cos, pi, sin, sqrt

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ichain_drake.errors import InputError
from ichain_drake.objects import Hovercraft, Joystick, check_object
from ichain_drake.state import StateSpace, Variable
from ichain_drake.timing import FRAME

CRAFT = Hovercraft("craft", {"stick": Joystick.state_space})


def specified(state: np.ndarray, axes: np.ndarray, n: np.ndarray, dt: float) -> list[float]:
    x, y, th, u, v, w, fan = map(float, state)
    jx, jy = map(float, axes)
    drag = 0.003 * sqrt(u * u + v * v) + 1.2 * max(-jy, 0)
    u1 = u + dt * (75 * fan - (0.6 + drag) * u + w * v + 2.5 * cos(th) - 1.5 * sin(th)) + sqrt(dt) * 4 * n[0]
    v1 = v + dt * (-(1.6 + drag) * v - w * u - 1.5 * cos(th) - 2.5 * sin(th)) + sqrt(dt) * 4 * n[1]
    w1 = w + dt * (3 * jx * (0.7 + 0.3 * jx**2) - 2 * w + 0.03 * v) + sqrt(dt) * 0.15 * n[2]
    x1 = x + dt * (u1 * cos(th) - v1 * sin(th)) + sqrt(dt) * 0.4 * n[3]
    y1 = y + dt * (u1 * sin(th) + v1 * cos(th)) + sqrt(dt) * 0.4 * n[4]
    fan1 = fan + dt * (max(jy, 0) * (0.7 + 0.3 * abs(jy)) - fan) / 0.25
    return [x1, y1, (th + dt * w1 + pi) % (2 * pi) - pi, u1, v1, w1, fan1]


@settings(max_examples=50)
@given(st.integers(0, 10**6))
def test_one_frame_is_the_specified_one(seed: int) -> None:
    rng = np.random.default_rng(seed)
    state = rng.uniform([0, 0, -3.1, -20, -40, -2, 0], [800, 600, 3.1, 70, 40, 2, 1])
    axes, noise = rng.uniform(-1, 1, 2), rng.standard_normal(5)
    got = CRAFT.step(state, {"stick": np.array([0.0, 0.0, *axes])}, {"stick": np.float64(1)}, noise, FRAME)
    np.testing.assert_allclose(got, specified(state, axes, noise, FRAME), rtol=1e-12, atol=1e-12)


def drive(state: np.ndarray, axes: tuple[float, float], frames: int) -> np.ndarray:
    for _ in range(frames):
        state = CRAFT.step(state, {"stick": np.array([0, 0, *axes])}, {"stick": np.float64(1)}, np.zeros(5), FRAME)
    return state


def test_it_slides_where_a_car_would_turn() -> None:
    """Turned by a quarter without thrust, most of its momentum still points where it went."""
    state = np.array([0.0, 0.0, 0.0, 60.0, 0.0, 0.0, 0.0])
    after = drive(state, (1.0, 0.0), 30)
    c, s = np.cos(after[2]), np.sin(after[2])
    velocity = np.array([c * after[3] - s * after[4], s * after[3] + c * after[4]])
    assert after[2] > 0.5
    assert np.arctan2(velocity[1], velocity[0]) < 0.5 * after[2]


def test_it_goes_ahead_and_the_brake_stops_it() -> None:
    fast = drive(CRAFT.default_state(), (0.0, 1.0), 300)
    assert 60 < np.hypot(fast[3], fast[4]) < 110
    slow = drive(fast, (0.0, -1.0), 90)
    assert np.hypot(slow[3], slow[4]) < 5


def test_it_keeps_the_contract_of_objects() -> None:
    check_object(Hovercraft("craft", {"stick": Joystick.state_space}))


def test_parents_that_do_not_fit_are_refused() -> None:
    with pytest.raises(InputError, match="craft: a hovercraft has one parent with two observable variables"):
        Hovercraft("craft", {"knob": StateSpace("knob", (Variable("turn"),))})
