"""Prints what the Python parts of ArmRobot cost: `python tests/robot/print_cost.py`.

The same plant (arm, gripper, joystick in the grip, scene graph, implicit controllers) is run twice over the same
motion: inside ArmRobot, and bare, with the recorded joint trajectory played back by Drake's own TrajectorySource.
"""

from __future__ import annotations

import time

import numpy as np
from joystick_scene import STICK, Commands, joystick_spec, knob_commands
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource, TrajectorySource
from pydrake.trajectories import PiecewisePolynomial

from ichain_drake.robot import ArmRobot, RobotSpec, build_robot
from ichain_drake.robot.plant import add_robot_plant
from ichain_drake.state import FloatArray

SECONDS = 20.0


def main() -> None:
    """Time both and print the ratio of processor times."""
    spec = joystick_spec()
    table = knob_commands(int(3 * SECONDS) + 1, seed=0)
    robot, simulator = _in_grip(spec, table)
    whole_plant = robot.plant.GetMyContextFromRoot(simulator.get_context())
    start = robot.plant.GetPositions(whole_plant).copy()
    whole = _processor_time(simulator)

    joints = _recorded_joints(spec, table)
    builder = DiagramBuilder()
    bare = add_robot_plant(builder, spec, {"stick": STICK})
    playback = builder.AddSystem(TrajectorySource(joints, 1, True))  # with its velocity
    closed = bare.finger_targets(spec.gripper_closed, "gripper_closed")
    fingers = builder.AddSystem(ConstantVectorSource([*closed, *(0.0 for _ in closed)]))
    builder.Connect(playback.get_output_port(), bare.plant.get_desired_state_input_port(bare.arm))
    builder.Connect(fingers.get_output_port(), bare.plant.get_desired_state_input_port(bare.gripper))
    diagram = builder.Build()
    simulator = Simulator(diagram)
    bare.plant.SetPositions(bare.plant.GetMyMutableContextFromRoot(simulator.get_mutable_context()), start)
    alone = _processor_time(simulator)
    print(f"ArmRobot {SECONDS / whole:.1f} x real time, bare plant {SECONDS / alone:.1f} x, ratio {whole / alone:.2f}")

    pose = robot.kinematics.pose(robot.kinematics.default)
    begin = time.process_time()
    joints = robot.kinematics.default.copy()
    for _ in range(2000):
        joints = robot.kinematics.step(joints, pose, 1 / 60)
    print(f"inverse kinematics {500 * (time.process_time() - begin):.0f} us a step")


def _in_grip(spec: RobotSpec, table: FloatArray) -> tuple[ArmRobot, Simulator]:
    robot = build_robot(spec, "contact", {"stick": STICK})
    assert isinstance(robot, ArmRobot)
    builder = DiagramBuilder()
    builder.AddSystem(robot)
    source = builder.AddSystem(Commands(table))
    builder.Connect(source.get_output_port(), robot.GetInputPort("hand_command"))
    simulator = Simulator(builder.Build())
    robot.set_hand(simulator.get_mutable_context(), spec.home_hand())
    return robot, simulator


def _processor_time(simulator: Simulator) -> float:
    simulator.Initialize()
    begin = time.process_time()
    simulator.AdvanceTo(SECONDS)
    return time.process_time() - begin


def _recorded_joints(spec: RobotSpec, table: FloatArray) -> PiecewisePolynomial:
    robot, simulator = _in_grip(spec, table)
    step = robot.plant.time_step()
    context = robot.ik.GetMyContextFromRoot(simulator.get_context())
    times = np.arange(round(SECONDS / step) + 1) * step
    desired = []
    for t in times:
        simulator.AdvanceTo(t)
        desired.append(robot.ik.GetOutputPort("desired").Eval(context)[: robot.kinematics.size])
    return PiecewisePolynomial.FirstOrderHold(times, np.array(desired).T)


if __name__ == "__main__":
    main()
