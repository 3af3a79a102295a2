"""How a pot with a lid on rails, and a jug, look in a playback."""

from __future__ import annotations

from typing import Any

from pydrake.geometry import Box, Cylinder
from pydrake.math import RigidTransform, RotationMatrix

from ichain_drake.objects.drawings.dispenser import DROPS, water_color
from ichain_drake.objects.parts.lid import LidMount
from ichain_drake.objects.vessels.jug import Jug, JugSettings
from ichain_drake.objects.vessels.pot import PotSettings
from ichain_drake.state import FloatArray

_WATER = water_color(0.0)
_METAL, _DARK, _GLASS = (0.72, 0.74, 0.78, 1.0), (0.25, 0.27, 0.3, 1.0), (0.85, 0.92, 0.97, 0.3)


class LidDrawing:
    """A plate with a handle on two rails.

    Args:
        lid: where it is.
        x: of its middle [m].
        wide: of the plate [m].
    """

    def __init__(self, lid: LidMount, x: float, wide: float) -> None:
        self._lid, self._x, self._wide = lid, x, wide

    def setup(self, scene: Any) -> None:
        """Create plate, handle and rails."""
        y, z = self._lid.shut
        for name, side in (("near", -0.5), ("far", 0.5)):
            rail = RigidTransform([self._x + side * self._wide, y + self._lid.travel / 2, z - 0.032])
            scene.shape(f"rail_{name}", Box(0.008, self._lid.travel + self._wide, 0.008), _DARK, rail)
        scene.shape("lid/plate", Box(self._wide, self._wide, 0.006), _METAL, RigidTransform([0, 0, -0.025]))
        bar = RigidTransform([-self._wide / 4, 0, -0.01])
        scene.shape("lid/handle", Box(self._wide / 2, 0.02, 0.024), _DARK, bar)

    def update(self, scene: Any, time: float, state: FloatArray) -> None:
        """Slide it."""
        scene.pose("lid", RigidTransform([self._x, state[0], state[1]]), time)


class JugDrawing:
    """A glass with water in it, held by its rim; what runs out of it is a stream.

    Args:
        jug: geometry.
        x: of its middle [m].
        bottom: height that a stream of water falls down to [m].
    """

    def __init__(self, jug: JugSettings, x: float, bottom: float) -> None:
        self._jug, self._x, self._bottom = jug, x, bottom
        self._flow = Jug.state_space.index("flow")

    def setup(self, scene: Any) -> None:
        """Create glass, water and stream."""
        height, radius = self._jug.height, 0.035
        wall = RigidTransform([0, 0, -height / 2])
        scene.shape("jug/glass", Cylinder(radius, height), _GLASS, wall)
        scene.place("jug/inside", RigidTransform([0, 0, -0.98 * height]))
        column = RigidTransform([0, 0, 0.46 * height])
        scene.shape("jug/inside/water/column", Cylinder(0.85 * radius, 0.92 * height), _WATER, column)
        scene.shape("stream/length/jet", Box(0.007, 0.007, 1.0), _WATER, RigidTransform([0, 0, -0.5]))

    def update(self, scene: Any, time: float, state: FloatArray) -> None:
        """Pose and content."""
        rim = [self._x, float(state[0]), float(state[1])]
        scene.pose("jug", RigidTransform(RotationMatrix.MakeXRotation(state[2]), rim), time)
        scene.scale("jug/inside/water", (1.0, 1.0, float(state[3])), time)
        scene.visible("jug/inside/water", bool(state[3] > DROPS), time)
        scene.visible("stream", bool(state[self._flow] > 0) and rim[2] > self._bottom, time)
        scene.pose("stream", RigidTransform(rim), time)
        scene.scale("stream/length", (1.0, 1.0, max(rim[2] - self._bottom, 0.001)), time)


class PotDrawing:
    """A pot with water in it.

    Args:
        pot: where its mouth is.
        x: of its middle [m].
        radius: [m].
    """

    def __init__(self, pot: PotSettings, x: float, radius: float) -> None:
        self._pot, self._x, self._radius = pot, x, radius

    def setup(self, scene: Any) -> None:
        """Create wall and water."""
        y, high = self._pot.middle
        scene.shape(
            "wall", Cylinder(self._radius, high), (0.6, 0.62, 0.66, 0.35), RigidTransform([self._x, y, high / 2])
        )
        scene.place("inside", RigidTransform([self._x, y, 0.004]))
        column = RigidTransform([0, 0, 0.45 * high])
        scene.shape("inside/water/column", Cylinder(0.93 * self._radius, 0.9 * high), _WATER, column)

    def update(self, scene: Any, time: float, state: FloatArray) -> None:
        """Level."""
        scene.scale("inside/water", (1.0, 1.0, float(state[0])), time)
        scene.visible("inside/water", bool(state[0] > DROPS), time)
