"""A demonstration before it is recorded."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np

from ichain_drake.errors import InputError
from ichain_drake.graph import InteractionGraph
from ichain_drake.state import FloatArray

StartT = TypeVar("StartT")


@dataclass(frozen=True)
class ScriptedPiece(Generic[StartT]):
    """One piece of a script that stands in for a person.

    Attributes:
        name: of the piece.
        start: state that its world starts from.
        commands: hand command of each tick, shape (n_ticks, n_hand).
        shows: names of the interactions that it is a demonstration of; nobody needs it where all of them are known.
            Empty: it is always recorded.
    """

    name: str
    start: StartT
    commands: FloatArray
    shows: tuple[str, ...] = ()

    def is_needed(self, known: Collection[str]) -> bool:
        """Whether it shows anything but known interactions, given by name."""
        return not self.shows or not set(self.shows) <= set(known)

    def check(self, graph: InteractionGraph) -> None:
        """See that the commands are some, and for this graph's robot, and that what it shows are interactions.

        Raises:
            InputError: if they are not; names the piece.
        """
        hand = graph.command
        names = [e.name for e in graph.interactions]
        for shown in self.shows:
            if shown not in names:
                raise InputError(
                    f"piece {self.name}: it is to show {shown}, which is no interaction; there are {', '.join(names)}"
                )
        shape = np.shape(self.commands)
        if len(shape) != 2 or not shape[0] or shape[1] != len(hand):  # noqa: PLR2004 - ticks and variables
            raise InputError(
                f"piece {self.name}: its commands have shape {shape}; give an array with one row for each tick and "
                f"{len(hand)} columns: {', '.join(hand.names)}"
            )
        if not np.isfinite(self.commands).all():
            raise InputError(f"piece {self.name}: a command is not finite in row {_first_bad(self.commands)}")


def _first_bad(commands: FloatArray) -> int:
    return int(np.argmin(np.isfinite(commands).all(axis=1)))
