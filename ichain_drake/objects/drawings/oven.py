"""How food and the parts of an oven look in a playback."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from pydrake.geometry import Box, Cylinder
from pydrake.math import RigidTransform, RotationMatrix

from ichain_drake.objects.parts.food import FoodSettings
from ichain_drake.objects.parts.oven_part import PartMount
from ichain_drake.state import FloatArray

_SHELL = (0.75, 0.78, 0.82, 1.0)
_LAMP_ON, _LAMP_OFF = (0.05, 0.8, 0.1), (0.02, 0.1, 0.03)


def heat_color(temperature: float) -> tuple[float, float, float]:
    """Linear RGB from pale blue (cold) to red (hot)."""
    t = min(max(temperature, 0.0), 1.0)
    return (0.25 + 0.6 * t, 0.35 * (1 - t) + 0.05, 0.7 * (1 - t) + 0.02)


class FoodDrawing:
    """A block whose colour is its temperature; without `block` only a lid, where a plant draws the rest."""

    def __init__(self, food: FoodSettings, *, block: bool = True) -> None:
        self._food, self._block = food, block

    def setup(self, scene: Any) -> None:
        """Create the shape."""
        width, height = self._food.width, self._food.height
        size, above = (height, 0.0) if self._block else (0.002, height / 2)
        scene.shape("food/body", Box(width, width, size), (*heat_color(0.0), 1.0), RigidTransform([0, 0, above]))

    def update(self, scene: Any, time: float, state: FloatArray) -> None:
        """Place and colour."""
        scene.pose("food", RigidTransform(self._food.camera.to_robot(state[:3])), time)
        scene.color("food/body", heat_color(float(state[3])), time)


class DoorDrawing:
    """A panel with a bar for a handle, and the oven's fixed parts.

    Args:
        mount: of the door.
        panel: lower and upper corner of the shut door's panel, in the robot's frame [m].
        boxes: lower and upper corners of the oven's fixed parts [m].
    """

    def __init__(self, mount: PartMount, panel: Sequence[float], boxes: Sequence[Sequence[float]] = ()) -> None:
        self._mount, self._panel = mount, np.array(panel).reshape(2, 3)
        self._boxes = [np.array(b).reshape(2, 3) for b in boxes]

    def setup(self, scene: Any) -> None:
        """Create panel, handle and oven."""
        for k, (low, high) in enumerate(self._boxes):
            scene.shape(f"part_{k}", Box(*(high - low)), _SHELL, RigidTransform(0.5 * (low + high)))
        low, high = self._panel
        scene.shape("door/panel", Box(*(high - low)), (0.2, 0.22, 0.28, 0.45), RigidTransform(0.5 * (low + high)))
        x, y, z = self._mount.point
        scene.shape("door/bar", Cylinder(0.008, 0.10), (0.8, 0.8, 0.82, 1.0), RigidTransform([x, y, z]))
        for name, dz in (("upper", 0.045), ("lower", -0.045)):
            middle = RigidTransform([0.5 * (x + low[0]), y, z + dz])
            scene.shape(f"door/{name}", Box(low[0] - x, 0.01, 0.01), (0.8, 0.8, 0.82, 1.0), middle)

    def update(self, scene: Any, time: float, state: FloatArray) -> None:
        """Slide."""
        scene.pose("door", RigidTransform(state[:3]), time)


class PushDrawing:
    """A cap that goes in and lights up; without `cap` only the light, where a plant draws the rest."""

    def __init__(self, mount: PartMount, on_from: float, *, cap: bool = True) -> None:
        self._mount, self._on_from, self._cap = mount, on_from, cap

    def setup(self, scene: Any) -> None:
        """Create the cap, which lies along x, or its light."""
        length = 0.024 if self._cap else 0.0015
        turn = RotationMatrix.MakeYRotation(np.pi / 2)
        pose = RigidTransform(turn, [-0.012 + length / 2, 0.0, 0.0])
        scene.shape("cap/body", Cylinder(0.014, length), (*_LAMP_OFF, 1.0), pose)

    def update(self, scene: Any, time: float, state: FloatArray) -> None:
        """Move and light the cap."""
        x, y, z = self._mount.point
        scene.pose("cap", RigidTransform([x + state[0], y, z]), time)
        scene.color("cap/body", _LAMP_ON if state[0] >= self._on_from else _LAMP_OFF, time)


class DialDrawing:
    """A knob with a mark; without `knob` only the mark, where a plant draws the rest."""

    def __init__(self, mount: PartMount, *, knob: bool = True) -> None:
        self._mount, self._knob = mount, knob

    def setup(self, scene: Any) -> None:
        """Create knob and mark."""
        turn = RotationMatrix.MakeYRotation(np.pi / 2)
        if self._knob:
            scene.shape("dial/knob", Cylinder(0.018, 0.032), (0.9, 0.9, 0.9, 1.0), RigidTransform(turn, [0.006, 0, 0]))
        scene.shape("dial/mark", Box(0.002, 0.004, 0.016), (0.85, 0.1, 0.05, 1.0), RigidTransform([-0.011, 0, 0.009]))

    def update(self, scene: Any, time: float, state: FloatArray) -> None:
        """Turn."""
        turn = RotationMatrix.MakeXRotation(-float(state[3]))
        scene.pose("dial", RigidTransform(turn, np.array(self._mount.point)), time)
