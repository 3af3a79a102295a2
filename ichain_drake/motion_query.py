"""What is asked of whoever plans the robot's ways: one question, so that it is said in one place."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from numpy.typing import ArrayLike

from ichain_drake.state import FloatArray


@dataclass(frozen=True, eq=False)
class MotionQuery:
    """A way of the robot that is wanted, from a command to a goal.

    Attributes:
        now: last command, shape (n_root,).
        goal: shape (n_root,).
        held: object that goes along with the robot.
        left: robot state, shape (n_root,), in which each object that stands around was, or would be, let go of; of what
            is held and slipped, the one in which it would be where it is `now`, had it not slipped.
        shown: commands that were shown to lead to the goal, one a tick, shape (n, n_root), the last is the goal: gone
            as they are where they hit nothing.
        touched: object that they lead to, which is touched at the goal; None where they lead away from everything.
    """

    now: ArrayLike
    goal: ArrayLike
    held: str | None = None
    left: Mapping[str, FloatArray] = field(default_factory=dict)
    shown: ArrayLike | None = None
    touched: str | None = None
