"""A camera's frame: poses that a camera tracks are given in it, and it is turned and shifted against the robot's."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ichain_drake.state import FloatArray

FRAME = "camera"
"""Name of the frame in the roles of the variables that the camera sees."""


@dataclass(frozen=True)
class CameraFrame:
    """Where the camera looks from (paper sec. VI: the cup's pose is given in the camera's frame).

    Attributes:
        yaw: turn about the vertical [rad].
        shift: the robot frame's origin in the camera frame [m].
    """

    yaw: float = 0.0
    shift: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def from_robot(self, point: FloatArray) -> FloatArray:
        """A point of the robot frame in the camera frame [m], shape (..., 3) -> (..., 3)."""
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        x, y, z = np.asarray(point, dtype=float).T
        dx, dy, dz = self.shift
        return np.array([c * x - s * y + dx, s * x + c * y + dy, z + dz]).T

    def to_robot(self, point: FloatArray) -> FloatArray:
        """A point of the camera frame in the robot frame [m], shape (..., 3) -> (..., 3)."""
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        x, y, z = np.asarray(point, dtype=float).T
        dx, dy, dz = self.shift
        x, y = x - dx, y - dy
        return np.array([c * x + s * y, c * y - s * x, z - dz]).T
