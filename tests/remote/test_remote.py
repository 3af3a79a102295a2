"""A robot in a process of its own, and who commands it: readings, commands, losses, and what ends without the other."""

import os
import random
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource

from ichain_drake import load_scenario
from ichain_drake.remote import RemoteWorld, connect, link
from ichain_drake.remote.link import RobotLostError
from ichain_drake.timing import FRAME, TICK

PACE = 4.0
SCENARIO = load_scenario("car_game", physics="ideal", seed=3)


def address() -> str:
    return f"lcm://239.255.76.67:{random.SystemRandom().randrange(20000, 60000)}"


class Robot:
    """`ichain robot` in a process of its own."""

    def __init__(self, *options: str) -> None:
        self.address = address()
        command = [sys.executable, "-m", "ichain_drake", "robot", "car_game", "--physics", "ideal", "--seed", "3"]
        self.process = subprocess.Popen(
            [*command, "--paths", "eight", "--address", self.address, "--pace", str(PACE), *options],
            stdout=subprocess.PIPE, text=True,
        )  # fmt: skip
        assert "waiting for commands" in self.line()

    def line(self) -> str:
        assert self.process.stdout is not None
        return self.process.stdout.readline()


@pytest.fixture
def robot(request: pytest.FixtureRequest) -> Iterator[Robot]:
    running = Robot(*getattr(request, "param", ()))
    yield running
    running.process.kill()
    running.process.communicate()


def run(world: RemoteWorld, command: np.ndarray, ticks: int) -> dict[str, np.ndarray]:
    """Hold a command for so many ticks; what is read of the hand at the end, and the true car at both ends."""
    builder = DiagramBuilder()
    builder.AddSystem(world)
    source = builder.AddSystem(ConstantVectorSource(command))
    builder.Connect(source.get_output_port(), world.GetInputPort("hand_command"))
    simulator = Simulator(builder.Build())
    simulator.Initialize()
    context = world.GetMyContextFromRoot(simulator.get_context())
    start = world.GetOutputPort("car.state").Eval(context).copy()
    simulator.AdvanceTo(ticks * TICK)
    return {"start": start, "car": world.GetOutputPort("car.state").Eval(context).copy(),
            "hand": world.GetOutputPort("hand.measured").Eval(context).copy(),
            "valid": world.GetOutputPort("hand.valid").Eval(context).copy(),
            "delay": world.GetOutputPort("delay").Eval(context).copy()}  # fmt: skip


def place() -> np.ndarray:
    low, high = SCENARIO.command_range()
    return (low + high) / 2 + 0.1 * (high - low)


@pytest.mark.parametrize("robot", [(), ("--lost", "0.1", "--late", "100")], indirect=True)
def test_a_command_over_the_line_moves_the_hand(robot: Robot) -> None:
    world = connect(robot.address, SCENARIO.graph)
    got = run(world, place(), 12)
    np.testing.assert_allclose(got["hand"], place(), atol=0.02)
    assert np.linalg.norm(got["car"][:2] - got["start"][:2]) > 20.0
    assert "commanded" in robot.line()
    report = world.report()
    assert report["median_round_trip_ms"] > 0
    assert got["delay"][0] * 10 >= report["lead_frames"] - 1e-9
    if "--late" in robot.process.args:  # type: ignore[operator]
        assert report["lead_frames"] >= 10
        assert report["lost_frames"] > 0
    else:
        assert report["lead_frames"] <= 3  # 0 on a machine that isn't busy


def test_the_hand_stays_where_it_was_sent_when_nobody_commands(robot: Robot) -> None:
    run(connect(robot.address, SCENARIO.graph), place(), 3)
    heard = robot.line()
    assert "commanded" in heard
    assert "nobody commands any more" in robot.line()
    watched = link.RobotLink(robot.address, SCENARIO.graph)
    hand = [watched.at(k * FRAME)[0][:2] for k in range(20)]
    assert np.ptp(np.array(hand), axis=0).max() < 0.02  # no more than its readings' noise
    np.testing.assert_allclose(np.mean(hand, axis=0), place(), atol=0.01)


def test_a_run_ends_with_one_line_when_the_robot_falls_silent(robot: Robot, monkeypatch: pytest.MonkeyPatch) -> None:
    world = connect(robot.address, SCENARIO.graph)
    os.kill(robot.process.pid, signal.SIGKILL)
    monkeypatch.setattr(link, "_PATIENCE", 0.3)
    began = time.monotonic()
    with pytest.raises(RobotLostError, match=re.escape(f"{robot.address}: the robot has been silent for 0.3 s")):
        run(world, place(), 60)
    assert time.monotonic() - began < 15


def test_a_robot_of_another_system_is_refused(robot: Robot) -> None:
    other = load_scenario("driving", physics="ideal")
    with pytest.raises(RobotLostError, match=r"the robot there is of another system: it says nothing of "):
        connect(robot.address, other.graph)


def test_nobody_there_is_said_with_what_to_start(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(link, "_PATIENCE", 0.2)
    with pytest.raises(RobotLostError, match="no robot speaks there; first start `ichain robot SYSTEM`"):
        connect(address(), SCENARIO.graph)
