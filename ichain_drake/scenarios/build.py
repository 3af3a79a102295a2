"""A scenario's world alone, for a user's own diagram and Simulator."""

from __future__ import annotations

import copy
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from ichain_drake.control.tracking.path import TimedPath
from ichain_drake.errors import InputError
from ichain_drake.robot import HAND
from ichain_drake.robot.arm import ArmRobot
from ichain_drake.scenarios.base import PathScenario, Scenario
from ichain_drake.scenarios.environment_scenario import EnvironmentScenario
from ichain_drake.scenarios.graph_scenario import GraphScenario
from ichain_drake.simulation.episode import Prepare
from ichain_drake.world.world import World


def build_world(
    scenario: Scenario,
    *,
    path: str = "",
    run: int = 0,
) -> World:
    """Build a scenario's world so that its default context is the start of a run.

    The caller connects or fixes the input `hand_command`, and simulates; no controller and no log is inside. Other
    ports are those of `World`.

    Args:
        scenario: see `load_scenario`; it is left as it was.
        path: name of the reference path that the last object starts on; default the scenario's first. Only for a
            scenario that follows paths.
        run: number of the run; keys the world's noise.

    Returns:
        The world as a Drake Diagram.

    Raises:
        InputError: on an unknown path, or a scenario that is neither a `PathScenario` nor a `GraphScenario`.
    """
    make = _maker(scenario, path, run)
    world, prepare = make(scenario)
    if isinstance(scenario, EnvironmentScenario):
        return world  # it begins at its start
    context = world.CreateDefaultContext()
    prepare(context)
    robot = world.robot.GetMyContextFromRoot(context)
    hand = world.robot.GetOutputPort("setpoint").Eval(robot)

    # A context that was prepared is lost when the caller puts the world into a diagram of its own. So the same world
    # is built once more with the start of the run as its robot's home, which default contexts begin at.
    started = copy.copy(scenario)
    home = dict(zip(HAND.names, (float(v) for v in hand), strict=True))
    started.config = replace(scenario.config, robot=replace(scenario.config.robot, home=home))
    again, _ = make(started)
    if isinstance(again.robot, ArmRobot):
        # The fingers too: closed until they touch what they hold.
        again.robot.plant.SetDefaultPositions(world.robot.GetOutputPort("plant_positions").Eval(robot))
    return again


def _maker(scenario: Scenario, path: str, run: int) -> Callable[[Any], tuple[World, Prepare]]:
    """What makes the world of a run, and puts it in its start state, for a scenario of this kind."""
    if isinstance(scenario, GraphScenario):
        if path:
            raise InputError(f"{scenario.name} has no paths; leave path {path!r} out")
        return lambda s: s.make_world(run)
    if not isinstance(scenario, PathScenario):
        raise InputError(f"{scenario.name} has neither paths nor a goal; build its world from its graph and objects")
    paths = scenario.reference_paths()
    name = path or next(iter(paths))
    if name not in paths:
        raise InputError(f"{scenario.name} has no path {name!r}; it has {', '.join(paths)}")
    timed = TimedPath(paths[name], scenario.path_limits())
    return lambda s: s.make_world(timed, run)
