"""What was learned about commanding the hand."""

from __future__ import annotations

from dataclasses import dataclass

from ichain_drake.graph import Origin
from ichain_drake.learning.frozen import FrozenModel
from ichain_drake.state import FloatArray


@dataclass(frozen=True)
class LearnedCommand:
    """The parts of a learned chain that belong to the robot, saved with the link whose parent it is.

    Attributes:
        map: from a wanted hand state to the command that reaches it, or None where they are the same.
        lower, upper: range of the commands, shape (n_hand,).
        hand_limit: largest change of the hand in one tick, shape (n_hand,).
        origin: what the positions of states and commands are relative to in `map`: the declared origin of the object
            that the hand was at; None where none is declared.
    """

    map: FrozenModel | None
    lower: FloatArray
    upper: FloatArray
    hand_limit: FloatArray
    origin: Origin | None = None
