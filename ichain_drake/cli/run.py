"""The commands `run`, `learn` and `graph`."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import cached_property
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table
from threadpoolctl import threadpool_limits

from ichain_drake.cli.console import Reporter
from ichain_drake.cli.live import shown_live
from ichain_drake.cli.options import command_said
from ichain_drake.errors import InputError, UnreachableError
from ichain_drake.files import held, real_path, unused_folder
from ichain_drake.graph import write_drawing
from ichain_drake.runs.paths.choice import choose_paths
from ichain_drake.runs.paths.demonstrations import read_for
from ichain_drake.runs.paths.output import (
    prepare_file,
    prepare_folder,
    write_pictures,
    write_recording,
    write_report,
)
from ichain_drake.runs.paths.result import PathRun
from ichain_drake.runs.paths.run import check_settings, recorded_seconds, run_paths
from ichain_drake.runs.provenance import data_hash, versions
from ichain_drake.scenarios import PathScenario, Scenario, build_world


@dataclass(frozen=True)
class RunFiles:
    """Where a run writes.

    Attributes:
        folder: for whatever is not named below.
        record: the playback; default `playback.html` in the folder.
        report: the report; `-` for stdout; default `report.json` in the folder.
    """

    folder: Path
    record: Path | None = None
    report: str | None = None

    @property
    def playback(self) -> Path:
        """File of the playback."""
        return self.record or self.folder / "playback.html"

    @cached_property
    def demonstrations(self) -> Path:
        """Folder for what is recorded; that of an earlier run is left as it is."""
        return unused_folder(self.folder / "demonstrations")

    def check_apart(self, read: Sequence[Path] = ()) -> None:
        """See that nothing is written twice, or over what is read.

        Args:
            read: files that the run reads.

        Raises:
            InputError: naming the file.
        """
        if self.record is not None and self.record.suffix != ".html":
            raise InputError(f"--record {self.record}: a playback ends in .html")
        seen = {real_path(file): "is what the run reads" for file in read}
        report = [] if self.report == "-" else [Path(self.report) if self.report else self.folder / "report.json"]
        for file in (self.playback, *report, self.folder / "paths.png", self.folder / "timeline.png"):
            place = real_path(file)
            if place in seen:
                raise InputError(f"{file}: {seen[place]}; give another name for what is written")
            if file.suffix in (".parquet", ".csv"):
                raise InputError(f"{file}: is named like a table, and what is written there is none; give another name")
            seen[place] = "is where something else of this run is written"

    def prepare(self) -> None:
        """Make sure that everything can be written before the work starts.

        Raises:
            InputError: naming the folder or file that can't.
        """
        prepare_folder(self.folder)
        for file in (self.playback, self.folder / "paths.png", self.folder / "timeline.png"):
            prepare_file(file)
        if self.report != "-":
            prepare_file(Path(self.report) if self.report else self.folder / "report.json")


def check_there(demos: Path | None) -> None:
    """Refuse demonstrations that are not there, before anything is written.

    Raises:
        InputError: naming the folder.
    """
    if demos is not None and not demos.exists():
        raise InputError(f"{demos}: no such folder of demonstrations")


def check_filled(library: Path) -> None:
    """Refuse a library in which there is nothing: everything would be recorded and learned anew, unasked.

    Raises:
        InputError: if it is none, or empty.
    """
    from ichain_drake.learning.library.files import item_folders

    if not item_folders(library):
        raise InputError(f"{library}: holds no interactions; `ichain learn` makes a library, or leave --library out")


def run_path_scenario(
    scenario: PathScenario,
    files: RunFiles,
    path: Sequence[Path],
    names: list[str],
    demos: Path | None,
    library: Path | None,
    *,
    oracle: bool,
    resampled: bool = False,
    smooth: bool = False,
    meshcat: bool = False,
    realtime: bool = False,
) -> int:
    """`ichain run` for a scenario that follows paths.

    Returns:
        The exit status: 0 if every path was completed, else 1; 130 if interrupted.

    Raises:
        InputError: on bad input.
        UnreachableError: if the arm can't get where it has to; the report is written first.
    """
    if path and names:
        raise InputError("--path and --paths: give one of the two")
    files.check_apart(path)
    chosen = choose_paths(scenario, names, path)
    check_settings(scenario)
    check_there(demos)
    started = PathRun(scenario, chosen, smooth=smooth)
    known, command = None, None
    if library is not None:
        from ichain_drake.learning.library import load_command, load_links

        check_filled(library)
        command = load_command(library, scenario.graph, scenario.graph.chain(scenario.target))
        known = load_links(library, scenario.graph, scenario.graph.chain(scenario.target), scenario.target_variables)
    files.prepare()
    interrupted, unreachable = False, None
    with (
        held(files.folder),
        Reporter() as say,
        shown_live(scenario, say, meshcat=meshcat, realtime=realtime) as (live, tell),
    ):
        try:
            run_paths(
                started,
                demos=demos,
                keep_demos=files.demonstrations,
                known=known,
                known_command=command,
                oracle=oracle,
                resampled=resampled,
                progress=tell,
            )
        except KeyboardInterrupt:
            interrupted = True
        except UnreachableError as error:
            unreachable = error
        tell("writing report, playback and pictures")
        written = _write_all(started, files, {} if live is None else {"live": live.report()})
    if files.report != "-":
        _print_results(started, written)
    if interrupted:
        print("ichain: interrupted; what was done so far is kept", file=sys.stderr)
        return 130
    if unreachable is not None:
        raise unreachable
    return 0 if started.goal_reached else 1


def _write_all(run: PathRun, files: RunFiles, extra: dict[str, Any]) -> list[Path]:
    """Report first: it is small and says most."""
    written: list[Path] = []
    report = run.report() | extra
    if files.report == "-":
        print(json.dumps(report, indent=2, allow_nan=False))
    else:
        file = Path(files.report) if files.report else files.folder / "report.json"
        write_report(report, file)
        written.append(file)
    if run.results:
        write_recording(run, files.playback)
        written.append(files.playback)
        written += write_pictures(run, files.folder)
    return written


def _print_results(run: PathRun, written: list[Path]) -> None:
    unit = run.scenario.unit
    known = any(not math.isnan(result.oracle_error) for result in run.results)
    oracle = [f"oracle ({unit})"] if known else []
    table = Table("path", "completed", f"mean error ({unit})", *oracle, f"paper's metric ({unit})", box=None)
    for result in run.results:
        oracle = [f"{result.oracle_error:.3f}".replace("nan", "")] if known else []
        done = "yes" if result.completed else "no"
        table.add_row(result.name, done, f"{result.error:.3f}", *oracle, f"{result.paper_metric:.3f}")
    Console().print(table)
    print(f"{run.reason}; {run.scenario.name}, {run.scenario.physics} physics, seed {run.scenario.seed}")
    for file in written:
        print(f"written: {file}")


def learn_library(scenario: PathScenario, demos: Path, library: Path, *, resampled: bool = False) -> None:
    """`ichain learn`: learn all links from demonstrations and save them.

    Raises:
        InputError: on bad demonstrations, or a library that can't be written.
    """
    from ichain_drake.learning.chain.chain import learn_chain
    from ichain_drake.learning.library import save_chain

    check_settings(scenario)
    with Reporter() as say:
        pieces = read_for(scenario, demos, resampled=resampled, say=say.note)
        prepare_folder(library)
        seconds = recorded_seconds(pieces, scenario.graph)
        candidates = scenario.config.learning.candidates()
        with threadpool_limits(limits=1):  # as in a run, so that the same demonstrations give the same models
            chain = learn_chain(
                pieces, scenario.graph, scenario.target, scenario.target_variables, candidates, seconds, say
            )
    save_chain(chain, library, scenario.name, data_hash(pieces))
    for link in chain.links:
        forward = link.forward
        print(f"{link.interaction.name}: {forward.samples} samples, score {forward.score:.4f}, {forward.spec}")


def draw_graph(scenario: Scenario, file: Path | None, *, diagram: bool) -> str:
    """`ichain graph`: draw into a file, or give text.

    Returns:
        What to print.

    Raises:
        InputError: on an unknown ending, or without Graphviz for a rendered one.
    """
    if diagram:
        world = build_world(scenario)
        dot, text = world.GetGraphvizString(max_depth=1), "\n".join(s.get_name() for s in world.GetSystems())
    else:
        dot, text = scenario.graph.dot(), scenario.graph.text()
    if file is None:
        return text
    write_drawing(dot, file)
    return f"written: {file}"


def printed(text: str) -> dict[str, Any]:
    """What a report says of its table, so that pages can show it: the text, the command, the date and the versions.

    Args:
        text: of the table.
    """
    date = datetime.now(UTC).date().isoformat()
    return {"text": text, "command": command_said(), "date": date, "versions": versions()}


def deliver_report(report: dict[str, Any], file: str | None, text: str) -> None:
    """Print a table and write the report beside it; `-` prints the JSON to stdout and nothing else.

    Raises:
        InputError: if the file can't be written.
    """
    if file == "-":
        print(json.dumps(report, indent=2, allow_nan=False))
        return
    print(text)
    if file is not None:
        write_report(report, Path(file))
        print(f"written: {file}")
