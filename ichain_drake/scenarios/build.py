"""A scenario's world alone, for a user's own diagram and Simulator."""

from __future__ import annotations

from pydrake.systems.framework import DiagramBuilder

from ichain_drake.control.tracking.path import TimedPath
from ichain_drake.scenarios.base import Scenario
from ichain_drake.world.world import World


def build_world(scenario: Scenario, *, path: str | TimedPath = "", run: int = 0) -> World:
    """A scenario's world; its default context is the start of a run.

    The caller connects or fixes the input `hand_command`, and simulates; no controller and no log is inside. Other
    ports are those of `World`.

    Args:
        scenario: see `load_scenario`.
        path: the path that the last object starts on, or the name of a reference path; default the scenario's first.
            Only for a scenario that follows paths.
        run: number of the run; keys the world's noise, and its start.

    Raises:
        InputError: on an unknown path, or a scenario that has neither paths nor a goal.
    """
    return scenario.start_world(path, run)


def AddWorld(  # noqa: N802 - named as Drake names what adds systems to a builder
    builder: DiagramBuilder, scenario: Scenario, path: str | TimedPath = "", *, run: int = 0
) -> World:
    """Add a scenario's world to a diagram: built, its default context is the start of a run.

    Args:
        builder: of the diagram.
        scenario, path, run: as for `build_world`.

    Returns:
        The world. `AddController` adds what drives it.

    Raises:
        InputError: as `build_world`.
    """
    world: World = builder.AddSystem(build_world(scenario, path=path, run=run))
    return world
