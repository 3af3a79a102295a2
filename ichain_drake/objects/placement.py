"""Geometry that was given in one place, moved and turned to another."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Placement:
    """A turn about a vertical axis, then a shift.

    Attributes:
        about: where the axis is, x and y in the robot's frame [m].
        shift: along x and y [m].
        turn: [rad].
    """

    about: tuple[float, float] = (0.0, 0.0)
    shift: tuple[float, float] = (0.0, 0.0)
    turn: float = 0.0

    def forth(self, x: Any, y: Any) -> tuple[Any, Any]:
        """Where what was given at a place is [m]; numbers or arrays of one shape."""
        c, s = math.cos(self.turn), math.sin(self.turn)
        (a, b), (dx, dy) = self.about, self.shift
        return a + dx + c * (x - a) - s * (y - b), b + dy + s * (x - a) + c * (y - b)

    def back(self, x: Any, y: Any) -> tuple[Any, Any]:
        """Where what is at a place was given [m]; the inverse of `forth`."""
        c, s = math.cos(self.turn), math.sin(self.turn)
        (a, b), (dx, dy) = self.about, self.shift
        x, y = x - a - dx, y - b - dy
        return a + c * x + s * y, b - s * x + c * y

    def point_back(self, point: Sequence[float]) -> tuple[float, float, float]:
        """`back` of a point x, y, z [m]."""
        return (*self.back(point[0], point[1]), point[2])
