"""Moving the hand between bottle, kettle and switch as a person would tele-operate it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Self

import numpy as np

from ichain_drake.systems.kettle.layout import LAYOUT, VesselShape
from ichain_drake.systems.water_dispenser.teleoperation import BACK, Teleoperation

_TURN = 0.2  # rad in a tick, while the hand also moves
_OVER_KETTLE = 0.02  # of the upright bottle's bottom above the kettle's rim [m]
_OVER_BOTTLE = 0.13  # of the spout's tip above the bottle's mouth [m]: the upright kettle passes over the bottle


class KettleTeleoperation(Teleoperation):
    """Straight lines, grasps, presses and pours with two vessels; everything returns itself.

    Args:
        hand: see `Teleoperation`.
    """

    def __init__(self, hand: Sequence[float]) -> None:
        super().__init__(hand)
        self._vessel = LAYOUT.bottle
        self._off = (0.0, 0.0)

    def grasp(
        self, vessel: VesselShape, place: Sequence[float], floor: float = 0.0, off: tuple[float, float] = (0.0, 0.0)
    ) -> Self:
        """From before a standing vessel, close around it and lift it a little.

        Args:
            vessel: its shape.
            place: x, y of the middle of its bottom [m].
            floor: height of what it stands on [m].
            off: how far the grasp is off along x and z [m].
        """
        self._vessel, self._off = vessel, off
        x, z = place[0] + vessel.hand[0], floor + vessel.hand[1] + off[1]
        self.to(x - BACK, place[1], z).to(x + off[0]).grip(True)
        return self.rise(0.06)

    def release(self, x: float, y: float, floor: float = 0.0) -> Self:
        """From above, put the held vessel down at a place [m], let go and back off."""
        x, z = x + self._vessel.hand[0] + self._off[0], floor + self._vessel.hand[1] + self._off[1]
        return self.to(x, y).to(z=z + 0.0015, step=0.03).wait(1).grip(False).to(x - BACK)

    def rise(self, height: float) -> Self:
        """Straight up [m]."""
        return self.by(z=height)

    def mouth_to(self, x: float, y: float, z: float, step: float = 0.04) -> Self:
        """Bring the mouth of the held vessel, as it is tilted now, to a place [m]."""
        a, b, c = self._turned(float(self.now[3]))
        return self.to(x - a, y - b, z - c, step=step)

    def over_kettle(self, place: Sequence[float]) -> Self:
        """Bring the upright bottle over a kettle on the plate."""
        z = LAYOUT.plate.height + LAYOUT.kettle.height + LAYOUT.opening[2] + _OVER_KETTLE + LAYOUT.bottle.height
        a, _, c = self._turned(0.0)
        self.to(z=z - c).to(place[0] - a)
        return self.mouth_to(place[0], place[1], z)

    def over_bottle(self, place: Sequence[float]) -> Self:
        """Bring the spout of the upright kettle over a bottle."""
        z = LAYOUT.bottle.height + _OVER_BOTTLE
        self.to(z=z - self._turned(0.0)[2])
        return self.mouth_to(place[0], place[1], z)

    def pour(self, roll: float) -> Self:
        """Turn the held vessel about its mouth.

        Args:
            roll: of the hand at the end [rad].
        """
        now = float(self.now[3])
        x, y, z = self.now[:3] + self._turned(now)
        for angle in np.linspace(now, roll, max(1, math.ceil(abs(roll - now) / _TURN - 1e-6)) + 1)[1:]:
            a, b, c = self._turned(float(angle))
            self.to(x - a, y - b, z - c, roll=float(angle))
        return self

    def _turned(self, roll: float) -> np.ndarray:
        """From the hand to the mouth of the held vessel [m], for a roll of the hand [rad], shape (3,)."""
        x, y, z = self._vessel.arm(self._off)
        c, s = math.cos(roll), math.sin(roll)
        return np.array([x, c * y - s * z, s * y + c * z])
