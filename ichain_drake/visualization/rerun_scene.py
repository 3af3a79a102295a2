"""A scene as entities of rerun: shapes, lines and pictures by path, and how they move."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydrake.geometry import Box, Capsule, Cylinder, Ellipsoid, Mesh, Rgba, Shape, Sphere
from pydrake.math import RigidTransform, RotationMatrix

from ichain_drake.visualization.noted_scene import Noted, Picture, Ribbon, together
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
    for path in dict.fromkeys([*noted.places, *(p for p in tracks if not p.endswith(_INSIDE))]):
        pose = noted.places.get(path, RigidTransform())
        _send_pose(rr, stream, _entity(rr, path), pose, tracks.get(path, {}))
    for path, (shape, rgba) in noted.shapes.items():
        colored = [inside[path][kind] for kind in COLOR] if COLOR[0] in inside.get(path, {}) else []
        _send_shape(rr, stream, _entity(rr, path), shape, rgba, colored)
    for path, picture in noted.pictures.items():
        _send_picture(rr, stream, _entity(rr, path), picture)
    for path, line in noted.ribbons.items():
        if DRAWN not in inside.get(path, {}):
            _send_line(rr, stream, _entity(rr, path), line)


def at(rr: Any, seconds: FloatArray) -> list[Any]:
    """Moments on the time line, to the nanosecond."""
    return [rr.TimeColumn("time", duration=np.round(seconds * 1e9).astype("timedelta64[ns]"))]


def _entity(rr: Any, path: str) -> str:
    return str(rr.new_entity_path([ROOT, *path.split("/")]))


def _send_pose(rr: Any, stream: Any, entity: str, pose: RigidTransform, tracks: dict[Any, Track]) -> None:
    """Where something is, and its scale, by which what is hidden vanishes.

    All in each row: of a transform, the viewer takes the last row alone.
    """
    known = {kind: tracks[kind] for kind in (POSITION, ROTATION, SCALE, VISIBLE) if kind in tracks}
    if not known:
        stream.log(entity, rr.Transform3D(translation=pose.translation(), quaternion=_xyzw(pose)), static=True)
        return
    frames, values = together(list(known.values()))
    widths = np.cumsum([0, *(kind.size for kind in known)])
    found = {kind: values[:, a:b] for kind, a, b in zip(known, widths[:-1], widths[1:], strict=True)}
    count = (len(frames), 1)
    scale = found.get(SCALE, np.ones((len(frames), 3)))
    columns = rr.Transform3D.columns(
        translation=found.get(POSITION, np.tile(pose.translation(), count)),
        quaternion=found.get(ROTATION, np.tile(_xyzw(pose), count)),
        scale=np.where(found[VISIBLE] > 0, scale, _NOWHERE) if VISIBLE in found else scale,
    )
    _send(rr, stream, entity, frames, columns)


def _xyzw(pose: RigidTransform) -> FloatArray:
    return np.roll(pose.rotation().ToQuaternion().wxyz(), -1)


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
    """A mesh as its file is; of kinds that rerun doesn't read, nothing."""
    source = mesh.source()
    media = _MEDIA.get(source.extension())
    if media is None:
        return
    content = source.path().read_bytes() if source.is_path() else source.in_memory().mesh_file.contents()
    entity = f"{entity}/mesh"
    stream.log(entity, rr.Asset3D(contents=content, media_type=media), static=True)
    upright = "gltf" in media
    pose = RigidTransform(_UPRIGHT if upright else RotationMatrix(), [0.0, 0.0, 0.0])
    scale = mesh.scale3()[[0, 2, 1]] if upright else mesh.scale3()
    stream.log(entity, rr.Transform3D(quaternion=_xyzw(pose), scale=scale), static=True)


def _send_line(rr: Any, stream: Any, entity: str, line: Ribbon) -> None:
    color = _bytes(np.append(srgb(np.array(line.rgb)), line.alpha))
    mesh = rr.Mesh3D(vertex_positions=line.vertices, triangle_indices=line.triangles, albedo_factor=color)
    stream.log(entity, mesh, static=True)


def _send_picture(rr: Any, stream: Any, entity: str, picture: Picture) -> None:
    w, h = picture.width / 2, picture.height / 2
    mesh = rr.Mesh3D(
        vertex_positions=[[-w, -h, 0], [w, -h, 0], [w, h, 0], [-w, h, 0]],
        vertex_texcoords=[[0, 1], [1, 1], [1, 0], [0, 0]],  # the first pixel is at the upper left
        triangle_indices=[[0, 1, 2], [0, 2, 3]],
        albedo_texture=picture.pixels,
    )
    stream.log(entity, mesh, static=True)


def _bytes(color: FloatArray) -> NDArray[np.uint8]:
    return np.round(np.clip(color, 0, 1) * 255).astype(np.uint8)
