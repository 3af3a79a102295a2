"""Scripted pieces for StickButton2D, on the instance with one button: what a person would show, laid out beforehand.

The person sees where everything is at the start, and drives by eye from there: she leaves a gap to the stick that is
sometimes too wide, grasps it off its middle, sometimes beside it, and stops beside the button as often as on it.
Nothing is looked up while she drives, and where a stick can be taken or a button is pressed, her hand does not know.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Self

import numpy as np

from ichain_drake.scenarios.scripted_piece import ScriptedPiece
from ichain_drake.state import FloatArray

STICKS, DRIVES = 24, 14
"""Pieces with the stick, and without."""

UP = np.pi / 2
_LIMIT = np.array([0.05, 0.05, np.pi / 16, 0.1])  # m, m, rad, m: longest way of each variable in a tick
_VARIABLES = ("x", "y", "theta", "arm", "vacuum")
_ARM = 0.2  # m: all the way out
_REACH = 0.205  # m from the base's middle to the face of the gripper then
_WIDTH, _LENGTH = 0.05, 1.25  # m: of the stick
_TOP = 2.49  # m: just below the far wall


class RobotCommands:
    """Lays out commands, tick by tick, in straight lines. Everything returns itself.

    Args:
        start: state of the robot, shape (5,).
        low, high: corners of where it can be [m].
    """

    def __init__(self, start: FloatArray, low: tuple[float, float], high: tuple[float, float]) -> None:
        self.now = np.array(start, dtype=float)
        self._low, self._high = np.array(low), np.array(high)
        self.rows: list[FloatArray] = []

    def to(self, **wanted: float) -> Self:
        """Go to new values of some variables, as far as the base can; the vacuum is switched at the end.

        Args:
            wanted: by variable: x, y, arm [m], theta [rad], vacuum.
        """
        goal = self.now.copy()
        for name, value in wanted.items():
            goal[_VARIABLES.index(name)] = value
        goal[:2] = np.clip(goal[:2], self._low, self._high)
        way = goal[:4] - self.now[:4]
        count = max(1, int(np.ceil(np.max(np.abs(way) / _LIMIT) - 1e-6)))
        for k in range(1, count + 1):
            self.rows.append(np.append(self.now[:4] + k / count * way, self.now[4] if k < count else goal[4]))
        self.now = goal
        return self

    def wait(self, ticks: int) -> Self:
        """Stay for so many ticks."""
        self.rows += [self.now] * ticks
        return self

    @property
    def commands(self) -> FloatArray:
        """What was laid out, shape (n_ticks, 5)."""
        return np.array(self.rows)


def script_pieces(
    rng: np.random.Generator,
    draw: Callable[[], int],
    look: Callable[[int], Mapping[str, FloatArray]],
    low: tuple[float, float],
    high: tuple[float, float],
) -> Iterator[ScriptedPiece[int]]:
    """All pieces.

    Args:
        rng: draws what varies.
        draw: a start.
        look: states of all objects at a start, as the person sees them before she begins.
        low, high: corners of where the base can be [m].
    """
    for k in range(STICKS):
        start = draw()
        seen = look(start)
        lay = RobotCommands(seen["robot"], low, high)
        _with_stick(lay, rng, seen["stick"], seen["button0"], leave=k % 2 == 0)
        yield ScriptedPiece(f"stick_{k}", start, lay.commands)
    for k in range(DRIVES):
        start = draw()
        while look(start)["button0"][1] > high[1]:  # she picks one that the robot can drive to
            start = draw()
        seen = look(start)
        lay = RobotCommands(seen["robot"], low, high)
        _without(lay, rng, seen["button0"])
        yield ScriptedPiece(f"drive_{k}", start, lay.commands)


def _with_stick(
    lay: RobotCommands, rng: np.random.Generator, stick: FloatArray, button: FloatArray, *, leave: bool
) -> None:
    """Miss the stick a few times, take it, move about, pass over the button and stop beside and on it, let go."""
    middle, low = stick[0] + _WIDTH / 2, stick[1]
    lay.to(arm=_ARM, theta=UP).to(y=low - 0.5).to(x=middle)
    for side, gap in ((0.09, 0.008), (-0.09, 0.008), (0.0, 0.035), (rng.uniform(-0.03, 0.03), 0.023)):
        off = low - _REACH - gap
        lay.to(x=middle + side, y=off - 0.03).to(y=off).to(vacuum=1).wait(1).to(y=off - 0.04).to(vacuum=0)
    off, gap = rng.uniform(-0.065, 0.065), _REACH + rng.uniform(0.001, 0.017)
    lay.to(x=middle + off, y=low - gap - 0.05).to(y=low - gap).to(vacuum=1).wait(1)
    off = lay.now[0] - middle  # the base may have been stopped by a wall's clearance
    top = _TOP - _LENGTH - gap
    for _ in range(2):
        x, y = middle + rng.uniform(-0.4, 0.4), lay.now[1] + rng.uniform(-0.3, 0.3)
        lay.to(x=x, y=min(y, top))
    along, side = rng.uniform(-0.03, _LENGTH + 0.03), rng.choice([-1, 1])
    lay.to(x=button[0] + side * 0.25).to(y=min(button[1] - along - gap, top))
    for x in (side * 0.25, side * rng.uniform(0.05, 0.13), rng.uniform(-0.05, 0.05)):
        lay.to(x=button[0] + x + off).wait(1)
    lay.wait(3)
    if not leave:
        lay.to(x=button[0] + off - side * 0.3).to(y=lay.now[1] - rng.uniform(0.0, 0.3))
    lay.to(vacuum=0).wait(2).to(y=lay.now[1] - 0.1).wait(1)


def _without(lay: RobotCommands, rng: np.random.Generator, button: FloatArray) -> None:
    """Drive to a button from some side, stopping on the way, onto it, and back."""
    lay.to(arm=_ARM, theta=UP)
    turn = rng.uniform(-np.pi, np.pi)
    way = np.array([np.cos(turn), np.sin(turn)])
    for far in (0.4, 0.24, rng.uniform(0.1, 0.22), rng.uniform(0.0, 0.1)):
        x, y = button[:2] + far * way
        lay.to(x=x, y=y).wait(1)
    x, y = button[:2] - 0.3 * way
    lay.wait(3).to(x=x, y=y).wait(2)
