"""The arm: tracking, another arm by its description, reach, and refused inputs."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from joystick_scene import STICK, Runner
from other_arm import OTHER, other_arm

from ichain_drake.errors import InputError, UnreachableError
from ichain_drake.robot import BodySpec, HandSpec, Physics, Posture, RobotSpec, build_robot, hand_pose
from ichain_drake.robot.kinematics import ArmKinematics
from ichain_drake.robot.plant import control_plant


def test_hand_is_at_the_setpoint_at_ticks_and_close_in_between() -> None:
    spec = RobotSpec(hand=HandSpec(["x", "y", "z", "yaw"]), home={"x": 0.45, "z": 0.25})
    generator = np.random.default_rng(2)
    commands = np.array([0.45, 0, 0.25, 0]) + generator.uniform(-1, 1, (12, 4)) * [0.015, 0.015, 0.015, 0.06]
    runner = Runner(spec, commands, "arm")
    for tick in range(12):
        for frame in range(1, 11):
            runner.frame(10 * tick + frame)
            error = np.linalg.norm(runner.read("state")[:3] - runner.read("setpoint")[:3])
            assert error < (0.0003 if frame == 10 else 0.003)
    np.testing.assert_allclose(runner.read("state"), commands[-1], atol=5e-4)


def test_fingers_close_at_their_speed_and_open_at_once() -> None:
    spec = RobotSpec(hand=HandSpec(["x", "y", "z", "grip"]), home={"x": 0.45, "z": 0.25}, gripper_speed=0.15)
    commands = np.array([[0.45, 0, 0.25, float(k < 2)] for k in range(4)])
    runner, widths = Runner(spec, commands, "arm"), []
    for frame in range(1, 41):
        runner.frame(frame)
        widths.append(runner.read("plant_positions")[-2:].copy())
    found = np.array(widths)
    np.testing.assert_allclose(np.diff(found[2:7], axis=0), -0.15 / 30, atol=2e-4)
    assert found[12].max() < 1e-3
    assert found[19].max() < 1e-3
    assert found[24].min() > 0.039


def test_another_arm_by_its_description_tracks_a_command() -> None:
    target = np.array([0.33, 0.0, 0.22, 0.2])
    runner = Runner(other_arm(), np.array([target]), "arm")
    runner.frame(30)
    np.testing.assert_allclose(runner.read("state"), target, atol=1e-3)


@pytest.mark.parametrize(
    "state",
    [
        (0.35, -0.1, 0.05, 0.5, 0, 0),
        (0.55, 0.1, 0.2, 0, 0, 0),
        (0.70, 0.0, 0.10, 0, np.pi / 2, 0),
        (0.50, -0.3, 0.3, -0.7, np.pi / 2, -1.9),
        (0.59, 0.0, 0.25, 0, 0.8, 0),
    ],
)
def test_solve_reaches_the_layouts(state: tuple) -> None:
    spec = RobotSpec()
    kinematics = ArmKinematics(control_plant(spec), spec)
    full = np.array([*state, 0.0])
    joints = kinematics.solve(full)
    assert (joints >= kinematics.lower).all()
    assert (joints <= kinematics.upper).all()
    error = kinematics.miss(joints, hand_pose(full))
    assert error.position < 1e-4
    assert error.angle < 1e-3


def test_steps_keep_the_joint_speed_limits() -> None:
    spec = RobotSpec()
    kinematics = ArmKinematics(control_plant(spec), spec)
    joints = kinematics.solve(np.array([0.45, 0, 0.25, 0, 0, 0, 0]))
    far = hand_pose([0.2, 0.4, 0.5, 1.0, 0.5, 0, 0])
    for _ in range(60):
        following = kinematics.step(joints, far, 1 / 60)
        assert (np.abs(following - joints) <= kinematics.speed / 60 + 1e-12).all()
        joints = following
    assert kinematics.miss(joints, far).position < 0.25


def test_a_hand_state_out_of_reach_says_how_close_it_came() -> None:
    runner = Runner(RobotSpec(hand=HandSpec(["x", "y", "z"])), np.array([[0.45, 0, 0.25]]), "arm")
    with pytest.raises(UnreachableError, match=r"comes within \d+ mm"):
        runner.robot.set_hand(runner.root, [0.89, 0.8, 0.2, 0, 0, 0, 0])
    with pytest.raises(UnreachableError, match="can't bring its hand"):
        build_robot(RobotSpec(home={"x": 0.9, "y": 0.9, "z": 0.1}), "arm")


def test_no_feedthrough_and_no_bodies_in_arm_physics() -> None:
    robot = build_robot(RobotSpec(), "arm", {"stick": STICK})
    assert not robot.HasOutputPort("stick_body")
    assert not robot.plant.HasModelInstanceNamed("stick")
    assert robot.GetOutputPort("plant_positions").size() == 9


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"kp": [1.0, 2.0]}, "robot.kp: 2 gains given, the arm has 7"),
        ({"gripper_speed": 0.0}, "robot.gripper_speed: 0.0 m/s; give a speed above 0"),
        ({"arm": "leg"}, "robot.arm: the model has no instance 'leg'"),
        ({"gripper": "claw"}, "robot.gripper: the model has no instance 'claw'"),
        ({"hand_frame": "nose"}, "has no frame 'nose'"),
        ({"plant_step": 0.01}, "robot.plant_step: 0.01 s"),
        ({"ik_rate": 50}, "robot.ik_rate: 50"),
        ({"ik_rate": 90}, "robot.ik_rate: 90"),
        ({"posture_weights": [1.0, 2.0]}, "robot.posture_weights: 2 values"),
        ({"postures": [Posture(0.0, [0.0] * 6)]}, "robot.postures: 6 values"),
        ({"gripper_closed": {}}, "robot.gripper_closed: no position for the driven joint finger_left"),
        ({"model": "nowhere.dmd.yaml"}, "robot.model: there is no model file"),
        ({"model": str(OTHER)}, "is not a directives file"),
    ],
)
@pytest.mark.parametrize("physics", ["arm", "ideal"])
def test_bad_robot_specs_name_the_key(change: dict, message: str, physics: Physics) -> None:
    with pytest.raises(InputError, match=message):
        build_robot(replace(RobotSpec(), **change), physics)


def test_a_point_can_start_where_an_arm_of_another_kind_can_not() -> None:
    assert build_robot(replace(RobotSpec(), home={"x": 5.0}, ik_rate=120), "ideal")


@pytest.mark.parametrize(
    ("name", "body", "message"),
    [
        ("cup", BodySpec("nowhere.urdf"), "body cup: there is no model file"),
        ("arm", BodySpec(STICK.file), "body arm: the plant already has"),
        ("stick", BodySpec(STICK.file, joints={"tilt_z": 1.0}), "body stick: its model has no joint 'tilt_z'"),
        ("robot", BodySpec("package://ichain_drake_models/robots/gen3_gripper.dmd.yaml"), "body robot: Model instance"),
    ],
)
def test_bad_bodies_are_named(name: str, body: BodySpec, message: str) -> None:
    with pytest.raises(InputError, match=message):
        build_robot(RobotSpec(), "contact", {name: body})


def test_a_body_is_one_model(tmp_path: Path) -> None:
    file = tmp_path / "two.dmd.yaml"
    file.write_text(
        f"directives:\n- add_model: {{name: a, file: {STICK.file}}}\n- add_model: {{name: b, file: {STICK.file}}}\n"
    )
    with pytest.raises(InputError, match="holds 2 models"):
        build_robot(RobotSpec(), "contact", {"sticks": BodySpec(str(file))})


@pytest.mark.parametrize("spec", [RobotSpec(), other_arm()])
def test_a_still_arm_does_not_stop_the_solver(spec: RobotSpec) -> None:
    home = spec.hand.reduce(spec.home_hand())
    runner = Runner(spec, np.array([home]), "arm")
    runner.frame(300)
    np.testing.assert_allclose(runner.read("state"), home, atol=1e-6)


def test_a_floating_arm_is_refused() -> None:
    spec = other_arm()
    spec.directives = [d for d in spec.directives if d.add_weld is None]
    with pytest.raises(InputError, match="isn't welded to the world"):
        build_robot(spec, "arm")
