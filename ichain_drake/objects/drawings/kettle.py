"""How a kettle and its plate look in a playback."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from pydrake.geometry import Box, Cylinder
from pydrake.math import RigidTransform, RotationMatrix

from ichain_drake.objects.drawings.dispenser import DROPS, water_color
from ichain_drake.objects.vessels.cup_settings import CupSettings
from ichain_drake.objects.vessels.kettle import Kettle
from ichain_drake.state import FloatArray

_STEEL, _DARK = (0.75, 0.77, 0.8), (0.1, 0.1, 0.12)
_GAUGE = 0.009  # half-width of the window that shows the water [m]


class KettleDrawing:
    """A kettle with a window in its side: the water's level is the amount, its colour the temperature.

    Args:
        cup: geometry and camera.
        body: height of the kettle's body [m].
        handle: from the middle of the bottom to the handle, along x and z [m].
        solid: whether to draw the kettle; a plant may do it.
        bottom: height that a stream of water falls down to [m].
    """

    def __init__(
        self, cup: CupSettings, body: float, handle: tuple[float, float], *, solid: bool = True, bottom: float = 0.0
    ) -> None:
        self._cup, self._body, self._handle = cup, body, handle
        self._solid, self._bottom = solid, bottom
        index = Kettle.state_space.index
        self._water, self._lean, self._flow = index("water"), index("lean"), index("flow")

    def setup(self, scene: Any) -> None:
        """Create body, handle, spout, window and water, in a frame at the spout's tip."""
        a, b = self._cup.mouth
        bottom = np.array([-a, -b, -self._cup.height])  # from the tip
        r, h = self._cup.radius, self._body
        if self._solid:
            self._part(scene, "wall", Cylinder(r, h), _STEEL, bottom + [0, 0, h / 2])
            x, z = self._handle
            self._part(scene, "grip", Box(0.036, 0.018, 0.08), _DARK, bottom + [x, 0, z])
            for k, up in enumerate((-0.034, 0.034)):
                arm = Box(abs(x) - r + 0.01, 0.018, 0.012)
                self._part(scene, f"arm_{k}", arm, _DARK, bottom + [(x - r) / 2, 0, z + up])
            root = bottom + [0, math.copysign(r - 0.005, b), self._cup.height - 0.03]
            turn = RotationMatrix.MakeXRotation(math.atan2(root[1], -root[2]))
            spout = RigidTransform(turn, 0.5 * root)
            scene.shape("kettle/spout", Cylinder(0.008, float(np.linalg.norm(root))), (*_STEEL, 1.0), spout)
        # The window is beside the spout, where the camera of the playback sees it.
        inside = 0.9 * h
        place = bottom + [0.38 * r, math.copysign(0.99 * r, b), 0.04 * h]
        scene.place("kettle/gauge", RigidTransform(place))
        middle = RigidTransform([0, 0, inside / 2])
        scene.shape("kettle/gauge/window", Box(2.4 * _GAUGE, 2 * _GAUGE, inside), (*_DARK, 0.35), middle)
        column = Box(2 * _GAUGE, 2.2 * _GAUGE, inside)
        scene.shape("kettle/gauge/water/column", column, water_color(0.0), middle)
        scene.shape("stream/length/jet", Box(0.007, 0.007, 1.0), water_color(0.0), RigidTransform([0, 0, -0.5]))

    @staticmethod
    def _part(scene: Any, name: str, shape: Any, color: Sequence[float], place: FloatArray) -> None:
        scene.shape(f"kettle/{name}", shape, (*color, 1.0), RigidTransform(place))

    def update(self, scene: Any, time: float, state: FloatArray) -> None:
        """Pose and content."""
        tip = self._cup.camera.to_robot(state[:3])
        turn = RotationMatrix.MakeXRotation(state[3]) @ RotationMatrix.MakeYRotation(state[self._lean])
        scene.pose("kettle", RigidTransform(turn, tip), time)
        amount, color = float(state[self._water]), water_color(float(state[self._water + 1]))
        scene.scale("kettle/gauge/water", (1.0, 1.0, amount), time)
        scene.visible("kettle/gauge/water", amount > DROPS, time)
        scene.color("kettle/gauge/water/column", color, time)
        scene.visible("stream", bool(state[self._flow] > 0) and tip[2] > self._bottom, time)
        scene.pose("stream", RigidTransform(tip), time)
        scene.scale("stream/length", (1.0, 1.0, max(tip[2] - self._bottom, 0.001)), time)
        scene.color("stream/length/jet", color, time)


class PlateDrawing:
    """A drawing that shows another one's object and, beside it, things that never move.

    Args:
        drawing: of the object.
        boxes: lower and upper corners of what stands still, six values each [m].
    """

    def __init__(self, drawing: KettleDrawing, boxes: Sequence[Sequence[float]]) -> None:
        self._drawing = drawing
        self._boxes = [np.array(b, dtype=float).reshape(2, 3) for b in boxes]

    def setup(self, scene: Any) -> None:
        """Create the boxes and the other's shapes."""
        for k, (low, high) in enumerate(self._boxes):
            scene.shape(f"part_{k}", Box(*(high - low)), (*_DARK, 1.0), RigidTransform(0.5 * (low + high)))
        self._drawing.setup(scene)

    def update(self, scene: Any, time: float, state: FloatArray) -> None:
        """The other's."""
        self._drawing.update(scene, time, state)
