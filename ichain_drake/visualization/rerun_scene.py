"""A scene as entities of rerun: shapes, lines and pictures by path, and how they move."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydrake.geometry import Box, Capsule, Cylinder, Ellipsoid, Mesh, Rgba, Shape, Sphere
from pydrake.math import RigidTransform, RotationMatrix

from ichain_drake.visualization.noted_scene import Noted, Ribbon, together
from ichain_drake.visualization.recording import RATE
from ichain_drake.visualization.scene import COLOR, DRAWN, POSITION, ROTATION, SCALE, VISIBLE, Scene, srgb
from ichain_drake.visualization.tracks import Track

FloatArray = NDArray[np.float64]

ROOT = "scene"
_MEDIA = {".gltf": "model/gltf+json", ".glb": "model/gltf-binary", ".obj": "model/obj", ".stl": "model/stl"}
_UPRIGHT = RotationMatrix.MakeXRotation(np.pi / 2)  # glTF's y is up; Drake's z
_NOWHERE = 1e-4
"""Scale of what is hidden [1]: entities can't be hidden for a while, and a scale of 0 has no inverse."""
_INSIDE = "<object>"


def send_scene(rr: Any, stream: Any, noted: Noted, scene: Scene) -> None:
    """Write a scene, its changes at every frame at which there are some: the viewer doesn't interpolate.

    A line that grows in the playback is left out: rerun shows what was before by itself.

    Args:
        rr: the module `rerun`.
        stream: its recording stream.
        noted: what the drawings put into the scene.
        scene: with their changes.
    """
    stream.log(ROOT, rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
    tracks = {path.removeprefix("/drake/"): {t.kind: t for t in items} for path, items in scene.tracks.items()}
    inside = {path.removesuffix(f"/{_INSIDE}"): found for path, found in tracks.items() if path.endswith(_INSIDE)}
    for path, pose in noted.places.items():
        if POSITION not in tracks.get(path, {}):
            _send_still(rr, stream, _entity(rr, path), pose)
    for path, (shape, rgba) in noted.shapes.items():
        colored = [inside[path][kind] for kind in COLOR] if COLOR[0] in inside.get(path, {}) else []
        _send_shape(rr, stream, _entity(rr, path), shape, rgba, colored)
    for path, line in noted.ribbons.items():
        if DRAWN not in inside.get(path, {}):
            _send_line(rr, stream, _entity(rr, path), line)
    for path, found in tracks.items():
        if not path.endswith(_INSIDE):
            _send_moves(rr, stream, _entity(rr, path), found)


def at(rr: Any, seconds: FloatArray) -> list[Any]:
    """Moments on the time line, to the nanosecond."""
    return [rr.TimeColumn("time", duration=np.round(seconds * 1e9).astype("timedelta64[ns]"))]


def _entity(rr: Any, path: str) -> str:
    return str(rr.new_entity_path([ROOT, *path.split("/")]))


def _send_still(rr: Any, stream: Any, entity: str, pose: RigidTransform) -> None:
    turn = pose.rotation().ToQuaternion()
    # From fields: a whole transform would have a scale for good, too.
    still = rr.Transform3D.from_fields(
        translation=pose.translation(), quaternion=[turn.x(), turn.y(), turn.z(), turn.w()]
    )
    stream.log(entity, still, static=True)


def _send_moves(rr: Any, stream: Any, entity: str, tracks: dict[Any, Track]) -> None:
    """Poses, and scale, by which what is hidden vanishes."""
    for kind, name in ((POSITION, "translation"), (ROTATION, "quaternion")):
        if kind in tracks:
            frames, values = together([tracks[kind]])
            _send(rr, stream, entity, frames, rr.Transform3D.columns(**{name: values}))
    if SCALE in tracks or VISIBLE in tracks:
        frames, values = together([tracks[kind] for kind in (SCALE, VISIBLE) if kind in tracks])
        scale = values[:, :3] if SCALE in tracks else np.ones((len(frames), 3))
        if VISIBLE in tracks:
            scale = np.where(values[:, -1:] > 0, scale, _NOWHERE)
        _send(rr, stream, entity, frames, rr.Transform3D.columns(scale=scale))


def _send(rr: Any, stream: Any, entity: str, frames: NDArray[np.int64], columns: Any) -> None:
    stream.send_columns(entity, indexes=at(rr, frames / RATE), columns=columns, strict=True)


def _send_shape(rr: Any, stream: Any, entity: str, shape: Shape, rgba: Rgba, colored: Sequence[Track]) -> None:
    kind, fields = _form(rr, shape)
    if kind is None:
        if isinstance(shape, Mesh):
            _send_mesh(rr, stream, entity, shape)
        return
    stream.log(entity, kind.from_fields(**fields, fill_mode="solid"), static=True)
    if not colored:
        color = [rgba.r(), rgba.g(), rgba.b(), rgba.a()]
        stream.log(entity, kind.from_fields(colors=[_bytes(np.array(color))]), static=True)
        return
    frames, linear = together(colored)
    colors = np.column_stack([srgb(linear), np.full(len(frames), rgba.a())])
    _send(rr, stream, entity, frames, kind.columns(colors=_bytes(colors)))


def _form(rr: Any, shape: Shape) -> tuple[Any, dict[str, Any]]:
    """The archetype that a shape is, about its own origin and along z as Drake's are, and its fields."""
    if isinstance(shape, Box):
        return rr.Boxes3D, {"half_sizes": [shape.size() / 2]}
    if isinstance(shape, Sphere):
        return rr.Ellipsoids3D, {"half_sizes": [[shape.radius()] * 3]}
    if isinstance(shape, Ellipsoid):
        return rr.Ellipsoids3D, {"half_sizes": [[shape.a(), shape.b(), shape.c()]]}
    if isinstance(shape, Cylinder):
        return rr.Cylinders3D, {"lengths": [shape.length()], "radii": [shape.radius()]}
    if isinstance(shape, Capsule):  # rerun's begins at the origin
        middle = [[0.0, 0.0, -shape.length() / 2]]
        return rr.Capsules3D, {"lengths": [shape.length()], "radii": [shape.radius()], "translations": middle}
    return None, {}


def _send_mesh(rr: Any, stream: Any, entity: str, mesh: Mesh) -> None:
    """A mesh or a picture as its file is; of kinds that rerun doesn't read, nothing."""
    source = mesh.source()
    media = _MEDIA.get(source.extension())
    if media is None:
        return
    content = source.path().read_bytes() if source.is_path() else source.in_memory().mesh_file.contents()
    entity = f"{entity}/mesh"
    stream.log(entity, rr.Asset3D(contents=content, media_type=media), static=True)
    scale = mesh.scale3()
    if "gltf" in media:
        _send_still(rr, stream, entity, RigidTransform(_UPRIGHT, [0.0, 0.0, 0.0]))
        scale = scale[[0, 2, 1]]
    stream.log(entity, rr.Transform3D.from_fields(scale=scale), static=True)


def _send_line(rr: Any, stream: Any, entity: str, line: Ribbon) -> None:
    color = _bytes(np.append(srgb(np.array(line.rgb)), line.alpha))
    mesh = rr.Mesh3D(vertex_positions=line.vertices, triangle_indices=line.triangles, albedo_factor=color)
    stream.log(entity, mesh, static=True)


def _bytes(color: FloatArray) -> NDArray[np.uint8]:
    return np.round(np.clip(color, 0, 1) * 255).astype(np.uint8)
