"""The plan of a frame, and how it reaches the plant."""

import numpy as np
import pytest
from joystick_scene import Runner
from pydrake.systems.analysis import Simulator

from ichain_drake.robot import HandSpec, RobotSpec, build_robot
from ichain_drake.robot.playout import Playout
from ichain_drake.timing import FRAME


@pytest.mark.parametrize("steps", [1, 2, 4])
def test_rows_are_played_from_the_first_step_on_and_the_last_one_stays(steps: int) -> None:
    step = 0.25
    start = np.array([1.0, 2.0, 0.5])
    playout = Playout(2, 1, steps, step, start)
    context = playout.CreateDefaultContext()
    rows = start + np.arange(1, steps + 2)[:, None] * np.array([0.1, -0.2, 0.01])
    quiet, port = np.zeros(rows.size), playout.get_input_port()
    last = start
    for k in range(steps + 2):
        port.FixValue(context, (rows - start).ravel() if k == 0 else quiet)
        expected = rows[min(k, steps)]
        output = playout.get_output_port().Eval(context)
        velocity = (expected - last)[:2] / step
        np.testing.assert_allclose(output, [*expected[:2], *velocity, expected[2], 0.0], atol=1e-12)
        context.SetDiscreteState(playout.EvalUniquePeriodicDiscreteUpdate(context).value().copy())
        np.testing.assert_allclose(playout.played(context), expected, atol=1e-14)
        last = expected


@pytest.mark.parametrize(("ik_rate", "plant_step"), [(30, 1 / 30), (60, 1 / 120), (120, 1 / 60), (240, 1 / 240)])
def test_the_hand_keeps_to_the_line_at_any_rates(ik_rate: int, plant_step: float) -> None:
    spec = RobotSpec(
        hand=HandSpec(["x", "y", "z"]), home={"x": 0.45, "z": 0.25}, ik_rate=ik_rate, plant_step=plant_step
    )
    runner = Runner(spec, np.array([[0.46, 0.01, 0.24]]), "arm")
    for frame in range(1, 11):
        runner.frame(frame)
        assert np.abs(runner.read("state") - runner.read("setpoint")[:3]).max() < 0.002
    np.testing.assert_allclose(runner.read("state"), [0.46, 0.01, 0.24], atol=3e-4)


@pytest.mark.parametrize("time", [25 * FRAME, 25.4 * FRAME])
def test_an_arm_put_elsewhere_in_mid_run_stays_there(time: float) -> None:
    commands = np.array([[0.45, 0.0, 0.25], [0.46, 0.01, 0.25], [0.45, 0.02, 0.25]])
    runner = Runner(RobotSpec(hand=HandSpec(["x", "y", "z"]), home={"x": 0.45, "z": 0.25}), commands, "arm")
    runner.simulator.AdvanceTo(time)
    runner.robot.set_hand(runner.root, [0.40, -0.05, 0.30, 0, 0, 0, 0])
    for frame in (26, 27, 29):
        runner.frame(frame)
        np.testing.assert_allclose(runner.read("state"), [0.40, -0.05, 0.30], atol=1e-5)


def test_a_run_goes_on_from_a_cloned_context_as_it_would_have() -> None:
    commands = np.array([0.45, 0.0, 0.25]) + np.random.default_rng(3).uniform(-0.015, 0.015, (6, 3))
    spec = RobotSpec(hand=HandSpec(["x", "y", "z"]), home={"x": 0.45, "z": 0.25})
    runner = Runner(spec, commands, "arm")
    runner.simulator.AdvanceTo(12.6 * FRAME)
    other = Simulator(runner.diagram, runner.root.Clone())
    for simulator in (runner.simulator, other):
        simulator.AdvanceTo(50 * FRAME)
    plant = runner.robot.plant
    ends = [plant.GetPositions(plant.GetMyContextFromRoot(s.get_context())) for s in (runner.simulator, other)]
    np.testing.assert_array_equal(*ends)


def test_a_tick_is_planned_when_it_begins_with_the_command_of_that_instant() -> None:
    spec = RobotSpec(hand=HandSpec(["x", "y", "z"]), home={"x": 0.45, "z": 0.25})
    robot = build_robot(spec, "arm")
    follow, calls = robot.kinematics.follow, []
    robot.kinematics.follow = lambda *args: calls.append(1) or follow(*args)
    context = robot.CreateDefaultContext()
    robot.GetInputPort("hand_command").FixValue(context, [0.46, 0.0, 0.25])
    simulator, counts = Simulator(robot, context), []
    for frame in range(1, 11):
        simulator.AdvanceTo((frame - 0.5) * FRAME)
        counts.append(len(calls))
    assert counts[0] >= 4
    assert counts == counts[:1] * 10
    setpoint = robot.GetOutputPort("setpoint").Eval(simulator.get_context())
    np.testing.assert_array_equal(setpoint[:3], [0.46, 0.0, 0.25])


def test_a_still_arm_rests() -> None:
    spec = RobotSpec(hand=HandSpec(["x", "y", "z"]), home={"x": 0.45, "z": 0.25})
    robot = build_robot(spec, "arm")
    follow, calls = robot.kinematics.follow, []
    robot.kinematics.follow = lambda *args: calls.append(1) or follow(*args)
    robot.GetInputPort("hand_command").FixValue(context := robot.CreateDefaultContext(), [0.46, 0.0, 0.25])
    Simulator(robot, context).AdvanceTo(20 * FRAME)
    assert 5 <= len(calls) <= 7  # four frames of motion, and one or two more at each tick
