"""Coordinates of the hand commands that make sense, where these are no box: for a hand that leads a knob round, say."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ichain_drake.robot.motion import LINEAR_SPEED, MOVE_FRAMES
from ichain_drake.state import FloatArray
from ichain_drake.timing import FRAME, FRAMES_PER_TICK


@dataclass(frozen=True)
class CommandChart:
    """Coordinates of hand states, for an oracle that plans in them.

    Attributes:
        to_hand: from coordinates (..., k) to hand states (..., n_hand).
        from_hand: back.
    """

    to_hand: Callable[[FloatArray], FloatArray]
    from_hand: Callable[[FloatArray], FloatArray]

    def frames(self, hand: FloatArray, command: FloatArray) -> FloatArray:
        """Hand states at the ends of a tick's frames, (frames, ..., n_hand): straight in the coordinates."""
        start = self.from_hand(hand)
        way = self.from_hand(command) - start
        count = self._count(start, way)
        k = np.arange(1, FRAMES_PER_TICK + 1).reshape(-1, *([1] * count.ndim))
        part = np.minimum(1.0, k / count)[..., None]
        return self.to_hand(start + part * way)

    def within_tick(self, hand: FloatArray, goal: FloatArray) -> FloatArray:
        """The command (..., n_hand) as far towards goal coordinates (..., k) as the hand comes in one tick.

        One further off could make the hand take the shorter way to it, the wrong way round.
        """
        start = self.from_hand(hand)
        way = goal - start
        part = np.minimum(1.0, FRAMES_PER_TICK / self._count(start, way))
        return self.to_hand(start + part[..., None] * way)

    def _count(self, start: FloatArray, way: FloatArray) -> FloatArray:
        """Frames that a way takes, (...) from shapes (..., k)."""
        part = np.linspace(0.0, 1.0, MOVE_FRAMES + 1).reshape(-1, *([1] * start.ndim))
        length = np.linalg.norm(np.diff(self.to_hand(start + part * way), axis=0), axis=-1).sum(axis=0)
        return np.maximum(MOVE_FRAMES, np.ceil(length / (LINEAR_SPEED * FRAME) - 1e-9))
