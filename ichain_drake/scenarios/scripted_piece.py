"""A demonstration before it is recorded."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np

from ichain_drake.errors import InputError
from ichain_drake.state import FloatArray, StateSpace

StartT = TypeVar("StartT")


@dataclass(frozen=True)
class ScriptedPiece(Generic[StartT]):
    """One piece of a script that stands in for a person.

    Attributes:
        name: of the piece.
        start: state that its world starts from.
        commands: hand command of each tick, shape (n_ticks, n_hand).
    """

    name: str
    start: StartT
    commands: FloatArray

    def check(self, hand: StateSpace) -> None:
        """See that the commands are some, and for this hand.

        Raises:
            InputError: if they are not; names the piece.
        """
        shape = np.shape(self.commands)
        if len(shape) != 2 or not shape[0] or shape[1] != len(hand):  # noqa: PLR2004 - ticks and variables
            raise InputError(
                f"piece {self.name}: its commands have shape {shape}; give a row a tick of {', '.join(hand.names)}"
            )
        if not np.isfinite(self.commands).all():
            raise InputError(f"piece {self.name}: a command is not finite in row {_first_bad(self.commands)}")


def _first_bad(commands: FloatArray) -> int:
    return int(np.argmin(np.isfinite(commands).all(axis=1)))
