"""An object of which nobody said how it looks: a block where it is, turned as it is, lit while it is on."""

from __future__ import annotations

import numpy as np
from pydrake.geometry import Box
from pydrake.math import RigidTransform, RotationMatrix

from ichain_drake.state import FloatArray, StateSpace
from ichain_drake.visualization.scene import Scene

_COLORS = ((0.05, 0.12, 0.35), (0.45, 0.18, 0.03), (0.06, 0.3, 0.1), (0.3, 0.05, 0.25), (0.3, 0.25, 0.05))
_LIT = (0.9, 0.6, 0.05)
_AXES = "xyz"


class PlainDrawing:
    """Draws an object by its roles alone; a `Drawing`.

    Args:
        name: of the object.
        space: its full state space; a position has variables with the role, or of the names x, y and z.
        size: of the block [m].
        number: of its colour.

    Raises:
        ValueError: if it has no position (see `places`).
    """

    def __init__(self, name: str, space: StateSpace, size: float, number: int = 0) -> None:
        self._place = places(space)
        if not self._place:
            raise ValueError(f"{name} has no position to be drawn at")
        self._path, self._size = name, size
        self._color = _COLORS[number % len(_COLORS)]
        self._turn = next((i for i, v in enumerate(space.variables) if v.kind == "angle"), None)
        self._lit = [i for i, v in enumerate(space.variables) if v.kind == "binary"]

    def setup(self, scene: Scene) -> None:
        """Create the block, with a nose where it turns."""
        size = self._size
        scene.shape(f"{self._path}/block", Box(size, size, size / 2), self._color)
        if self._turn is not None:
            nose = RigidTransform([0.6 * size, 0.0, 0.0])
            scene.shape(f"{self._path}/nose", Box(0.5 * size, 0.3 * size, size / 3), self._color, nose)

    def update(self, scene: Scene, time: float, state: FloatArray) -> None:
        """Move and light it."""
        place = np.array([0.0, 0.0, self._size / 4])
        for axis, i in self._place.items():
            place[axis] = state[i]
        turn = RotationMatrix.MakeZRotation(float(state[self._turn])) if self._turn is not None else RotationMatrix()
        scene.pose(self._path, RigidTransform(turn, place), time)
        if self._lit:
            on = any(state[i] > 0.5 for i in self._lit)  # noqa: PLR2004 - yes or no
            scene.color(f"{self._path}/block", _LIT if on else self._color, time)


def places(space: StateSpace) -> dict[int, int]:
    """Index of the variable along each axis, of those that there are; empty for what has no place."""
    found: dict[int, int] = {}
    for i, v in enumerate(space.variables):
        axis = v.role.axis if v.role is not None and v.role.kind == "position" else v.name if v.role is None else ""
        if axis in _AXES and axis and _AXES.index(axis) not in found:
            found[_AXES.index(axis)] = i
    return found
