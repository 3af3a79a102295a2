"""What drawings put into a scene, noted in place of a Meshcat: shapes, poses and meshes by path, for other viewers."""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from PIL import Image
from pydrake.geometry import Rgba, Shape
from pydrake.math import RigidTransform

from ichain_drake.visualization.scene import Scene
from ichain_drake.visualization.tracks import Track

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Ribbon:
    """A flat, unshaded line.

    Attributes:
        vertices: shape (n, 3) [m].
        triangles: shape (m, 3), of vertices.
        alpha: of its colour.
        rgb: its colour, linear.
    """

    vertices: FloatArray
    triangles: NDArray[np.int64]
    alpha: float
    rgb: list[float] = field(default_factory=lambda: [0.0, 0.0, 0.0])


@dataclass(frozen=True)
class Picture:
    """A flat picture in the x-y plane, in the middle of its frame, upright when y is up.

    Attributes:
        pixels: RGBA, shape (height, width, 4).
        width, height: of the picture in the scene [m].
    """

    pixels: NDArray[np.uint8]
    width: float
    height: float


@dataclass
class Noted:
    """Takes the calls that a `Scene` makes to its Meshcat, and shows nothing.

    Attributes:
        shapes: with their colours, by path.
        ribbons: by path.
        pictures: by path.
        places: poses in the parent's frame, by path; of what moves, the first.
    """

    shapes: dict[str, tuple[Shape, Rgba]] = field(default_factory=dict)
    ribbons: dict[str, Ribbon] = field(default_factory=dict)
    pictures: dict[str, Picture] = field(default_factory=dict)
    places: dict[str, RigidTransform] = field(default_factory=dict)

    def SetObject(self, path: str, shape: Shape, rgba: Rgba) -> None:  # noqa: N802 - as of a Meshcat
        """A shape at a path."""
        self.shapes[path] = shape, rgba

    def SetTransform(self, path: str, X_ParentPath: RigidTransform) -> None:  # noqa: N802 - as of a Meshcat
        """The pose of a path in its parent's frame."""
        self.places[path] = X_ParentPath

    def SetTriangleMesh(self, path: str, vertices: FloatArray, faces: NDArray[np.int64], rgba: Rgba) -> None:  # noqa: N802 - as of a Meshcat
        """A line; vertices and faces of shape (3, n)."""
        self.ribbons[path] = Ribbon(np.asarray(vertices).T, np.asarray(faces).T, rgba.a())

    def SetProperty(self, path: str, name: str, value: object) -> None:  # noqa: N802 - as of a Meshcat
        """The glow of a line; whatever else changes is in the scene's tracks."""
        line = self.ribbons.get(path.removesuffix("/<object>"))
        if line is not None and name.startswith("material.emissive[") and isinstance(value, float):
            line.rgb["rgb".index(name[-2])] = value


class NotedScene(Scene):
    """A scene that is noted; pictures as they are, not as meshes of Meshcat's."""

    def image(
        self, path: str, picture: Image.Image | bytes, width: float, height: float, pose: RigidTransform | None = None
    ) -> None:
        """Put a flat picture at a path; see `Scene.image`."""
        shown = Image.open(io.BytesIO(picture)) if isinstance(picture, bytes) else picture
        self.meshcat.pictures[self._root + path] = Picture(np.asarray(shown.convert("RGBA")), width, height)
        self.place(path, pose if pose is not None else RigidTransform())


def together(tracks: Sequence[Track]) -> tuple[NDArray[np.int64], FloatArray]:
    """Several tracks as one of steps: at each frame at which one of them changes, the last value of each.

    Args:
        tracks: of k numbers together.

    Returns:
        frames, shape (n,), and values, shape (n, k); before its first frame a track has its first value.
    """
    frames = np.unique(np.concatenate([t.frames for t in tracks])).astype(np.int64)
    columns = []
    for track in tracks:
        rows = np.maximum(np.searchsorted(track.frames, frames, side="right") - 1, 0)
        columns.append(np.array(track.values, dtype=float).reshape(len(track.values), -1)[rows])
    return frames, np.concatenate(columns, axis=1)
