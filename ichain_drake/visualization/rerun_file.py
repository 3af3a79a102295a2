"""A recording for rerun's viewer (`.rrd`, extra `rerun`): every signal over simulated time, and the scene."""

from __future__ import annotations

import importlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydrake.systems.framework import Diagram

from ichain_drake.errors import InputError
from ichain_drake.files import write_whole
from ichain_drake.visualization.noted_scene import Noted, NotedScene
from ichain_drake.visualization.playback import Camera, draw_floor, draw_recording
from ichain_drake.visualization.recording import RATE, RecordedEpisode, Recording
from ichain_drake.visualization.rerun_scene import ROOT, at, send_scene
from ichain_drake.visualization.scene import Drawing

FloatArray = NDArray[np.float64]
Signal = tuple[str, ...]
"""Where a signal stands: `("measured", "cup", "water")`."""


def require_rerun() -> Any:
    """The module `rerun`.

    Raises:
        InputError: if it is not installed; says what to install.
    """
    try:
        return importlib.import_module("rerun")
    except ImportError as error:
        raise InputError(
            f"a recording for rerun needs {error.name}, which is missing; install it with "
            "`pip install 'ichain_drake[rerun]'`"
        ) from None


def write_rerun(
    recording: Recording,
    drawings: Mapping[str, Drawing],
    file: Path,
    *,
    signals: Sequence[Mapping[Signal, FloatArray]],
    units: Mapping[Signal, str],
    plant: Diagram | None = None,
    camera: Camera | None = None,
    gap: float = 1.0,
) -> None:
    """Write a recording for rerun's viewer.

    The time line is `time`, in simulated seconds; episodes come one after another. What is always there: signals,
    `true/object/variable`, `active/parent->child`, read-outs, and `scene`.

    Args:
        recording: what happened.
        drawings, plant, camera, gap: as of `write_playback`.
        file: where to, ending in `.rrd`.
        signals: of each episode further signals, shape (n,) each, such as what was measured and commanded.
        units: of signals, where they have one.

    Raises:
        InputError: as of `write_playback`, or if the extra is not installed.
    """
    rr = require_rerun()
    if file.suffix != ".rrd":
        raise InputError(f"{file}: a recording for rerun ends in .rrd")
    noted = Noted()
    scene = NotedScene(noted)  # type: ignore[arg-type]
    camera = camera if camera is not None else Camera()
    draw_floor(scene, camera)
    draw_recording(scene, recording, drawings, plant, gap)
    stream = rr.RecordingStream("ichain_drake")
    content = stream.binary_stream()
    stream.send_recording_name(f"{recording.scenario}, {recording.physics}, seed {recording.seed}")
    stream.send_blueprint(_views(recording, camera))
    true_units = {("true", o, v.name): v.unit for o, space in recording.spaces.items() for v in space.variables}
    named: set[str] = set()
    for episode, start, further in zip(recording.episodes, recording.starts(gap), signals, strict=True):
        times = start + np.arange(len(episode.times)) / RATE
        for signal, values in {**_signals(recording, episode), **further}.items():
            entity = str(rr.new_entity_path(list(signal)))
            if entity not in named:
                unit = (true_units | dict(units)).get(signal, "1")
                name = "/".join(signal[1:]) + ("" if unit in ("", "1") else f" [{unit}]")
                stream.log(entity, rr.SeriesLines(names=name), static=True)
                named.add(entity)
            columns = rr.Scalars.columns(scalars=np.asarray(values, dtype=float))
            stream.send_columns(entity, indexes=at(rr, times), columns=columns, strict=True)
        for label, texts in _texts(episode).items():
            changed = np.array([k == 0 or texts[k] != texts[k - 1] for k in range(len(texts))])
            columns = rr.TextLog.columns(text=[t for t, new in zip(texts, changed, strict=True) if new])
            entity = str(rr.new_entity_path(["log", label]))
            stream.send_columns(entity, indexes=at(rr, times[changed]), columns=columns, strict=True)
    send_scene(rr, stream, noted, scene)
    write_whole(file, bytes(content.read() or b""))


def _signals(recording: Recording, episode: RecordedEpisode) -> dict[Signal, FloatArray]:
    """Numbers of an episode that are in the recording itself."""
    found: dict[Signal, FloatArray] = {}
    for name, space in recording.spaces.items():
        for i, variable in enumerate(space.variables):
            if not variable.hidden:
                found["true", name, variable.name] = episode.states[name][:, i]
    found |= {("active", name): flags.astype(float) for name, flags in episode.active.items()}
    return found | {("shown", label): np.asarray(r.values) for label, r in episode.readouts.items() if not r.is_text}


def _texts(episode: RecordedEpisode) -> dict[str, list[str]]:
    """Texts of an episode by label: its name, and read-outs."""
    said = {label: list(r.values) for label, r in episode.readouts.items() if isinstance(r.values, list)}
    return {"episode": [episode.name] * len(episode.times), **said}


def _views(recording: Recording, camera: Camera) -> Any:
    """What the viewer shows at first: the scene, and what was measured of each object."""
    views = importlib.import_module("rerun.blueprint")
    curves = [views.TimeSeriesView(origin=f"/measured/{name}", name=name) for name in recording.spaces]
    eye = views.EyeControls3D(position=camera.position, look_target=camera.target)
    flags = views.TimeSeriesView(origin="/active", name="active")
    return views.Blueprint(
        views.Horizontal(
            views.Spatial3DView(origin=f"/{ROOT}", name="scene", eye_controls=eye),
            views.Vertical(views.Tabs(*curves), flags, views.TextLogView(origin="/log", name="log")),
        )
    )
