"""A recording as one HTML file that plays anywhere, without a server and without a network."""

from __future__ import annotations

import logging
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from traceback import clear_frames

import numpy as np
from pydrake.geometry import Box, Meshcat, MeshcatParams, Rgba
from pydrake.math import RigidTransform
from pydrake.systems.framework import Diagram

from ichain_drake.errors import InputError
from ichain_drake.files import write_whole
from ichain_drake.visualization.html_page import playback_page
from ichain_drake.visualization.page_log import page_log
from ichain_drake.visualization.plant_drawing import PlantDrawing
from ichain_drake.visualization.recording import RATE, RecordedEpisode, Recording
from ichain_drake.visualization.scene import Drawing, EpisodeDrawing, Scene
from ichain_drake.visualization.tracks import pack_animation

FLOOR = Rgba(0.80, 0.82, 0.84)


@dataclass(frozen=True)
class Camera:
    """Where the playback is seen from at first, and what it stands on.

    Attributes:
        position: of the camera in the world [m].
        target: what it looks at [m].
        field_of_view: upright, from edge to edge [deg].
        ground: height of the floor [m]; None for no floor.
    """

    position: tuple[float, float, float] = (0.62, -2.1, 0.95)
    target: tuple[float, float, float] = (0.68, 0.0, 0.34)
    field_of_view: float = 36.0
    ground: float | None = 0.0


def write_playback(
    recording: Recording,
    drawings: Mapping[str, Drawing],
    file: str | Path,
    *,
    plant: Diagram | None = None,
    camera: Camera | None = None,
    gap: float = 1.0,
) -> None:
    """Write the playback of a recording.

    Args:
        recording: what happened.
        drawings: how objects look, by name; objects without one appear in the read-out alone.
        file: where to, ending in `.html`.
        plant: the arm: a finalized plant with its scene graph, posed from the episodes' `plant_positions`.
        camera: view to start with.
        gap: pause between two episodes [s].

    Raises:
        InputError: if a drawing is for no object, the plant doesn't fit the recorded positions, or the file can't be
            written.
    """
    file = Path(file)
    if file.suffix != ".html":
        raise InputError(f"{file}: a playback ends in .html")
    if not file.parent.is_dir():
        raise InputError(f"{file}: there is no folder {file.parent}; create it or give another")
    with quiet():
        meshcat = Meshcat(MeshcatParams(host="127.0.0.1"))
    scene = Scene(meshcat)
    try:
        set_stage(scene, camera if camera is not None else Camera())
        draw_recording(scene, recording, drawings, plant, gap)
        animation = pack_animation(scene.tracks, RATE, round(recording.duration(gap) * RATE))
        page = playback_page(
            meshcat, animation, page_log(recording, drawings, scene, gap), f"{recording.scenario}: playback"
        )
    except Exception as error:
        clear_frames(error.__traceback__)  # who keeps the error keeps no scene: only the main thread may delete that
        raise
    finally:
        del scene, meshcat
    write_whole(file, page)


def draw_recording(
    scene: Scene, recording: Recording, drawings: Mapping[str, Drawing], plant: Diagram | None, gap: float
) -> None:
    """Draw everything, and keep all changes in the scene's tracks.

    Args:
        scene: empty, or with a stage.
        recording, drawings, plant, gap: as of `write_playback`.

    Raises:
        InputError: if a drawing is for no object, or the plant doesn't fit the recorded positions.
    """
    unknown = [name for name in drawings if name not in recording.spaces]
    if unknown:
        raise InputError(f"drawing of {unknown[0]!r}: the recording's objects are {', '.join(recording.spaces)}")
    arm = PlantDrawing(plant) if plant is not None else None
    _check_positions(recording, arm)
    if arm is not None:
        arm.setup(scene.under("plant"))
    for name, drawing in drawings.items():
        drawing.setup(scene.under(name))
    for episode, start in zip(recording.episodes, recording.starts(gap), strict=True):
        _record(scene, episode, start, drawings, arm)


def set_stage(scene: Scene, camera: Camera) -> None:
    """Background, floor and camera."""
    meshcat = scene.meshcat
    meshcat.SetProperty("/Background/<object>", "top_color", [0.80, 0.86, 0.92])
    meshcat.SetProperty("/Background/<object>", "bottom_color", [0.93, 0.94, 0.95])
    meshcat.SetProperty("/Grid", "visible", False)
    meshcat.SetProperty("/Axes", "visible", False)
    # One lamp with shadows, so that one sees what stands on what; the others only fill in.
    meshcat.SetProperty("/Lights/SpotLight", "visible", True)
    meshcat.SetProperty("/Lights/SpotLight/<object>", "position", [-0.9, -1.9, 3.0])
    meshcat.SetProperty("/Lights/SpotLight/<object>", "castShadow", True)
    meshcat.SetProperty("/Lights/SpotLight/<object>", "penumbra", 0.6)
    meshcat.SetProperty("/Lights/SpotLight/<object>", "intensity", 38.0)
    meshcat.SetProperty("/Lights/PointLightNegativeX/<object>", "intensity", 6.0)
    meshcat.SetProperty("/Lights/PointLightPositiveX/<object>", "intensity", 6.0)
    draw_floor(scene, camera)
    meshcat.SetCamera(Meshcat.PerspectiveCamera(fov=camera.field_of_view, near=0.05, far=30.0))
    meshcat.SetCameraPose(camera.position, camera.target)


def draw_floor(scene: Scene, camera: Camera) -> None:
    """The floor, where there is one."""
    if camera.ground is not None:
        # A little below, as tables and objects often end exactly at the ground.
        scene.shape("ground", Box(3.6, 2.4, 0.02), FLOOR, RigidTransform([0.5, 0.1, camera.ground - 0.0115]))


def _check_positions(recording: Recording, arm: PlantDrawing | None) -> None:
    for episode in recording.episodes:
        q = episode.plant_positions
        if arm is not None and q is None:
            raise InputError(f"episode {episode.name}: a plant is to be drawn, but no plant_positions were recorded")
        if arm is not None and q is not None and q.shape[1] != arm.num_positions:
            raise InputError(
                f"episode {episode.name}: plant_positions have {q.shape[1]} columns, the plant {arm.num_positions}"
            )


def _record(
    scene: Scene, episode: RecordedEpisode, start: float, drawings: Mapping[str, Drawing], arm: PlantDrawing | None
) -> None:
    """Keep the changes of one episode."""
    times = start + np.arange(len(episode.times)) / RATE
    parts = {name: scene.under(name) for name in [*drawings, "plant"]}
    for name, drawing in drawings.items():
        if isinstance(drawing, EpisodeDrawing):
            drawing.begin_episode(parts[name], times, episode.states[name], episode.lines.get(name))
    if start > 0:
        # Until just before, everything stands still as the last episode left it.
        scene.hold(start - 1 / RATE)
    for k, time in enumerate(times):
        for name, drawing in drawings.items():
            drawing.update(parts[name], float(time), episode.states[name][k])
        if arm is not None and episode.plant_positions is not None:
            arm.update(parts["plant"], float(time), episode.plant_positions[k])


@contextmanager
def quiet() -> Iterator[None]:
    """Keep Drake from announcing the address of a Meshcat that nobody is to visit."""
    logger = logging.getLogger("drake")
    level = logger.level
    logger.setLevel(logging.WARNING)
    try:
        yield
    finally:
        logger.setLevel(level)
