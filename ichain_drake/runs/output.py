"""What a run leaves behind, for paths and goals alike."""

from __future__ import annotations

from pathlib import Path

from ichain_drake.graph import InteractionGraph
from ichain_drake.runs.goals.output import make_graph_recording, write_graph_pictures, write_graph_recording
from ichain_drake.runs.goals.run import GraphRun
from ichain_drake.runs.paths.output import make_recording, write_pictures, write_recording
from ichain_drake.runs.paths.result import PathRun
from ichain_drake.simulation.episode import EpisodeLog
from ichain_drake.state import FloatArray
from ichain_drake.visualization.rerun_file import Signal, write_rerun


def write_playback_of(run: PathRun | GraphRun, file: Path) -> list[Path]:
    """The playback, if there is anything to play; returns the file then, in a list.

    Raises:
        InputError: if it can't be written.
    """
    return write_recording(run, file) if isinstance(run, PathRun) else write_graph_recording(run, file)


def write_rerun_of(run: PathRun | GraphRun, file: Path) -> list[Path]:
    """The recording for rerun, if there is anything to play; returns the file then, in a list.

    Beside what the playback shows it has what the controller got and gave: `measured/object/variable` and
    `command/variable`, at every frame.

    Raises:
        InputError: if it can't be written, or the extra is not installed.
    """
    if isinstance(run, PathRun):
        logs = [result.log for result in run.results]
    else:
        logs = [] if run.log is None or len(run.log.times) < 2 else [run.log]  # noqa: PLR2004
    if not logs:
        return []
    scenario, graph = run.scenario, run.scenario.graph
    units: dict[Signal, str] = {("command", v.name): v.unit for v in graph.command.variables}
    for name, space in graph.objects.items():
        units |= {("measured", name, v.name): v.unit for v in space.observable.variables}
    write_rerun(
        make_recording(run) if isinstance(run, PathRun) else make_graph_recording(run),
        scenario.drawings(),
        file,
        signals=[_got_and_given(log, graph) for log in logs],
        units=units,
        plant=scenario.drawn_plant(),
        camera=scenario.view(),
    )
    return [file]


def _got_and_given(log: EpisodeLog, graph: InteractionGraph) -> dict[Signal, FloatArray]:
    """What sensors gave, and what was commanded."""
    found: dict[Signal, FloatArray] = {}
    for name, space in graph.objects.items():
        for i, variable in enumerate(space.observable.names):
            found["measured", name, variable] = log.measured[name][:, i]
    hand = graph.command.names
    return found | {("command", variable): log.command[:, i] for i, variable in enumerate(hand)}


def write_pictures_of(run: PathRun | GraphRun, folder: Path) -> list[Path]:
    """Pictures of what was done, into a folder; returns their files.

    Raises:
        InputError: if they can't be written.
    """
    return write_pictures(run, folder) if isinstance(run, PathRun) else write_graph_pictures(run, folder)
