"""A slider for what a goal asks for, in a live run towards a goal over an interaction graph."""

from __future__ import annotations

from dataclasses import replace

from ichain_drake.scenarios.adjustable import Adjustable
from ichain_drake.simulation.episode import Episode
from ichain_drake.simulation.goal_episode import GraphEpisode


def least_wanted(obj: str, variable: str, lower: float, upper: float, value: float) -> Adjustable:
    """The least value that a goal wants of a variable: the target of a goal scenario.

    The running plan goes on; where it ends, the goal in force is compared, and planned for anew if it does not hold.

    Args:
        obj, variable: which the goal has a condition for; without one the slider does nothing.
        lower, upper: its range, in the variable's unit.
        value: at the start.
    """

    def apply(episode: Episode, value: float) -> None:
        if not isinstance(episode, GraphEpisode):
            return  # a demonstration
        executor = episode.controller.executor
        changed = tuple(
            replace(c, lower=value) if (c.object, c.variable) == (obj, variable) and c.lower > -float("inf") else c
            for c in executor.goal.conditions
        )
        executor.goal = replace(executor.goal, conditions=changed)

    return Adjustable(f"{obj}.{variable} >=", lower, upper, (upper - lower) / 20, value, apply)
