"""The wheel: where a hand leads its knob, what it reads, and what is left of it when it is let go."""

from __future__ import annotations

import numpy as np
import pytest

from ichain_drake.errors import InputError
from ichain_drake.objects import Joystick, Wheel, WheelMount, check_object
from ichain_drake.objects.controls.wheel import TRAVEL
from ichain_drake.robot import HAND
from ichain_drake.timing import FRAME

MOUNT = WheelMount()
HANDS = {"hand": HAND}


def hand_at(position: np.ndarray, grip: float = 1.0) -> np.ndarray:
    return np.concatenate([position, [0.0, 0.0, 0.0, grip]])


def test_the_knob_inverts_the_wheel() -> None:
    rng = np.random.default_rng(0)
    wheel = rng.uniform([-2.4, -0.02], [2.4, 0.02], (50, 2))
    np.testing.assert_allclose(MOUNT.wheel_from_knob(MOUNT.knob_from_wheel(wheel)), wheel, atol=1e-12)
    np.testing.assert_allclose(MOUNT.knob_from_wheel(np.zeros(2)), [0.36, 0.0, 0.165])


def test_only_the_bearing_of_a_hand_off_the_circle_counts_and_ends_are_mechanical() -> None:
    knob = MOUNT.knob_from_wheel(np.array([0.7, 0.01]))
    nearer = knob + 0.4 * (np.array([*MOUNT.center[:2], knob[2]]) - knob)
    np.testing.assert_allclose(MOUNT.wheel_from_knob(nearer), [0.7, 0.01], atol=1e-12)
    beyond = MOUNT.wheel_from_knob(MOUNT.knob_from_wheel(np.array([3.0, 0.1])))
    np.testing.assert_allclose(beyond, [np.radians(150), TRAVEL])


def test_held_it_follows_the_hand_let_go_the_column_springs_back_and_the_angle_stays() -> None:
    wheel = Wheel("wheel", HANDS)
    goal = np.array([1.2, -0.015])
    hand = {"hand": hand_at(MOUNT.knob_from_wheel(goal))}
    held = wheel.step(np.zeros(2), hand, {"hand": np.float64(1)}, np.zeros(0), FRAME)
    np.testing.assert_allclose(held, goal, atol=1e-12)
    free = held
    for _ in range(10):
        free = wheel.step(free, hand, {"hand": np.float64(0)}, np.zeros(0), FRAME)
    assert free[0] == goal[0]
    assert abs(free[1]) < 1e-6
    decide = wheel.decide_active
    assert decide(held, hand, {"hand": False}, None) == {"hand": True}
    assert decide(held, {"hand": hand_at(np.zeros(3), grip=0.0)}, {"hand": True}, None) == {"hand": False}
    assert decide(held, hand, {"hand": False}, 0.5) == {"hand": False}  # a light touch is no grasp
    assert decide(held, hand, {"hand": True}, 0.5) == {"hand": True}  # but does not end one


def test_it_keeps_the_contract_and_wants_a_hand() -> None:
    check_object(Wheel("wheel", HANDS))
    with pytest.raises(InputError, match="joystick has no position along x"):
        Wheel("wheel", {"stick": Joystick.state_space})
    with pytest.raises(InputError, match="one parent, the hand; 2 given"):
        Wheel("wheel", {"a": HAND, "b": HAND})
