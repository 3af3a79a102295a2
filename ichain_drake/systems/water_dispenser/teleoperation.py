"""Moving the hand of the water dispenser as a person would tele-operate it: straight lines, grasps, presses, pours."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Self

import numpy as np

from ichain_drake.objects import ButtonMount
from ichain_drake.scenarios.hand_commands import TURN, HandCommands
from ichain_drake.systems.water_dispenser.layout import LAYOUT

FORWARD = math.pi / 2
"""Pitch of a hand that approaches along +x [rad]."""

GRASP = 0.06  # height of the hand on a standing cup [m]
_RIM = 0.04  # from the hand to the cup's rim [m]
BACK = 0.085  # how far before a cup the open hand waits [m]
_X, _Y, _Z, _ROLL = range(4)
_POUR = (LAYOUT.inlet[0], LAYOUT.inlet[1], LAYOUT.inlet[2] + 0.11)  # where the rim is kept while pouring
TURNING = (0.59, 0.0, 0.25)  # where the empty hand changes between down and forward


class Teleoperation(HandCommands):
    """Grasps, presses and pours with a cup; everything returns itself.

    Args:
        hand: hand state at start: x, y, z [m], roll, pitch [rad], grip; shape (6,).
    """

    def __init__(self, hand: Sequence[float]) -> None:
        super().__init__(("x", "y", "z", "roll", "pitch", "grip"), hand)

    def fetch(self, cup: Sequence[float], height: float = 0.0, off: Sequence[float] = (0.0, 0.0)) -> Self:
        """From before a standing cup, close around it.

        Args:
            cup: its place, x, y [m].
            height: of what it stands on [m].
            off: how far the grasp is off along x and z [m].
        """
        z = height + GRASP + off[1]
        return self.to(cup[0] - BACK, cup[1], z).to(cup[0] + off[0]).grip(True)

    def put(self, x: float, y: float, height: float = 0.0, off: Sequence[float] = (0.0, 0.0)) -> Self:
        """From above, put a held cup down, let go and back off; `off` as at the grasp."""
        z = height + GRASP + off[1]
        self.to(x + off[0], y).to(z=z + 0.0015, step=0.03)
        return self.wait(1).grip(False).to(x - BACK)

    def tilt(self, roll: float, off: Sequence[float] = (0.0, 0.0)) -> Self:
        """Turn a held cup about its rim, which stays where it is.

        Args:
            roll: of the hand at the end [rad].
            off: as at the grasp.
        """
        arm = _RIM - off[1]
        rim = self.now[_Y] - arm * math.sin(self.now[_ROLL]), self.now[_Z] + arm * math.cos(self.now[_ROLL])
        count = max(1, math.ceil(abs(roll - self.now[_ROLL]) / TURN - 1e-6))
        for angle in np.linspace(self.now[_ROLL], roll, count + 1)[1:]:
            self.to(y=rim[0] + arm * math.sin(angle), z=rim[1] - arm * math.cos(angle), roll=float(angle))
        return self

    def carry_over_inlet(self, off: Sequence[float] = (0.0, 0.0)) -> Self:
        """Lift a cup that was just grasped on the table, and bring its rim above the inlet."""
        z = _POUR[2] - _RIM + off[1]
        self.by(z=0.06).to(_POUR[0] - 0.07, self.now[_Y], z)
        return self.to(_POUR[0] + off[0], _POUR[1], z)

    def carry_back(self, x: float, y: float) -> Self:
        """From above the inlet to above a place on the table."""
        return self.to(_POUR[0] - 0.09, _POUR[1] - 0.10).to(x - 0.06, y, 0.16)

    def carry_below_outlet(self, off: Sequence[float] = (0.0, 0.0)) -> Self:
        """Lift a cup that was just grasped on the table, and bring it under the outlet, a little above the tray."""
        x, y, _ = LAYOUT.outlet
        z = LAYOUT.tray.height + GRASP + off[1] + 0.012
        self.by(z=0.06).to(x - 0.095, self.now[_Y], 0.20).to(y=y)
        return self.to(z=z).to(x + off[0], step=0.03)

    def carry_out(self) -> Self:
        """Bring a cup that was just grasped under the outlet out of the machine."""
        return self.by(z=0.012).to(LAYOUT.outlet[0] - 0.095).by(z=0.06)

    def turn(self, pitch: float) -> Self:
        """Change between pointing down and forward, where there is room."""
        return self.to(*TURNING).to(pitch=pitch)

    def press(self, button: Sequence[float], level: float, off: Sequence[float] = (0.0, 0.0)) -> Self:
        """Move straight down on a button, or up, to the height of a level; `off` along x and y [m]."""
        x, y, z = button
        return self.to(x + off[0], y + off[1], ButtonMount((x, y, z)).hand_height(level), step=0.02)
