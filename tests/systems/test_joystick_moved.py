"""The joystick elsewhere, turned, or held by other fingers: what is declared follows, what is not has to be learned."""

import numpy as np
import pytest
from pydrake.multibody.tree import JointIndex

from ichain_drake.errors import InputError
from ichain_drake.robot import SphereSurface
from ichain_drake.scenarios.joystick_game import JoystickGame
from ichain_drake.systems import load_scenario
from ichain_drake.systems.car_game.scenario import CarGame

LONG_FINGERS = "robot.model=package://ichain_drake_models/robots/gen3_long_fingers.dmd.yaml"


def game(*settings: str, physics: str = "ideal", seed: int = 0) -> CarGame:
    scenario = load_scenario("car_game", settings, physics, seed)  # type: ignore[arg-type]
    assert isinstance(scenario, CarGame)
    return scenario


def test_one_key_moves_all_that_is_about_the_joystick() -> None:
    scenario = game("joystick.pivot=[0.46, 0.06, 0.07]")
    robot = scenario.config.robot
    assert robot.hand.surface == SphereSurface([0.46, 0.06, 0.07], 0.1)
    assert (robot.home["x"], robot.home["y"]) == (0.46, 0.06)
    np.testing.assert_allclose([robot.hand.space.lower, robot.hand.space.upper], [[0.36, -0.04], [0.56, 0.16]])
    np.testing.assert_allclose(np.mean(scenario.command_range(), axis=0), [0.46, 0.06])
    assert scenario.graph.origins["joystick"].position == (0.46, 0.06, 0.07)
    assert scenario.given()["graph"]["origins"] == {"joystick": {"frame": "robot", "position": [0.46, 0.06, 0.07]}}


def test_what_is_set_about_the_hand_stays() -> None:
    robot = game("robot.hand.surface={center: [0.5, 0, 0.04], radius: 0.11}", "robot.home={x: 0.48}").config.robot
    assert robot.hand.surface == SphereSurface([0.5, 0, 0.04], 0.11)
    assert robot.home == {"x": 0.48, "y": 0.0}


def play(*settings: str) -> np.ndarray:
    table = game("learning.samples=30", "noise.scale=0", *settings).record_play(30).table
    return table[["joystick.x_axis", "joystick.y_axis"]].to_numpy()


def test_a_declared_move_is_no_change_and_an_undeclared_one_is() -> None:
    np.testing.assert_allclose(play("joystick.pivot=[0.46, 0.06, 0.07]"), play(), atol=0.01)
    assert np.abs(play("joystick.offset=[0.006, 0]") - play()).max() > 0.05


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ("joystick.pivot=[0.5, 0]", "joystick.pivot is .*; give 3 numbers from -2 to 2, in m"),
        ("joystick.pivot=[0.5, 0, .inf]", "joystick.pivot is .*; give 3 numbers from -2 to 2, in m"),
        ("joystick.offset=[0.01]", "joystick.offset is .*; give 2 numbers from -2 to 2, in m"),
        ("joystick.yaw_deg=.nan", "joystick.yaw_deg is nan; give a number from -360 to 360, in deg"),
    ],
)
def test_places_that_are_none_are_refused(setting: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        game(setting)


def test_other_fingers_hold_the_stick_beside_where_the_hand_is() -> None:
    """By contact alone; what is declared is their length, so that the stick is as high as ever, and 9 mm aside."""
    count = 25

    def stick(scenario: JoystickGame) -> tuple[np.ndarray, np.ndarray]:
        table = scenario.record_play(count).table
        return table[["joystick.x_axis", "joystick.y_axis"]].to_numpy(), table["hand->joystick"].to_numpy()

    usual, _ = stick(game("noise.scale=0", physics="ideal"))
    other, held = stick(game("noise.scale=0", LONG_FINGERS, physics="contact"))
    assert (held[1:] > 0.5).all()
    off = np.arctanh(np.clip(other[3:], -0.98, 0.98)) - np.arctanh(np.clip(usual[3:], -0.98, 0.98))
    assert abs(np.median(off[:, 0])) > 0.12  # they close off the middle along x
    assert abs(np.median(off[:, 1])) < 0.06


def test_other_fingers_are_joined_to_nothing() -> None:
    scenario = game(LONG_FINGERS, physics="contact")
    world = scenario.build_world(scenario.idle_state(), [0.0, 0.0], 0)
    plant = world.robot.plant  # type: ignore[union-attr]
    assert plant.num_constraints() == 1  # the mimic
    fingers = [plant.get_joint(JointIndex(j)).name() for j in range(plant.num_joints())]
    assert {"finger_left", "finger_right"} <= set(fingers)
