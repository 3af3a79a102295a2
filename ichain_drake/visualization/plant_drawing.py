"""The bodies of a plant in the scene, posed from logged positions: no simulation, no context of the run is needed."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray
from pydrake.geometry import FrameId, GeometryId, Mesh, Rgba, Role, SceneGraph, SceneGraphInspector
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BodyIndex
from pydrake.systems.framework import Diagram, System

from ichain_drake.errors import InputError
from ichain_drake.visualization.scene import Scene

T = TypeVar("T")

DEFAULT_COLOR = Rgba(0.62, 0.66, 0.7, 1.0)


class PlantDrawing:
    """Draws the visual geometry of a plant.

    Args:
        diagram: holds one finalized `MultibodyPlant` and the `SceneGraph` it is registered with, at any depth.

    Raises:
        InputError: if the diagram doesn't hold exactly one of each.
    """

    def __init__(self, diagram: Diagram) -> None:
        self._plant = _only(diagram, MultibodyPlant)
        self._inspector: SceneGraphInspector = _only(diagram, SceneGraph).model_inspector()
        self._context = self._plant.CreateDefaultContext()
        self._moving: list[tuple[BodyIndex, str]] = []

    @property
    def num_positions(self) -> int:
        """Generalized positions that `update` takes."""
        return int(self._plant.num_positions())

    def setup(self, scene: Scene) -> None:
        """Create the bodies' shapes; shapes of bodies that can't move stay where they are."""
        for frame in self._inspector.GetAllFrameIds():
            body = self._plant.GetBodyFromFrameId(frame)
            geometries = self._inspector.GetGeometries(frame, Role.kIllustration)
            if body is None or not geometries:
                continue
            path = self._inspector.GetName(frame).replace("::", "/")
            if self._plant.IsAnchored(body):
                scene.place(path, self._plant.EvalBodyPoseInWorld(self._context, body))
            else:
                self._moving.append((body.index(), path))
            for geometry in geometries:
                self._add(scene, path, geometry, frame)

    def update(self, scene: Scene, time: float, positions: NDArray[np.float64]) -> None:
        """Pose the bodies.

        Args:
            scene: where they are.
            time: playback time [s].
            positions: of the plant, shape (n_positions,) [m, rad].
        """
        self._plant.SetPositions(self._context, positions)
        poses: list[RigidTransform] = self._plant.get_body_poses_output_port().Eval(self._context)
        for body, path in self._moving:
            scene.pose(path, poses[int(body)], time)

    def _add(self, scene: Scene, path: str, geometry: GeometryId, frame: FrameId) -> None:
        shape = self._inspector.GetShape(geometry)
        properties = self._inspector.GetIllustrationProperties(geometry)
        # White leaves a mesh its own materials.
        default = Rgba(1, 1, 1, 1) if isinstance(shape, Mesh) else DEFAULT_COLOR
        color: Rgba = properties.GetPropertyOrDefault("phong", "diffuse", default)  # type: ignore[assignment]
        name = self._inspector.GetName(geometry).replace("::", "/")
        scene.shape(f"{path}/{name}", shape, color, self._inspector.GetPoseInFrame(geometry))


def _only(diagram: Diagram, kind: type[T]) -> T:
    found = [s for s in _systems(diagram) if isinstance(s, kind)]
    if len(found) != 1:
        raise InputError(f"plant diagram {diagram.get_name()!r}: one {kind.__name__} needed, it has {len(found)}")
    return found[0]


def _systems(diagram: Diagram) -> Iterator[System]:
    for system in diagram.GetSystems():
        yield system
        if isinstance(system, Diagram):
            yield from _systems(system)
