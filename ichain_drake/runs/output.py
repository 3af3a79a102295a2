"""What a run leaves behind, for paths and goals alike."""

from __future__ import annotations

from pathlib import Path

from ichain_drake.runs.goals.output import write_graph_pictures, write_graph_recording
from ichain_drake.runs.goals.run import GraphRun
from ichain_drake.runs.paths.output import write_pictures, write_recording
from ichain_drake.runs.paths.result import PathRun


def write_playback_of(run: PathRun | GraphRun, file: Path) -> list[Path]:
    """The playback, if there is anything to play; returns the file then, in a list.

    Raises:
        InputError: if it can't be written.
    """
    return write_recording(run, file) if isinstance(run, PathRun) else write_graph_recording(run, file)


def write_pictures_of(run: PathRun | GraphRun, folder: Path) -> list[Path]:
    """Pictures of what was done, into a folder; returns their files.

    Raises:
        InputError: if they can't be written.
    """
    return write_pictures(run, folder) if isinstance(run, PathRun) else write_graph_pictures(run, folder)
