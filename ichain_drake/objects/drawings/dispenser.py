"""How a cup, a push button and a dispenser's tank look in a playback."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from pydrake.geometry import Box, Cylinder
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix

from ichain_drake.objects.parts.button import LEVELS, ButtonMount
from ichain_drake.objects.placement import Placement
from ichain_drake.objects.vessels.cup import Cup, CupSettings
from ichain_drake.objects.vessels.tank import Tank
from ichain_drake.state import FloatArray

DROPS = 0.003
"""Less water than this, as a share of a full vessel, is not drawn."""


def water_color(temperature: float) -> tuple[float, float, float]:
    """Linear RGB from blue (cold) to red (hot)."""
    t = min(max(temperature, 0.0), 1.0)
    return (0.02 + 0.75 * t, 0.12 * (1 - t) + 0.02, 0.75 * (1 - t) + 0.02)


class CupDrawing:
    """A glass with water in it: its level is the amount, its colour the temperature; what runs out of it is a stream.

    Args:
        cup: geometry and camera.
        glass: whether to draw the glass; a plant may do it.
        bottom: height that a stream of water falls down to [m].
    """

    def __init__(self, cup: CupSettings, *, glass: bool = True, bottom: float = 0.0) -> None:
        self._cup, self._glass, self._bottom = cup, glass, bottom
        self._lean, self._flow = Cup.state_space.index("lean"), Cup.state_space.index("flow")

    def setup(self, scene: Any) -> None:
        """Create glass and water."""
        height, radius = self._cup.height, self._cup.radius
        if self._glass:
            wall = RigidTransform([0, 0, -height / 2])
            scene.shape("cup/glass", Cylinder(radius, height), (0.85, 0.92, 0.97, 0.3), wall)
        inside = 0.92 * height
        scene.place("cup/inside", RigidTransform([0, 0, -0.98 * height]))
        column = RigidTransform([0, 0, inside / 2])
        scene.shape("cup/inside/water/column", Cylinder(0.85 * radius, inside), (0.1, 0.3, 0.8), column)
        scene.shape("stream/length/jet", Box(0.007, 0.007, 1.0), water_color(0.0), RigidTransform([0, 0, -0.5]))

    def update(self, scene: Any, time: float, state: FloatArray) -> None:
        """Pose and content."""
        rim = self._cup.camera.to_robot(state[:3])
        turn = RotationMatrix.MakeXRotation(state[3]) @ RotationMatrix.MakeYRotation(state[self._lean])
        scene.pose("cup", RigidTransform(turn, rim), time)
        color = water_color(float(state[5]))
        scene.scale("cup/inside/water", (1.0, 1.0, float(state[4])), time)
        scene.visible("cup/inside/water", bool(state[4] > DROPS), time)
        scene.color("cup/inside/water/column", color, time)
        # Water leaves over the lowest point of the rim.
        axis = turn.matrix()[:, 2]
        down = axis[2] * axis - [0.0, 0.0, 1.0]
        lip = rim + self._cup.radius * down / max(float(np.linalg.norm(down)), 1e-9)
        runs = bool(state[self._flow] > 0) and lip[2] > self._bottom
        scene.visible("stream", runs, time)
        scene.pose("stream", RigidTransform(lip), time)
        scene.scale("stream/length", (1.0, 1.0, max(lip[2] - self._bottom, 0.001)), time)
        scene.color("stream/length/jet", color, time)


class ButtonDrawing:
    """A cap that goes down and lights up; without `cap` only the light, where a plant draws the rest."""

    def __init__(self, mount: ButtonMount, color: tuple[float, float, float], *, cap: bool = True) -> None:
        self._mount, self._color, self._cap = mount, np.array(color), cap

    def setup(self, scene: Any) -> None:
        """Create the shapes."""
        height = 0.02 if self._cap else 0.0015
        pose = RigidTransform([0.0, 0.0, 0.0008 - height / 2])
        scene.shape("cap/body", Cylinder(0.016, height), (*self._color, 1.0), pose)

    def update(self, scene: Any, time: float, state: FloatArray) -> None:
        """Move and light the cap."""
        x, y, z = self._mount.top
        scene.pose("cap", RigidTransform([x, y, z - state[1]]), time)
        lit = state[0] > LEVELS / 2
        scene.color("cap/body", self._color if lit else 0.25 * self._color, time)


class TankDrawing:
    """A gauge: a column of water whose height is the amount and whose colour the temperature.

    Args:
        foot: lower end of the gauge in the robot's frame [m].
        radius, height: of the gauge when full [m].
        outlet: of the dispenser, in the robot's frame [m].
        fall: how far its jet falls [m].
        boxes: lower and upper corners of the machine's parts [m], where no plant draws them.
        moved: how all this is moved and turned from where it is given.
    """

    def __init__(
        self,
        foot: tuple[float, float, float],
        radius: float,
        height: float,
        outlet: tuple[float, float, float],
        fall: float,
        boxes: Sequence[Sequence[float]] = (),
        moved: Placement | None = None,
    ) -> None:
        self._foot, self._radius, self._height = foot, radius, height
        self._outlet, self._fall = outlet, fall
        self._flow = Tank.state_space.index("flow")
        self._boxes = [np.array(b).reshape(2, 3) for b in boxes]
        self._moved = moved or Placement()

    def _at(self, point: FloatArray) -> RigidTransform:
        x, y = self._moved.forth(point[0], point[1])
        return RigidTransform(RollPitchYaw(0.0, 0.0, self._moved.turn), [x, y, point[2]])

    def setup(self, scene: Any) -> None:
        """Create gauge, water, jet and machine."""
        for k, (low, high) in enumerate(self._boxes):
            scene.shape(f"part_{k}", Box(*(high - low)), (0.75, 0.78, 0.82, 1.0), self._at(0.5 * (low + high)))
        scene.place("gauge", self._at(np.array(self._foot)))
        tube = RigidTransform([0, 0, self._height / 2])
        scene.shape("gauge/tube", Cylinder(self._radius * 1.25, self._height), (0.85, 0.9, 0.95, 0.25), tube)
        scene.shape("gauge/water/column", Cylinder(self._radius, self._height), water_color(0.0), tube)
        x, y, z = self._outlet
        jet = self._at(np.array([x, y, z - self._fall / 2]))
        scene.shape("jet", Box(0.006, 0.006, self._fall), water_color(0.0), jet)

    def update(self, scene: Any, time: float, state: FloatArray) -> None:
        """Level, colour, and the jet while water leaves."""
        color = water_color(float(state[1]))
        scene.scale("gauge/water", (1.0, 1.0, float(state[0])), time)
        scene.visible("gauge/water", bool(state[0] > DROPS), time)
        scene.color("gauge/water/column", color, time)
        scene.visible("jet", bool(state[self._flow] > 0), time)
        scene.color("jet", color, time)
