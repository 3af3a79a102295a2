"""What a path run leaves behind: report, recording, playback and pictures."""

from __future__ import annotations

import json
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from ichain_drake.errors import InputError
from ichain_drake.files import is_folder, reason_of, write_whole
from ichain_drake.runs.paths.result import PathResult, PathRun
from ichain_drake.state import FloatArray
from ichain_drake.visualization import Readout, RecordedEpisode, Recording, Strip, plot_paths, write_playback


def prepare_folder(folder: Path) -> None:
    """Make a folder and try to write in it, before minutes of work go into it.

    Raises:
        InputError: if it can't be made or written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=folder, prefix=".ichain-"):
            pass
    except (OSError, ValueError) as error:
        raise InputError(f"{folder}: can't write there ({reason_of(error)}); give a writable folder") from None


def prepare_file(file: Path) -> None:
    """Make a file's folder and see that it can be written to, before minutes of work go into it.

    Raises:
        InputError: if the folder can't be made or written, or a folder has the file's name.
    """
    if is_folder(file):
        raise InputError(f"{file}: is a folder; give the name of a file")
    if not _is_special(file):
        prepare_folder(file.parent)


def _is_special(file: Path) -> bool:
    """Whether it is a device or a pipe: such a one is written into, never replaced."""
    try:
        return file.exists() and not file.is_file() and not file.is_dir()
    except (OSError, ValueError) as error:
        raise InputError(f"{file}: can't be looked at ({reason_of(error)}); give another name") from None


def write_report(report: dict[str, Any], file: Path) -> None:
    """Write a report as JSON, whole or not at all; a device or pipe is written into.

    Raises:
        InputError: if the file can't be written.
    """
    content = (json.dumps(report, indent=2, allow_nan=False) + "\n").encode()
    if not _is_special(file):
        write_whole(file.resolve(), content)  # a link stays a link
        return
    try:
        file.write_bytes(content)
    except OSError as error:
        raise InputError(f"{file}: can't write the report: {error.strerror or error}") from None


def make_recording(run: PathRun) -> Recording:
    """Everything that the playback shows.

    Raises:
        InputError: if nothing was recorded.
    """
    scenario = run.scenario
    return Recording(
        scenario.name,
        scenario.physics,
        scenario.seed,
        dict(scenario.shown()),
        tuple(_episode(run, result) for result in run.results),
        scenario.graph.interactions,
    )


def executed_path(run: PathRun, result: PathResult) -> FloatArray:
    """Executed positions of the followed object, shape (n, 2)."""
    space = run.scenario.graph.objects[run.scenario.target]
    return result.log.states[run.scenario.target][:, [space.index(v) for v in run.scenario.target_variables]]


def _episode(run: PathRun, result: PathResult) -> RecordedEpisode:
    scenario, log = run.scenario, result.log
    off = cKDTree(result.path.points).query(executed_path(run, result))[0]
    mean = np.cumsum(off) / np.arange(1, len(off) + 1)
    readouts = {
        "distance to path": Readout(off, scenario.unit),
        "mean error": Readout(mean, scenario.unit),
        "path completed": Readout([_progress(result, i) for i in range(len(off))]),
    }
    flags = {
        e.name: log.active[e.child][:, scenario.graph.parents(e.child).index(e.parent)] > 0.5  # noqa: PLR2004 - a flag
        for e in scenario.graph.interactions
    }
    position = executed_path(run, result)
    strips = {"distance to path": Strip(off, scenario.unit)} | {
        f"{scenario.target} {v}": Strip(position[:, i], scenario.unit) for i, v in enumerate(scenario.target_variables)
    }
    lines = {scenario.target: result.path.points}
    graph = scenario.graph
    states = {n: log.states[n][:, graph.objects[n].indices(space.names)] for n, space in scenario.shown().items()}
    return RecordedEpisode(result.name, log.times, states, log.plant_positions, readouts, lines, flags, strips)


def _progress(result: PathResult, row: int) -> str:
    progress = result.log.extra.get("progress")
    if progress is None:
        return ""
    return f"{100 * float(progress[row, 0]) / (len(result.path.points) - 1):.0f} %"


def write_pictures(run: PathRun, folder: Path) -> list[Path]:
    """Commanded against executed paths, as `paths.png`.

    Raises:
        InputError: if the file can't be written.
    """
    if not run.results:
        return []
    file = folder / "paths.png"
    plot_paths(
        file,
        {r.name: r.path.points for r in run.results},
        {r.name: executed_path(run, r) for r in run.results},
        errors={r.name: r.error for r in run.results},
        unit=run.scenario.unit,
        y_down=run.scenario.y_down,
    )
    return [file]


def write_recording(run: PathRun, file: Path) -> list[Path]:
    """Write the playback, if there is anything to play.

    Raises:
        InputError: if the file can't be written.
    """
    if not run.results:
        return []
    scenario = run.scenario
    write_playback(make_recording(run), scenario.drawings(), file, plant=scenario.drawn_plant(), camera=scenario.view())
    return [file]
