"""Following one path: by a learned controller, or by the oracle for comparison."""

from __future__ import annotations

import numpy as np

from ichain_drake.control.tracking.arrival import Arrival
from ichain_drake.control.tracking.chain import ChainController
from ichain_drake.control.tracking.path import TimedPath, paper_path_error, path_error
from ichain_drake.control.tracking.systems import Controller, PathController
from ichain_drake.errors import InputError
from ichain_drake.learning.chain.chain import LearnedChain
from ichain_drake.runs.paths.oracle import OraclePolicy
from ichain_drake.runs.paths.result import PathResult
from ichain_drake.scenarios.base import PathScenario
from ichain_drake.simulation.episode import EpisodeLog, follow_path
from ichain_drake.simulation.wiring import path_controller
from ichain_drake.timing import TICK
from ichain_drake.world.world import World


def follow(
    scenario: PathScenario,
    chain: LearnedChain,
    controller: ChainController,
    name: str,
    path: TimedPath,
    number: int,
    world: World | None = None,
) -> PathResult:
    """Follow one path with a learned controller.

    Args:
        scenario: makes the world.
        chain: the learned chain; its objects' `measured` are read.
        controller: decides.
        name: of the path.
        path: the timed path.
        number: of the run; keys its noise.
        world: to follow it in; by default one of the scenario's, at the start of the path.
    """
    world = scenario.make_world(path, number) if world is None else world
    log, arrival = follow_path(world, path_controller(chain, controller, path))
    return measure_result(scenario, name, path, log, arrival, number)


def oracle_follow(scenario: PathScenario, name: str, path: TimedPath, number: int) -> PathResult:
    """Follow one path with the oracle: the true model, the true states, the same noise."""
    world = scenario.make_world(path, number)
    log, arrival = follow_path(world, oracle_controller(scenario, world, path), truth=oracle_truth(scenario))
    return measure_result(scenario, name, path, log, arrival, number)


def oracle_truth(scenario: PathScenario) -> tuple[str, ...]:
    """The objects of which the oracle reads the true states: all but the hand."""
    return tuple(scenario.graph.chain(scenario.target)[1:])


def oracle_controller(scenario: PathScenario, world: World, path: TimedPath) -> PathController:
    """The system that follows a path with the true model of a world.

    Raises:
        InputError: if its hand has hidden variables.
    """
    graph = scenario.graph
    names = graph.chain(scenario.target)
    hand = graph.objects[names[0]]
    targets = [graph.objects[scenario.target].index(v) for v in scenario.target_variables]
    chart = scenario.command_chart()
    policy = OraclePolicy(
        graph,
        world.objects,
        scenario.target,
        targets,
        path.limits.speed * TICK,
        *scenario.command_range(),
        scenario.oracle_weights,
        chart,
    )
    spaces = {n: graph.objects[n] for n in names}
    middle = np.mean(scenario.command_range(), axis=0)
    middle = middle if chart is None else chart.to_hand(middle)
    decides = Controller(policy, spaces, 2, middle, policy.sizes)  # type: ignore[arg-type]
    space = graph.objects[scenario.target].observable
    if len(hand) != policy.sizes[0]:
        raise InputError("the oracle needs a hand without hidden variables")
    return PathController(decides, path, scenario.target, space, scenario.target_indices())


def measure_result(
    scenario: PathScenario, name: str, path: TimedPath, log: EpisodeLog, arrival: Arrival | None, number: int
) -> PathResult:
    """How near to its path an episode was.

    Args:
        scenario: whose target followed.
        name: of the path.
        path: the timed path.
        log: of the episode.
        arrival: whether the path was followed to its end; None for a run that was interrupted.
        number: of the run; keys which positions the paper's metric draws.
    """
    space = scenario.graph.objects[scenario.target]
    executed = log.states[scenario.target][:, [space.index(v) for v in scenario.target_variables]]
    ticks = np.arange(0.0, path.time[-1] + TICK, TICK)
    waypoints = path.at_time(np.minimum(ticks, path.time[-1]))
    rng = np.random.default_rng([scenario.seed, number, 77])
    return PathResult(
        name,
        path,
        log,
        arrival is not None and arrival.arrived,
        path_error(executed, path),
        paper_path_error(executed, waypoints, rng),
        reason="interrupted" if arrival is None else arrival.reason(scenario.unit, float(log.times[-1])),
    )
