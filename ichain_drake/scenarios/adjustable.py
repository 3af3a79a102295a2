"""What a scenario lets a person change while it runs live."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ichain_drake.simulation.episode import Episode


@dataclass(frozen=True)
class Adjustable:
    """A slider on the page of a live run.

    Attributes:
        name: its label, with the unit.
        lower, upper, step: its range.
        value: at the start.
        apply: brings a value into force in an episode.
        at_once: whether it acts once and springs back to `value`, such as a push; else it stays in force, in later
            episodes too.
    """

    name: str
    lower: float
    upper: float
    step: float
    value: float
    apply: Callable[[Episode, float], None]
    at_once: bool = False


def noise_scale(value: float) -> Adjustable:
    """The factor on objects' process and measurement noise; `value` is the configured one."""

    def apply(episode: Episode, value: float) -> None:
        for system in episode.world.objects.values():
            system.settings = replace(system.settings, noise_scale=value)

    return Adjustable("noise scale", 0.0, max(5.0, 2 * value), 0.1, value, apply)


def push(obj: str, variable: str, unit: str, reach: float) -> Adjustable:
    """A shove that displaces an object along one of its variables.

    Args:
        obj: the object; no plant may hold it.
        variable: of its state.
        unit: of the variable.
        reach: largest displacement, in the unit.
    """

    def apply(episode: Episode, value: float) -> None:
        system = episode.world.objects[obj]
        context = system.GetMyMutableContextFromRoot(episode.context)
        state = system.get_state(context)
        state[system.state_space.index(variable)] += value
        system.set_state(context, state)

    return Adjustable(f"push {obj} {variable} [{unit}]", -reach, reach, reach / 20, 0.0, apply, at_once=True)


def path_shift(axis: int, variable: str, unit: str, reach: float) -> Adjustable:
    """Moves the path that is followed: the target of a path scenario.

    Args:
        axis: 0 or 1, of the path's plane.
        variable: its name.
        unit: of the plane.
        reach: farthest, in the unit.
    """

    def apply(episode: Episode, value: float) -> None:
        follower, path = episode.follower, episode.path
        if follower is None or path is None:
            return
        offset = follower.path.points[0] - path.points[0]
        offset[axis] = value
        follower.path = path.shifted(np.asarray(offset))

    return Adjustable(f"shift target {variable} [{unit}]", -reach, reach, reach / 20, 0.0, apply)
