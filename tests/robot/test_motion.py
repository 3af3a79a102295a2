"""The tick: when the set-point moves, how far, how fast; in the ideal and the arm physics alike."""

import numpy as np
import pytest
from joystick_scene import Commands, Runner
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from ichain_drake.errors import InputError
from ichain_drake.robot import ArmRobot, HandSpec, IdealHand, RobotSpec, build_robot
from ichain_drake.timing import FRAME

HOME = {"x": 0.45, "y": 0.0, "z": 0.25}


def small_steps(count: int, seed: int = 0) -> np.ndarray:
    """Commands for x, y, z within 3 cm of home, shape (count, 3)."""
    return np.array([0.45, 0.0, 0.25]) + np.random.default_rng(seed).uniform(-0.015, 0.015, (count, 3))


def xyz_spec(**kwargs: object) -> RobotSpec:
    return RobotSpec(hand=HandSpec(["x", "y", "z"], **kwargs), home=HOME)


@pytest.mark.parametrize("physics", ["ideal", "arm"])
def test_a_command_stored_at_a_tick_moves_the_first_frame_after_it(physics: str) -> None:
    commands = small_steps(300)
    runner = Runner(xyz_spec(), commands, physics)
    before, hits = np.array([0.45, 0.0, 0.25]), 0
    ticks = 300 if physics == "ideal" else 30
    for k in range(ticks):
        runner.frame(10 * k + 1)
        first = runner.read("setpoint")[:3]
        runner.frame(10 * k + 4)
        hits += np.allclose(first, before + (commands[k] - before) / 4, atol=1e-12)
        np.testing.assert_array_equal(runner.read("setpoint")[:3], commands[k])
        before = commands[k]
        runner.frame(10 * k + 10)
        np.testing.assert_array_equal(runner.read("setpoint")[:3], commands[k])
    assert hits == ticks


def test_command_between_ticks_is_not_read() -> None:
    runner = Runner(xyz_spec(), np.array([[0.45, 0.0, 0.25], [0.46, 0.0, 0.25]]), "ideal")
    for frame in range(11):
        runner.frame(frame)
        assert runner.read("setpoint")[0] == 0.45
    runner.frame(11)
    assert runner.read("setpoint")[0] == pytest.approx(0.4525)


def test_long_moves_keep_to_the_speed_limits_over_several_ticks() -> None:
    spec = RobotSpec(hand=HandSpec(["x", "y", "z", "yaw", "grip"]), home=HOME)
    runner = Runner(spec, np.array([[0.45, 0.3, 0.25, 1.5, 1.0]]), "ideal")
    path = [runner.read("setpoint")]
    for frame in range(1, 41):
        runner.frame(frame)
        path.append(runner.read("setpoint"))
    path = np.array(path)
    speed = np.linalg.norm(np.diff(path[:, :3], axis=0), axis=1) / FRAME
    turn = np.abs(np.diff(path[:, 3])) / FRAME
    assert speed.max() == pytest.approx(0.3 * 30 / 23)
    assert turn.max() <= 2.0 + 1e-9
    # Least number of frames for 0.3 m at 0.4 m/s and 1.5 rad at 2 rad/s: 22.5, so 23.
    # (24: the last line, laid at frame 20, takes its least number of 4 frames)
    assert np.abs(path[23, :4] - path[-1, :4]).max() > 1e-3
    np.testing.assert_allclose(path[24:, :4], [[0.45, 0.3, 0.25, 1.5]] * 17, atol=1e-12)
    assert path[0, 6] == 0
    assert (path[1:, 6] == 1).all()  # the grip switches with the first frame


def test_angles_take_the_short_way() -> None:
    spec = RobotSpec(hand=HandSpec(["yaw"], {"x": 0.45, "y": 0, "z": 0.25}), home={"yaw": 3.1})
    runner = Runner(spec, np.array([[-3.1]]), "ideal")
    runner.frame(2)
    assert abs(runner.read("setpoint")[3]) == pytest.approx(3.1416, abs=1e-3)
    runner.frame(4)
    assert runner.read("setpoint")[3] == pytest.approx(-3.1)


def test_commands_are_clipped_to_the_bounds() -> None:
    runner = Runner(xyz_spec(bounds={"x": [0.4, 0.46]}), np.array([[0.6, 0.0, 0.25]]), "ideal")
    runner.frame(10)
    assert runner.read("state")[0] == pytest.approx(0.46)


def test_a_command_that_is_not_finite_is_refused() -> None:
    runner = Runner(xyz_spec(), np.array([[np.nan, 0.0, 0.25]]), "ideal")
    with pytest.raises(InputError, match="hand command: x is not a finite number"):
        runner.frame(1)


def test_noise_is_a_function_of_seed_and_frame() -> None:
    spec = xyz_spec(noise_std={"x": 0.002, "z": 0.001})

    def run(seed: int) -> np.ndarray:
        runner = Runner(spec, small_steps(1), "ideal", seed=seed)
        rows = []
        for frame in range(200):
            runner.frame(frame)
            rows.append(runner.read("measured") - runner.read("state"))
            assert runner.read("valid") == 1
        return np.array(rows)

    first = run(1)
    np.testing.assert_array_equal(first, run(1))
    assert np.abs(first - run(2)).max() > 1e-4
    np.testing.assert_array_equal(first[:, 1], 0)
    np.testing.assert_allclose(first.std(axis=0)[[0, 2]], [0.002, 0.001], rtol=0.2)


def test_set_hand_in_mid_run_starts_afresh_there() -> None:
    runner = Runner(xyz_spec(noise_std={"x": 0.002}), small_steps(20), "ideal")
    runner.frame(25)
    runner.robot.set_hand(runner.root, [0.44, 0.02, 0.26, 0, 0, 0, 0])
    np.testing.assert_allclose(runner.read("state"), [0.44, 0.02, 0.26])
    runner.frame(30)
    np.testing.assert_allclose(runner.read("state"), [0.44, 0.02, 0.26])
    runner.frame(34)
    np.testing.assert_array_equal(runner.read("state"), small_steps(20)[3])


@pytest.mark.parametrize("physics", ["ideal", "arm"])
def test_ports_are_the_same_and_states_have_no_feedthrough(physics: str) -> None:
    robot = build_robot(xyz_spec(), physics)
    assert isinstance(robot, IdealHand if physics == "ideal" else ArmRobot)
    assert robot.GetInputPort("hand_command").size() == 3
    sizes = {name: robot.GetOutputPort(name).size() for name in ("state", "measured", "valid", "setpoint")}
    assert sizes == {"state": 3, "measured": 3, "valid": 1, "setpoint": 7}
    for name in sizes:
        assert not robot.HasDirectFeedthrough(0, robot.GetOutputPort(name).get_index())


def test_unknown_physics() -> None:
    with pytest.raises(InputError, match="choose ideal, arm, contact"):
        build_robot(RobotSpec(), "magic")


def test_hand_state_of_wrong_shape() -> None:
    hand = IdealHand(HandSpec(), np.zeros(7))
    builder = DiagramBuilder()
    builder.AddSystem(hand)
    commands = builder.AddSystem(Commands(np.zeros(7)))
    builder.Connect(commands.get_output_port(), hand.get_input_port())
    simulator = Simulator(builder.Build())
    with pytest.raises(InputError, match="hand state: shape"):
        hand.set_hand(simulator.get_mutable_context(), [0.1, 0.2])
