"""Many runs along one path, in `ideal` physics calculated together, elsewhere one by one, and equal to the bit."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence

import numpy as np

from ichain_drake.control.tracking.chain import ChainController
from ichain_drake.control.tracking.path import TimedPath
from ichain_drake.control.tracking.systems import PathController
from ichain_drake.errors import InputError
from ichain_drake.learning.chain.chain import LearnedChain
from ichain_drake.objects.rows import NotTogetherError
from ichain_drake.runs.paths.following import (
    follow,
    measure_result,
    oracle_controller,
    oracle_follow,
    oracle_truth,
)
from ichain_drake.runs.paths.result import PathResult
from ichain_drake.scenarios.base import PathScenario
from ichain_drake.simulation.together import follow_path_together
from ichain_drake.simulation.watching import present_watcher
from ichain_drake.simulation.wiring import path_controller
from ichain_drake.world.world import World

Found = PathResult | Exception
"""A run, or what it raised."""

_FEW = 4
"""Fewer runs take as long together as one after another; one of them is run alone in any case."""
_CHECKED = 1
"""Which: not the first, whose row is the first of a matrix product, as that of a run alone is."""


def follow_many(
    scenarios: Sequence[PathScenario],
    chain: LearnedChain,
    controller: ChainController,
    name: str,
    path: TimedPath,
    number: int,
) -> list[Found]:
    """`follow` for scenarios that differ in their seeds alone; other arguments as there.

    Returns:
        One a scenario. Logs of runs that were calculated together have true states and commands alone.
    """
    return _many(
        scenarios, name, path, number,
        alone=lambda scenario: follow(scenario, chain, controller, name, path, number),
        commander=lambda world: path_controller(chain, controller, path),
    )  # fmt: skip


def oracle_follow_many(scenarios: Sequence[PathScenario], name: str, path: TimedPath, number: int) -> list[Found]:
    """`oracle_follow` for scenarios that differ in their seeds alone; see `follow_many`."""
    return _many(
        scenarios, name, path, number,
        alone=lambda scenario: oracle_follow(scenario, name, path, number),
        commander=lambda world: oracle_controller(scenarios[0], world, path),
        truth=oracle_truth(scenarios[0]),
    )  # fmt: skip


def _many(
    scenarios: Sequence[PathScenario],
    name: str,
    path: TimedPath,
    number: int,
    alone: Callable[[PathScenario], PathResult],
    commander: Callable[[World], PathController],
    truth: tuple[str, ...] = (),
) -> list[Found]:
    first, known = scenarios[0], dict[int, Found]()
    if len(scenarios) >= _FEW and first.physics == "ideal" and present_watcher() is None:
        known[_CHECKED] = _tried(alone, scenarios[_CHECKED])
        try:
            worlds = [scenario.make_world(path, number) for scenario in scenarios]
            runs = follow_path_together(worlds, commander(worlds[0]), truth)
            together = [
                measure_result(scenario, name, path, log, arrival, number)
                for scenario, (log, arrival) in zip(scenarios, runs, strict=True)
            ]
        except (NotTogetherError, InputError):
            together = []
        except Exception as error:  # whatever it is, of a user's own object for instance: each run alone will show it
            together, why = [], f"{type(error).__name__}: {error}"
            warnings.warn(f"runs are calculated one by one: together they end in {why}", stacklevel=4)
        if together and _same(together[_CHECKED], known[_CHECKED]):
            known = {**dict(enumerate(together)), **known}
    return [known[k] if k in known else _tried(alone, scenario) for k, scenario in enumerate(scenarios)]


def _tried(alone: Callable[[PathScenario], PathResult], scenario: PathScenario) -> Found:
    try:
        return alone(scenario)
    except Exception as error:  # a finding about this run, and none about the others
        return error


def _same(together: PathResult, alone: Found) -> bool:
    """Whether a run that was calculated among others is, in every bit of every frame, what it is alone."""
    if isinstance(alone, Exception) or together.reason != alone.reason or together.completed != alone.completed:
        return False
    return np.array_equal(together.log.command, alone.log.command) and all(
        np.array_equal(states, alone.log.states[name]) for name, states in together.log.states.items()
    )
