"""Algorithm 1 of the paper (appendix A): feedback control of the last object of a chain, of any length."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ichain_drake.control.tracking.levels import Level, plan_step
from ichain_drake.errors import InputError
from ichain_drake.graph import Origin
from ichain_drake.learning.frozen import FrozenModel
from ichain_drake.state import FloatArray, StateSpace


@dataclass(frozen=True)
class RobotLevel:
    """The root of the chain: sends the hand command that brings the hand to a wanted state.

    Attributes:
        space: the hand's observable state space.
        limit: largest change of each variable in one tick, shape (n_hand,).
        command: learned map from a wanted hand state to the command that reaches it; None to command it as it is.
        lower, upper: range of the commands in the demonstrations, shape (n_hand,).
        origin: what positions are relative to in `command`; None for the frame's own.
    """

    space: StateSpace
    limit: FloatArray
    command: FrozenModel | None
    lower: FloatArray
    upper: FloatArray
    origin: Origin | None = None

    @cached_property
    def _offset(self) -> FloatArray | float:
        offset = None if self.origin is None else self.origin.offset(self.space)
        return 0.0 if offset is None else offset

    def decide(self, hand: FloatArray, wanted: FloatArray) -> FloatArray:
        """Commands, shape (n, n_hand), from measured and wanted hand states of the same shape."""
        waypoint = plan_step(self.space, hand, wanted, self.limit, 1)
        if self.command is not None:
            waypoint = waypoint - self._offset
            waypoint = self.command.batch(waypoint) if len(waypoint) > 1 else self.command.value(waypoint[0])[None]
            waypoint = waypoint + self._offset
        return np.clip(waypoint, self.lower, self.upper)


@dataclass(frozen=True)
class MoveTo:
    """`move_to` for a chain: recursive inversion with path planning at each level.

    From the last object down: plan a path to the wanted state, find the parent's state that makes the next step, and
    hand that down as the parent's wanted state; the robot sends the hand command. Called once a tick, it starts over
    from what is measured, which is what makes it feedback.

    Attributes:
        levels: one per interaction, the robot's first.
        robot: the root.
    """

    levels: Sequence[Level]
    robot: RobotLevel

    @property
    def memory_size(self) -> int:
        """Length of what the levels keep from tick to tick."""
        return sum(level.memory_size for level in self.levels)

    @property
    def lookahead(self) -> int:
        """Ticks of wanted states of the last object that are read."""
        return self.levels[-1].lookahead if self.levels else 1

    def decide(
        self, states: Sequence[FloatArray], wanted: FloatArray, memory: FloatArray
    ) -> tuple[FloatArray, FloatArray, list[FloatArray]]:
        """One tick.

        Args:
            states: measured state of the robot and of each object along the chain, shape (n, n_variables) each.
            wanted: wanted values of the last object's target variables in the coming ticks, shape (n, k, n_targets).
            memory: shape (n, memory_size); zeros at the start.

        Returns:
            Hand commands (n, n_hand), the new memory, and for each object but the last the state wanted of it in
            the next tick, robot first.

        Raises:
            InputError: if the number of states does not fit the chain.
        """
        if len(states) != len(self.levels) + 1:
            raise InputError(f"{len(states)} states given for a chain of {len(self.levels) + 1} objects")
        ends = np.cumsum([0, *(level.memory_size for level in self.levels)])
        kept: list[FloatArray] = [memory[:, a:b] for a, b in zip(ends[:-1], ends[1:], strict=True)]
        handed_down: list[FloatArray] = []
        for i in reversed(range(len(self.levels))):
            wanted, kept[i] = self.levels[i].decide(states[i + 1], states[i], wanted, kept[i])
            handed_down.insert(0, wanted[:, 0])
        command = self.robot.decide(states[0], wanted[:, 0])
        return command, np.concatenate([np.zeros((len(command), 0)), *kept], axis=1), handed_down
