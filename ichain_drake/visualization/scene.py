"""A small scene over Drake's own Meshcat, in which everything that changes also replays from a file."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol, TypeAlias, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike, NDArray
from PIL import Image
from pydrake.geometry import Mesh, Meshcat, Rgba, Shape
from pydrake.math import RigidTransform

from ichain_drake.visualization.image_mesh import image_mesh
from ichain_drake.visualization.recording import RATE
from ichain_drake.visualization.ribbon import ribbon, spaced
from ichain_drake.visualization.tracks import Track, TrackKind

FloatArray = NDArray[np.float64]

POSITION = TrackKind(".position", "vector3", 3, 1e-4)
ROTATION = TrackKind(".quaternion", "quaternion", 4, 4e-4)  # half the angle: 0.046 deg
SCALE = TrackKind(".scale", "vector3", 3, 1e-3)
VISIBLE = TrackKind(".visible", "boolean", 1, 0.0)
COLOR = tuple(TrackKind(f".material.color[{c}]", "number", 1, 4e-3) for c in "rgb")
DRAWN = TrackKind(".drawn", "number", 1, 1.0)


Color: TypeAlias = Rgba | Sequence[float]
"""sRGB with or without alpha, in 0..1."""


class Drawing(Protocol):
    """How an object looks. Objects implement it without importing this package.

    A drawing may also have `legend`, a sequence of (label, RGB in 0..1) for the playback's legend, and
    `begin_episode` (see `EpisodeDrawing`).
    """

    def setup(self, scene: Scene) -> None:
        """Create the parts in the scene, once."""

    def update(self, scene: Scene, time: float, state: FloatArray) -> None:
        """Bring the parts to a state.

        Args:
            scene: where the parts are.
            time: playback time [s], not decreasing from call to call.
            state: the object's true state, shape (n_variables,).
        """


@runtime_checkable
class EpisodeDrawing(Drawing, Protocol):
    """A drawing that shows more of an episode than its present state, such as the path it will take."""

    def begin_episode(self, scene: Scene, times: FloatArray, states: FloatArray, line: FloatArray | None) -> None:
        """Create what belongs to one episode; called for each before its first `update`.

        Args:
            scene: where the parts are.
            times: playback times of the episode, shape (n,) [s].
            states: the object's true states at these times, shape (n, n_variables).
            line: commanded polyline of the episode, shape (m, 2); None if there is none.
        """


def linear_rgb(color: Color) -> FloatArray:
    """Linear RGB, which materials and `Scene.color` use, of an sRGB color as one picks it on a screen.

    Args:
        color: in 0..1; an alpha is ignored.

    Returns:
        shape (3,), in 0..1.
    """
    rgba = to_rgba(color)
    picked = np.array([rgba.r(), rgba.g(), rgba.b()])
    return np.where(picked <= 0.04045, picked / 12.92, ((picked + 0.055) / 1.055) ** 2.4)  # IEC 61966-2-1


def srgb(linear: FloatArray) -> FloatArray:
    """The color that one sees on a screen, of linear RGB in 0..1; any shape."""
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * np.maximum(linear, 0.0) ** (1 / 2.4) - 0.055)


def to_rgba(color: Color) -> Rgba:
    """Drake's color of a color."""
    return color if isinstance(color, Rgba) else Rgba(*map(float, color))


class Scene:
    """Shapes, pictures and lines in a Meshcat by path, and their changes in time.

    Paths are relative to Drake's root, such as `car/body`; each object's drawing gets a scene under the object's name,
    so that two of them never meet. A change with a time is kept for the playback, on frames of 1/30 s; the first of its
    kind also shows at once, so that the scene looks right before it plays. A live scene shows every change at once and
    keeps none.

    In Meshcat a pose and a scale of the same path exclude each other (setting a pose resets the scale): scale a path
    below the one that moves.

    Args:
        meshcat: where to draw; calls must come from the thread that made it.
        live: show changes at once instead of keeping them.
    """

    def __init__(self, meshcat: Meshcat, live: bool = False) -> None:
        self.meshcat = meshcat
        self._live = live
        self._root = ""
        self._tracks: dict[str, dict[str, Track]] = {}

    def under(self, name: str) -> Scene:
        """The part of this scene below a path; it keeps its changes with this scene's."""
        part = type(self)(self.meshcat, self._live)
        part._root = f"{self._root}{name}/"
        part._tracks = self._tracks
        return part

    @property
    def tracks(self) -> dict[str, list[Track]]:
        """All recorded changes, by full path in Meshcat's scene tree."""
        return {path: list(items.values()) for path, items in self._tracks.items()}

    def shape(self, path: str, shape: Shape, color: Color, pose: RigidTransform | None = None) -> None:
        """Put a Drake shape at a path, at a pose in its parent's frame."""
        self.meshcat.SetObject(self._root + path, shape, to_rgba(color))
        self.place(path, pose if pose is not None else RigidTransform())

    def image(
        self, path: str, picture: Image.Image | bytes, width: float, height: float, pose: RigidTransform | None = None
    ) -> None:
        """Put a flat picture at a path: x right, y up, seen from +z, unshaded. `width`, `height` in metres."""
        self.meshcat.SetObject(self._root + path, Mesh(image_mesh(picture, width, height)), Rgba(1, 1, 1, 1))
        self.place(path, pose if pose is not None else RigidTransform())

    def place(self, path: str, pose: RigidTransform) -> None:
        """Put a path at a pose in its parent's frame for good; `pose` is for what moves."""
        self.meshcat.SetTransform(self._root + path, pose)

    def line(
        self, path: str, points: ArrayLike, width: float, color: Color, normal: ArrayLike = (0.0, 0.0, 1.0)
    ) -> None:
        """Put a flat, unshaded line at a path.

        Args:
            path: where.
            points: shape (n, 3) [m].
            width: of the line [m].
            color: sRGB, with alpha where it is to be seen through.
            normal: direction that it faces, shape (3,).

        Raises:
            InputError: if `points` has another shape.
        """
        value = np.asarray(points, dtype=float)
        if value.ndim == 2 and value.shape[1] == 3:
            value = value[spaced(value, width / 4)]
        self._ribbon(path, value, width, color, normal)

    def growing_line(
        self,
        path: str,
        points: ArrayLike,
        times: ArrayLike,
        width: float,
        color: Color,
        normal: ArrayLike = (0.0, 0.0, 1.0),
    ) -> None:
        """Put a flat line at a path that is drawn as time passes: at `times[k]` it reaches `points[k]`.

        One mesh, of which the playback draws more and more segments; it shrinks again when seeking back. three.js can't
        animate a mesh's draw range, so the page gives the mesh the property `drawn` that the track drives.

        Args:
            path: where.
            points: shape (n, 3) [m].
            times: playback time of each point, increasing, shape (n,) [s].
            width: of the line [m].
            color: sRGB, with alpha where it is to be seen through.
            normal: direction that it faces, shape (3,).
        """
        value = np.asarray(points, dtype=float)
        when = np.asarray(times, dtype=float)
        kept = spaced(value, width / 4)
        if len(kept) < 2:
            return  # it never moved
        self._ribbon(path, value[kept], width, color, normal)
        for k, time in enumerate(when[kept]):
            self._put(f"{path}/<object>", DRAWN, (float(k),), time)

    def pose(self, path: str, X_PO: RigidTransform, time: float) -> None:
        """Move a path to a pose in its parent's frame, at a time [s]."""
        if self._live or not self._has(path, POSITION):
            self.place(path, X_PO)
        if not self._live:
            self._put(path, POSITION, tuple(X_PO.translation()), time)
            w, x, y, z = X_PO.rotation().ToQuaternion().wxyz()
            self._put(path, ROTATION, (x, y, z, w), time)

    def scale(self, path: str, factors: Sequence[float], time: float) -> None:
        """Scale a path along its axes by factors, shape (3,), at a time [s]; 0 is taken as 1e-4 (no inverse else)."""
        value = tuple(max(float(f), 1e-4) for f in factors)
        self._change(path, "scale", SCALE, value, list(value), time)

    def visible(self, path: str, on: bool, time: float) -> None:
        """Show or hide a path and all below it, at a time [s]."""
        self._change(path, "visible", VISIBLE, (float(on),), bool(on), time)

    def color(self, path: str, rgb: Sequence[float], time: float) -> None:
        """Color a shape, at a time [s].

        Args:
            path: of a shape, as given to `shape`.
            rgb: linear RGB in 0..1, shape (3,); see `linear_rgb`.
            time: playback time [s].
        """
        # A color as one vector does not replay; single channels do, live too.
        for kind, value in zip(COLOR, rgb, strict=True):
            self._change(f"{path}/<object>", kind.name[1:], kind, (float(value),), float(value), time)

    def hold(self, time: float) -> None:
        """Let everything stand as it is until a time [s], so that later changes don't start before it."""
        for tracks in self._tracks.values():
            for track in tracks.values():
                if track.frames[-1] < round(time * RATE):
                    track.put(round(time * RATE), track.values[-1])

    def _ribbon(self, path: str, points: FloatArray, width: float, color: Color, normal: ArrayLike) -> None:
        vertices, triangles = ribbon(points, width, normal)
        # Black, but glowing: the color does not depend on the lights.
        self.meshcat.SetTriangleMesh(self._root + path, vertices, triangles, Rgba(0, 0, 0, to_rgba(color).a()))
        mesh = f"{self._root}{path}/<object>"
        for channel, value in zip("rgb", linear_rgb(color), strict=True):
            self.meshcat.SetProperty(mesh, f"material.emissive[{channel}]", float(value))
            self.meshcat.SetProperty(mesh, f"material.specular[{channel}]", 0.0)

    def _change(
        self,
        path: str,
        name: str,
        kind: TrackKind,
        value: tuple[float, ...],
        shown: float | bool | list[float],
        time: float,
    ) -> None:
        if self._live or not self._has(path, kind):
            self.meshcat.SetProperty(self._root + path, name, shown)
        if not self._live:
            self._put(path, kind, value, time)

    def _has(self, path: str, kind: TrackKind) -> bool:
        return kind.name in self._tracks.get(self._full(path), {})

    def _put(self, path: str, kind: TrackKind, value: tuple[float, ...], time: float) -> None:
        tracks = self._tracks.setdefault(self._full(path), {})
        if kind.name not in tracks:
            tracks[kind.name] = Track(kind)
        tracks[kind.name].put(round(time * RATE), value)

    def _full(self, path: str) -> str:
        """The path in Meshcat's scene tree."""
        return f"/drake/{self._root}{path}"
