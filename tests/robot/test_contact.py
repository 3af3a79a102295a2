"""The joystick in the grip, by contact alone."""

from pathlib import Path

import numpy as np
import pytest
from joystick_scene import STICK, Runner, joystick_spec, knob_position, tilt_targets
from pydrake.common.schema import Transform
from pydrake.multibody.parsing import LoadModelDirectivesFromString, ModelDirective

from ichain_drake.robot import BodySpec, HandSpec, RobotSpec


def test_the_stick_follows_the_hand_and_the_fingers_keep_it() -> None:
    targets = tilt_targets(24, seed=0)
    runner = Runner(joystick_spec(), knob_position(targets), "contact", {"stick": STICK})
    assert runner.read("stick_touch") == pytest.approx(0.0, abs=1.0)  # fingers just touch at the start
    errors, hand = [], []
    for tick in range(24):
        runner.frame(10 * tick + 10)
        errors.append(np.degrees(runner.read("stick_body")[:2] - targets[tick]))
        hand.append(np.linalg.norm(runner.read("state") - runner.read("setpoint")[:2]))
    errors = np.array(errors)
    # Measured over 100 s (300 ticks): mean 0.05, max 0.19 deg, and 0.03 deg rms about a linear map.
    assert np.abs(errors).max() < 0.4
    design = np.c_[np.ones(24), np.degrees(targets)]
    residual = errors - design @ np.linalg.lstsq(design, errors, rcond=None)[0]
    assert np.sqrt((residual**2).mean()) < 0.1
    assert max(hand) < 0.0005
    assert runner.read("stick_touch") > 20.0


def test_nothing_joins_gripper_and_stick_but_contact() -> None:
    plant = Runner(joystick_spec(), knob_position(np.zeros((1, 2))), "contact", {"stick": STICK}).robot.plant
    assert plant.num_constraints() == 1
    joints = [plant.get_joint(j) for j in plant.GetJointIndices()]
    for joint in joints:
        owners = {
            plant.GetModelInstanceName(joint.parent_body().model_instance()),
            plant.GetModelInstanceName(joint.child_body().model_instance()),
        }
        assert not {"gripper", "stick"} <= owners
        assert not {"arm", "stick"} <= owners
    # Beyond gravity, the only force elements are the stick's own two springs.
    assert plant.num_force_elements() == 3
    assert not plant.get_applied_generalized_force_input_port().HasValue(plant.CreateDefaultContext())


def test_opening_the_gripper_lets_the_stick_spring_back() -> None:
    x, y = knob_position(np.radians([20.0, 0.0]))
    commands = np.array([[x, y, 1.0], [x, y, 1.0], [x, y, 0.0]])
    runner = Runner(joystick_spec(("x", "y", "grip")), commands, "contact", {"stick": STICK})
    runner.frame(20)
    assert np.degrees(runner.read("stick_body")[0]) == pytest.approx(20.0, abs=0.5)
    assert runner.read("state")[2] == 1
    runner.frame(45)
    assert runner.read("state")[2] == 0
    runner.frame(60)
    assert abs(np.degrees(runner.read("stick_body")[0])) < 2.0
    assert runner.read("stick_touch") == 0
    np.testing.assert_allclose(runner.read("state")[:2], [x, y], atol=1e-3)


def test_two_runs_are_the_same() -> None:
    def run() -> np.ndarray:
        table = knob_position(tilt_targets(5, seed=3))
        runner = Runner(joystick_spec(), table, "contact", {"stick": STICK})
        runner.frame(50)
        return np.r_[runner.read("plant_positions"), runner.read("stick_touch")]

    np.testing.assert_array_equal(run(), run())


def test_a_free_body_starts_where_declared_and_stands_on_the_scenery(tmp_path: Path) -> None:
    block = tmp_path / "block.urdf"
    block.write_text(
        '<robot name="b"><link name="block">'
        '<inertial><mass value="0.1"/><inertia ixx="1e-4" ixy="0" ixz="0" iyy="1e-4" iyz="0" izz="1e-4"/></inertial>'
        '<collision><geometry><box size="0.04 0.04 0.04"/></geometry></collision></link></robot>'
    )
    spec = RobotSpec(hand=HandSpec(["x", "y", "z"]))
    spec.scenery = _table()
    bodies = {"block": BodySpec(str(block), Transform(translation=[0.45, 0.2, 0.03]), fixed=False)}
    runner = Runner(spec, np.array([[0.45, 0.0, 0.25]]), "contact", bodies)
    assert runner.robot.body_size("block") == 13
    np.testing.assert_allclose(runner.read("block_body")[4:7], [0.45, 0.2, 0.03])
    runner.frame(30)
    np.testing.assert_allclose(runner.read("block_body")[4:7], [0.45, 0.2, 0.02], atol=2e-3)
    assert runner.read("block_touch") == 0


def test_closed_fingers_with_nothing_between_them_shut() -> None:
    runner = Runner(RobotSpec(hand=HandSpec(["x", "y", "z", "grip"])), np.array([[0.45, 0, 0.25, 1]]), "arm")
    assert runner.read("plant_positions")[-1] == pytest.approx(0.04)
    runner.robot.set_hand(runner.root, [0.45, 0, 0.25, 0, 0, 0, 1])
    np.testing.assert_allclose(runner.read("plant_positions")[-2:], 0.0, atol=1e-9)


def _table() -> list[ModelDirective]:
    return LoadModelDirectivesFromString("""
directives:
- add_model: {name: table, file: "package://ichain_drake_models/table/table.urdf"}
- add_weld: {parent: world, child: "table::top", X_PC: {translation: [0.45, 0, 0]}}
""").directives
