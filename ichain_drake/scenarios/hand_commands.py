"""Hand commands laid out as a person would tele-operate the hand: straight lines, waiting, opening and closing."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Self

import numpy as np

from ichain_drake.errors import InputError
from ichain_drake.state import FloatArray

TURN = 0.25
"""How far the hand turns in a tick at most [rad]."""

_STEP = 0.04  # m in a tick
_CLOSING = 2  # ticks in which fingers open or close
_PLACE, _TURNS = ("x", "y", "z"), ("yaw", "pitch", "roll")


class HandCommands:
    """Lays out hand commands, tick by tick, in straight lines that the hand can follow. Everything returns itself.

    Args:
        names: of the hand's exposed variables, in their order; from x, y, z, yaw, pitch, roll and grip.
        start: their values at the start, shape (n_hand,).

    Attributes:
        now: where the hand is after what was laid out, shape (n_hand,).

    Raises:
        InputError: if there is not one value a name.
    """

    def __init__(self, names: Sequence[str], start: Sequence[float] | FloatArray) -> None:
        self.now = np.array(start, dtype=float)
        if self.now.shape != (len(names),):
            raise InputError(f"hand commands: {len(names)} values are needed, of {', '.join(names)}; got {self.now}")
        self._index = {name: i for i, name in enumerate(names)}
        self._place = [i for i, name in enumerate(names) if name in _PLACE]
        self._turns = [i for i, name in enumerate(names) if name in _TURNS]
        self._rows: list[FloatArray] = []

    @property
    def commands(self) -> FloatArray:
        """What was laid out, shape (n_ticks, n_hand)."""
        return np.array(self._rows)

    def to(  # noqa: PLR0913 - a hand has so many variables
        self,
        x: float | None = None,
        y: float | None = None,
        z: float | None = None,
        roll: float | None = None,
        pitch: float | None = None,
        yaw: float | None = None,
        step: float = _STEP,
    ) -> Self:
        """Move to new values of some variables, in steps of at most `step` metres and a quarter of a radian.

        Args:
            x, y, z: place [m].
            roll, pitch, yaw: orientation [rad].
            step: longest way in a tick [m].

        Raises:
            InputError: on a variable that the hand does not expose.
        """
        wanted = {"x": x, "y": y, "z": z, "roll": roll, "pitch": pitch, "yaw": yaw}
        goal = self.now.copy()
        for name, value in wanted.items():
            if value is not None:
                goal[self._of(name)] = value
        way = goal - self.now
        turn = np.abs(way[self._turns]).max(initial=0.0)
        count = max(1, math.ceil(max(np.linalg.norm(way[self._place]) / step, turn / TURN) - 1e-6))
        start = self.now
        self._rows += [start + k / count * way for k in range(1, count)] + [goal]
        self.now = goal
        return self

    def by(self, x: float = 0.0, y: float = 0.0, z: float = 0.0, step: float = _STEP) -> Self:
        """Move by a displacement [m].

        Args:
            x, y, z: displacement [m].
            step: longest way in a tick [m].

        Raises:
            InputError: on a variable that the hand does not expose.
        """
        moved = {n: float(self.now[self._of(n)]) + d for n, d in (("x", x), ("y", y), ("z", z)) if d}
        return self.to(**moved, step=step)

    def wait(self, ticks: int) -> Self:
        """Stay for so many ticks."""
        self._rows += [self.now] * ticks
        return self

    def grip(self, closed: bool) -> Self:
        """Close the hand (`closed`), or open it.

        Raises:
            InputError: if it has no grip.
        """
        self.now = self.now.copy()
        self.now[self._of("grip")] = float(closed)
        return self.wait(_CLOSING)

    def _of(self, name: str) -> int:
        if name not in self._index:
            raise InputError(f"hand commands: the hand has no {name}; it has {', '.join(self._index)}")
        return self._index[name]


class SeveralHands:
    """Lays out the commands of several hands, which move one after the other: each waits while another one moves.

    Args:
        names: of each hand's exposed variables; see `HandCommands`.
        starts: their values at the start, shape (n_hand,), by the hand, in the order of the graph's robots.

    Raises:
        InputError: if there is not one value a name.
    """

    def __init__(self, names: Sequence[str], starts: Mapping[str, Sequence[float] | FloatArray]) -> None:
        self._hands = {hand: HandCommands(names, start) for hand, start in starts.items()}

    def __getitem__(self, hand: str) -> HandCommands:
        """One of the hands, from when all have done what was laid out."""
        self._wait()
        return self._hands[hand]

    def _wait(self) -> None:
        longest = max(len(hand.commands) for hand in self._hands.values())
        for hand in self._hands.values():
            hand.wait(longest - len(hand.commands))

    @property
    def commands(self) -> FloatArray:
        """What was laid out, shape (n_ticks, n_command): the hands one after the other."""
        self._wait()
        return np.concatenate([hand.commands for hand in self._hands.values()], axis=-1)
