"""A gripper where there is no arm: physics `ideal`, in which the hand is a point that tracks its command."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from pydrake.geometry import Box, Cylinder, Rgba
from pydrake.math import RigidTransform

from ichain_drake.visualization.scene import Scene

FloatArray = NDArray[np.float64]

_PALM = Rgba(0.25, 0.28, 0.32)
_FINGER = Rgba(0.55, 0.6, 0.65)
_REACH, _THICKNESS = 0.07, 0.012  # of a finger [m]


class HandDrawing:
    """Draws a palm with two fingers; a `Drawing`.

    The hand's frame H: origin between the finger tips, z the direction of approach, y the direction fingers open in.

    Args:
        hand: the hand's pose in the world and the gap between its fingers [m], from the robot object's state.
    """

    def __init__(self, hand: Callable[[FloatArray], tuple[RigidTransform, float]]) -> None:
        self._hand = hand

    def setup(self, scene: Scene) -> None:
        """Create palm and fingers."""
        palm = RigidTransform([0, 0, -_REACH - 0.015])
        scene.shape("hand/palm", Box(0.05, 0.11, 0.03), _PALM, palm)
        wrist = RigidTransform([0, 0, -_REACH - 0.05])
        scene.shape("hand/wrist", Cylinder(0.022, 0.04), _PALM, wrist)
        for side in ("left", "right"):
            finger = RigidTransform([0, 0, -_REACH / 2 + 0.008])
            scene.shape(f"hand/{side}/finger", Box(0.022, _THICKNESS, _REACH + 0.016), _FINGER, finger)

    def update(self, scene: Scene, time: float, state: FloatArray) -> None:
        """Move hand and fingers."""
        X_WH, gap = self._hand(state)
        scene.pose("hand", X_WH, time)
        for side, sign in (("left", 1.0), ("right", -1.0)):
            y = sign * (max(gap, 0.0) + _THICKNESS) / 2
            scene.pose(f"hand/{side}", RigidTransform([0, y, 0]), time)
