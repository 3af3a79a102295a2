"""The joystick: geometry, curve, spring, sensor."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ichain_drake.errors import InputError
from ichain_drake.objects import Joystick, JoystickMount
from ichain_drake.objects.controls.joystick import FULL_TILT, axes_from_tilt, tilt_from_axes
from ichain_drake.robot import HandSpec
from ichain_drake.state import StateSpace, Variable
from ichain_drake.timing import FRAME

MOUNT = JoystickMount((0.4, -0.1, 0.2), yaw=0.7, handle=0.12)
HAND = HandSpec(["x", "y", "z", "grip"]).space
tilts = st.tuples(st.floats(-0.55, 0.55), st.floats(-0.55, 0.55)).map(np.array)


@given(tilts)
def test_the_stick_points_to_where_its_knob_is(tilt: np.ndarray) -> None:
    knob = MOUNT.knob_from_tilt(tilt)
    assert np.linalg.norm(knob - MOUNT.pivot) == pytest.approx(MOUNT.handle)
    np.testing.assert_allclose(MOUNT.tilt_from_knob(knob[:2]), tilt, atol=1e-9)


@given(st.tuples(st.floats(-0.95, 0.95), st.floats(-0.95, 0.95)).map(np.array))
def test_tilt_from_axes_inverts_the_curve(axes: np.ndarray) -> None:
    np.testing.assert_allclose(axes_from_tilt(tilt_from_axes(axes)), axes, atol=1e-9)


def test_axes_are_those_of_the_specification() -> None:
    """Written out once more: coupled, off centre, curved."""
    a, b = 0.5, -0.3
    ax, ay = 0.98 * a + 0.08 * b + 0.03, b - 0.06 * a - 0.02
    expected = [math.tanh(1.5 * q) / math.tanh(1.5) for q in (ax * (1 - 0.06 * ay**2), ay * (1 - 0.06 * ax**2))]
    np.testing.assert_allclose(axes_from_tilt(np.array([a, b]) * FULL_TILT), expected, atol=1e-15)
    assert np.abs(axes_from_tilt(np.array([2.0, -2.0]))).max() == 1.0


def test_a_held_stick_follows_the_hand_within_the_frame_and_a_released_one_springs_back() -> None:
    stick = Joystick("stick", {"hand": HAND}, mount=MOUNT)
    tilt = np.array([0.2, -0.1])
    hand = np.append(MOUNT.knob_from_tilt(tilt), 1.0)
    state = stick.default_state()
    held = stick.step(state, {"hand": hand}, {"hand": np.float64(1)}, np.zeros(0), FRAME)
    np.testing.assert_allclose(held, Joystick.state_at_tilt(tilt), atol=1e-12)
    for _ in range(15):
        held = stick.step(held, {"hand": hand}, {"hand": np.float64(0)}, np.zeros(0), FRAME)
    np.testing.assert_allclose(held, stick.default_state(), atol=1e-5)


def test_the_grip_decides_without_a_body_and_the_contact_force_with_one() -> None:
    stick = Joystick("stick", {"hand": HAND})
    state, hands = stick.default_state(), {g: {"hand": np.array([0.5, 0.0, 0.15, g])} for g in (0.0, 1.0)}
    for grip, hand in hands.items():
        assert stick.decide_active(state, hand, {"hand": False}, None) == {"hand": bool(grip)}
    rows = {"hand": np.array([hand["hand"] for hand in hands.values()])}
    many = stick.decide_rows(np.tile(state, (len(hands), 1)), rows, {"hand": np.ones(len(hands), dtype=bool)})
    np.testing.assert_array_equal(many["hand"], [bool(grip) for grip in hands])
    # Hysteresis: 0.5 N keeps an interaction but does not start one.
    assert stick.decide_active(state, hands[0.0], {"hand": True}, 0.5) == {"hand": True}
    assert stick.decide_active(state, hands[1.0], {"hand": False}, 0.5) == {"hand": False}
    assert stick.decide_active(state, hands[1.0], {"hand": False}, 1.5) == {"hand": True}
    assert stick.decide_active(state, hands[1.0], {"hand": True}, 0.1) == {"hand": False}


def test_the_sensor_is_noisy_within_its_range_and_rounded() -> None:
    stick = Joystick("stick", {"hand": HAND})
    read = stick.measure(np.tile([0, 0, 0.3, 1.0], (500, 1)), np.random.default_rng(0).standard_normal((500, 2)))
    np.testing.assert_allclose(read * 127, np.round(read * 127), atol=1e-9)
    assert read.max() == 1.0
    assert read[:, 0].std() == pytest.approx(0.0046, rel=0.15)  # 0.004 with the rounding's 1 / 127 / sqrt(12)


def test_parents_that_do_not_fit_are_refused() -> None:
    with pytest.raises(InputError, match="stick: its parent knob has no position along x"):
        Joystick("stick", {"knob": StateSpace("knob", (Variable("turn"),))})
    with pytest.raises(InputError, match="stick: a joystick has one parent"):
        Joystick("stick", {"a": HAND, "b": HAND})
