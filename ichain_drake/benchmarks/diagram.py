"""What everything around the plant costs: the whole diagram against the bare plant in the same motion."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import Demultiplexer, TrajectorySource
from pydrake.trajectories import PiecewisePolynomial

from ichain_drake.benchmarks.measure import interleaved, processor_seconds
from ichain_drake.benchmarks.stopwatch import timed_callbacks
from ichain_drake.control.tracking.chain import ChainController
from ichain_drake.control.tracking.path import TimedPath
from ichain_drake.errors import InputError
from ichain_drake.learning.chain.chain import LearnedChain
from ichain_drake.robot.arm import ArmRobot
from ichain_drake.robot.plant import add_robot_plant
from ichain_drake.scenarios.base import PathScenario
from ichain_drake.simulation.episode import Episode
from ichain_drake.simulation.wiring import path_controller
from ichain_drake.timing import FRAME


def make_episode(
    scenario: PathScenario, chain: LearnedChain, controller: ChainController, path: TimedPath, *, log: bool
) -> Episode:
    """The whole diagram: world, controller and follower, at the start of a path."""
    return Episode(scenario.make_world(path, 0), path_controller(chain, controller, path), log=log)


class BarePlant:
    """The plant of a run, alone: same models, scene graph, contacts, gains and step.

    What the run's plant was given as desired state, step by step, is recorded and played back by Drake's
    `TrajectorySource`, so that the bare plant goes through the same states.

    Attributes:
        step: the plant's step [s].

    Args:
        episode: a run at its start; it is advanced.
        seconds: how long to record [s].

    Raises:
        InputError: if the episode's robot has no plant.
    """

    def __init__(self, episode: Episode, seconds: float) -> None:
        robot = episode.world.robot
        if not isinstance(robot, ArmRobot):
            raise InputError("the diagram benchmark needs a robot with a plant; use arm or contact physics")
        self._robot = robot
        self.step = robot.plant.time_step()
        context = robot.plant.GetMyContextFromRoot(episode.context)
        self._start = robot.plant.GetPositionsAndVelocities(context).copy()
        self._desired = _record(episode, robot, seconds)
        self._end = robot.plant.GetPositions(context).copy()

    def build(self) -> Simulator:
        """A simulator at the start of the same motion."""
        builder = DiagramBuilder()
        bare = add_robot_plant(builder, self._robot.spec, self._robot.bodies)
        source = builder.AddSystem(TrajectorySource(self._desired))
        sizes = [2 * self._robot.kinematics.size, 2 * len(bare.fingers)]
        parts = builder.AddSystem(Demultiplexer([s for s in sizes if s]))
        builder.Connect(source.get_output_port(), parts.get_input_port())
        builder.Connect(parts.get_output_port(0), bare.plant.get_desired_state_input_port(bare.arm))
        if bare.fingers:
            builder.Connect(parts.get_output_port(1), bare.plant.get_desired_state_input_port(bare.gripper))
        simulator = Simulator(builder.Build())
        self._plant = bare.plant
        context = bare.plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
        bare.plant.SetPositionsAndVelocities(context, self._start)
        simulator.Initialize()
        return simulator

    def difference(self, simulator: Simulator) -> float:
        """Largest difference of any joint to the recorded run at its end [rad or m]."""
        context = self._plant.GetMyContextFromRoot(simulator.get_context())
        return float(np.abs(self._plant.GetPositions(context) - self._end).max())


def _record(episode: Episode, robot: ArmRobot, seconds: float) -> PiecewisePolynomial:
    step, n = robot.plant.time_step(), robot.kinematics.size
    context = robot.playout.GetMyContextFromRoot(episode.context)
    rows = [robot.playout.played(context)]
    count = round(seconds / step)
    for k in range(count):
        episode.simulator.AdvanceTo((k + 1) * step)
        rows.append(robot.playout.played(context))
    played = np.array(rows)
    velocity = np.diff(played[:, :n], axis=0) / step
    fingers = played[1:, n:]
    desired = np.hstack([played[1:, :n], velocity, fingers, np.zeros_like(fingers)])
    # Breaks half a step early: each step reads its own row, whatever the rounding of its time.
    breaks = np.concatenate([[0.0], (np.arange(1, count) - 0.5) * step, [count * step]])
    return PiecewisePolynomial.ZeroOrderHold(breaks, np.vstack([desired, desired[-1:]]).T)


def benchmark_diagram(
    scenario: PathScenario,
    chain: LearnedChain,
    controllers: dict[str, ChainController],
    seconds: float,
    repeats: int,
) -> dict[str, Any]:
    """Cost of the whole diagram in units of the bare plant.

    Args:
        scenario: in a physics with a plant.
        chain: learned.
        controllers: by method; the first is measured with recording too, and gives the motion and the breakdown.
        seconds: simulated time of each run [s].
        repeats: rounds; medians are reported.

    Returns:
        Times in ms of processor time per simulated second, ratios, and the breakdown by system and by steps.
    """
    name, points = next(iter(scenario.reference_paths().items()))
    path = TimedPath(points, scenario.path_limits())
    first = next(iter(controllers))

    def whole(method: str, *, log: bool) -> float:
        episode = make_episode(scenario, chain, controllers[method], path, log=log)
        running = processor_seconds(lambda: episode.simulator.AdvanceTo(seconds))
        return running + (processor_seconds(episode.log) if log else 0.0)  # some of its rows are made when it is asked

    bare = BarePlant(make_episode(scenario, chain, controllers[first], path, log=False), seconds)

    def alone() -> float:
        simulator = bare.build()
        return processor_seconds(lambda: simulator.AdvanceTo(seconds))

    simulator = bare.build()
    simulator.AdvanceTo(seconds)
    difference = bare.difference(simulator)
    runs: dict[str, Callable[[], float]] = {
        "bare": alone,
        "whole": functools.partial(whole, first, log=False),
        "recorded": functools.partial(whole, first, log=True),
    }
    others = {m: functools.partial(whole, m, log=False) for m in controllers if m != first}
    times = interleaved(runs | others, repeats)

    def ratio(key: str) -> float:
        return float(np.median(np.array(times[key]) / np.array(times["bare"])))

    alone_ms = _per_second(times["bare"], seconds)
    return {
        "path": name,
        "method": first,
        "simulated_seconds": seconds,
        "plant_step": bare.step,
        "playback_difference": difference,
        "bare_ms": alone_ms,
        "whole_ms": _per_second(times["whole"], seconds),
        "recorded_ms": _per_second(times["recorded"], seconds),
        "bare_real_time_factor": 1000.0 / alone_ms,
        "ratio": ratio("whole"),
        "ratio_recorded": ratio("recorded"),
        "ratio_other_methods": {m: ratio(m) for m in others},
        "breakdown": _breakdown(scenario, chain, controllers[first], path, seconds, alone_ms),
        "steps_us": {
            "bare": _steps(bare.build(), bare.step, seconds),
            "whole": _steps(
                make_episode(scenario, chain, controllers[first], path, log=False).simulator, bare.step, seconds
            ),
        },
    }


def _steps(simulator: Simulator, step: float, seconds: float) -> list[float]:
    """Median processor time of the plant's steps, by their place in the frame [us].

    The first has what runs once a frame; what the others take longer than alone is Drake's own work for more systems.
    """
    ends = [(k + 1) * step for k in range(round(seconds / step))]
    times = [processor_seconds(functools.partial(simulator.AdvanceTo, end)) for end in ends]
    frame = round(FRAME / step)
    return [1e6 * float(np.median(times[place::frame])) for place in range(frame)]


def _per_second(times: list[float], seconds: float) -> float:
    return 1000.0 * float(np.median(times)) / seconds


def _breakdown(
    scenario: PathScenario,
    chain: LearnedChain,
    controller: ChainController,
    path: TimedPath,
    seconds: float,
    alone_ms: float,
) -> list[dict[str, Any]]:
    """One row a Python system, and one for the rest: the plant, slowed by cold caches, and Drake's own machinery."""
    with timed_callbacks() as watch:
        episode = make_episode(scenario, chain, controller, path, log=False)
    watch.reset()
    total = 1000.0 * processor_seconds(lambda: episode.simulator.AdvanceTo(seconds)) / seconds
    rows: list[dict[str, Any]] = [
        {
            "system": name,
            "calls_a_second": calls / seconds,
            "ms": 1000.0 * spent / seconds,
            "of_bare": 1000.0 * spent / seconds / alone_ms,
        }
        for name, (spent, calls) in watch.by_name().items()
    ]
    rest = total - sum(float(row["ms"]) for row in rows)
    rows.append({"system": "plant and C++", "calls_a_second": None, "ms": rest, "of_bare": rest / alone_ms})
    return rows
