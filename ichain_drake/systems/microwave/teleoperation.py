"""Moving the hand at the microwave oven as a person would tele-operate it: straight lines before the oven, grasps."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Self

import numpy as np

from ichain_drake.scenarios.hand_commands import HandCommands
from ichain_drake.state import FloatArray
from ichain_drake.systems.microwave.layout import LAYOUT, Point

SAFE = 0.54
"""Here the hand is clear of handle, knob and button [m]."""

HOLD = 0.045
"""Height of the hand on standing food [m]."""

_X, _Y, _Z = range(3)
_LIFT = 0.03  # of food over a doorstep
_NONE = (0.0, 0.0, 0.0)


class OvenTeleoperation(HandCommands):
    """Grasps what is at the oven, and moves it; everything returns itself.

    Args:
        hand: hand state at start: x, y, z [m], roll [rad], grip; shape (5,).
    """

    def __init__(self, hand: Sequence[float]) -> None:
        super().__init__(("x", "y", "z", "roll", "grip"), hand)
        self._slack: FloatArray = np.zeros(3)  # how far off the part is held [m]

    def reach(self, point: Sequence[float], off: Sequence[float] = _NONE, roll: float = 0.0) -> Self:
        """From wherever it is, back to the safe plane, along it, and straight ahead to a point.

        Args:
            point: in the robot's frame [m].
            off: how far off that the hand ends [m].
            roll: at the point [rad].
        """
        x, y, z = (p + o for p, o in zip(point, off, strict=True))
        if self.now[_X] > SAFE + 1e-9:
            self.to(SAFE)
        return self.to(SAFE, y, z, roll).to(x)

    def take(self, point: Sequence[float], off: Sequence[float] = _NONE, roll: float = 0.0) -> Self:
        """`reach` with an open hand, and close it."""
        return self.reach(point, off, roll).grip(True)

    def leave(self) -> Self:
        """Open the hand and go straight back."""
        return self.grip(False).to(SAFE)

    # The oven's parts; coordinates as in the layout.

    def slide(self, name: str, to: float, step: float = 0.04) -> Self:
        """Move a part that was grasped, to a coordinate; the hand stays as far off as it grasped it."""
        mount = {"door": LAYOUT.door, "button": LAYOUT.button}[name]
        axis = "xyz".index(mount.axis)
        goal = self.now[:3].copy()
        goal[axis] = mount.point[axis] + to + self._slack[axis]
        return self.to(goal[0], goal[1], goal[2], step=step)

    def take_part(self, name: str, at: float, off: Sequence[float] = _NONE, roll: float = 0.0) -> Self:
        """Grasp a sliding part that is at a coordinate."""
        self._slack = np.array(off, dtype=float)
        return self.take(part_point(name, at), off, roll)

    # Food.

    def take_food(self, place: Sequence[float], off: Sequence[float] = _NONE) -> Self:
        """Grasp standing food; `place` is x, y of its middle [m], in the cavity or not."""
        floor = LAYOUT.cavity[2] if place[0] > LAYOUT.front else 0.0
        return self.take((place[0], place[1], floor + HOLD), off)

    def lift(self) -> Self:
        """Lift what was grasped, and come back with it to before the oven."""
        self.to(z=self.now[_Z] + _LIFT)
        return self.to(min(float(self.now[_X]), 0.60))

    def carry_in(self, place: Sequence[float], off: Sequence[float] = _NONE) -> Self:
        """Bring lifted food before the doorway and in, put it down, let go and come out."""
        z = LAYOUT.cavity[2] + HOLD + off[2]
        self.to(0.585, place[1] + off[1], z + 0.02).to(place[0] + off[0])
        return self.to(z=z + 0.0015, step=0.03).leave()

    def carry_out(self, place: Sequence[float], off: Sequence[float] = _NONE) -> Self:
        """Put lifted food down before the oven, let go and back off."""
        z = HOLD + off[2]
        self.to(0.585, place[1] + off[1], z + 0.04).to(place[0] + off[0])
        return self.to(z=z + 0.0015, step=0.03).leave()


def part_point(name: str, at: float) -> Point:
    """Where a sliding part, or the knob, is grasped when it is at a coordinate [m]."""
    mount = {"door": LAYOUT.door, "button": LAYOUT.button, "knob": LAYOUT.knob}[name]
    point = list(mount.point)
    if name != "knob":
        point["xyz".index(mount.axis)] += at
    return point[0], point[1], point[2]
