"""The robot's way to a state of its own, laid out by whoever knows the robot, gone tick by tick."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from ichain_drake.control.planning.travel import jumping, step_towards
from ichain_drake.control.settings import PLANNING
from ichain_drake.motion_query import MotionQuery
from ichain_drake.state import FloatArray, StateSpace


class RobotMotion(Protocol):
    """How the robot gets somewhere without hitting anything; what it knows of itself and the scene is its own."""

    def path(self, query: MotionQuery) -> FloatArray:
        """Robot commands to a goal, one a tick, shape (n, n_root); the last is the goal.

        Raises:
            UnreachableError: if there is no way.
        """
        ...


@dataclass(eq=False)
class Course:
    """The way to one goal at a time; a goal that moves a little is followed without a new way.

    Attributes:
        goal: that the way leads to.
        rows: commands that are left.
        news: how much was known of what is in the way when it was laid out.
    """

    goal: FloatArray | None = None
    rows: list[FloatArray] = field(default_factory=list)
    news: int = 0

    def towards(
        self,
        space: StateSpace,
        now: FloatArray,
        goal: FloatArray,
        limit: FloatArray,
        motion: RobotMotion | None = None,
        held: str | None = None,
        standing: Callable[[], Mapping[str, FloatArray]] = dict,
        news: int = 0,
    ) -> tuple[FloatArray, bool]:
        """The command of a tick: along a straight line where there is no `motion`.

        Args:
            space: of the robot.
            now: last command, shape (n_root,).
            goal: shape (n_root,).
            limit: largest change in a tick, shape (n_root,).
            motion: lays out the way.
            held: see `MotionQuery`.
            standing: makes its `left`.
            news: how much is known of what is in the way; where it is more than it was, the way is laid out anew.

        Returns:
            The next command, and whether it is the goal.

        Raises:
            UnreachableError: if there is no way.
        """
        if motion is None:
            return step_towards(space, now, goal, limit)
        goal = space.clip(goal)
        if self.goal is None or not self.rows or news != self.news or self._moved(space, goal, limit):
            self.goal, self.news = goal, news
            self.rows = list(motion.path(MotionQuery(now, goal, held, standing())))
        self.rows[-1] = goal
        command = self.rows.pop(0)
        return np.array(command), not self.rows

    def _moved(self, space: StateSpace, goal: FloatArray, limit: FloatArray) -> bool:
        assert self.goal is not None
        jumps = jumping(space)
        way = np.abs(space.difference(goal, self.goal))
        return bool((way[jumps] > 0).any() or (way[~jumps] > PLANNING.push * np.maximum(limit[~jumps], 1e-9)).any())
