"""The commands `run`, `learn` and `graph`."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from ichain_drake.cli.console import Reporter
from ichain_drake.cli.live import shown_live
from ichain_drake.cli.run_files import RunFiles
from ichain_drake.control.planning.format import format_plan
from ichain_drake.control.planning.goal_text import check_goal_text
from ichain_drake.control.planning.plan import Plan
from ichain_drake.errors import InputError, UnreachableError
from ichain_drake.files import held
from ichain_drake.graph import write_drawing
from ichain_drake.runs.goals.run import GraphRun, own_goal
from ichain_drake.runs.goals.unlabelled import Taught
from ichain_drake.runs.learn import Known
from ichain_drake.runs.library import load
from ichain_drake.runs.open_piece import save_left_behind
from ichain_drake.runs.output import write_pictures_of, write_playback_of, write_rerun_of
from ichain_drake.runs.paths.choice import choose_paths
from ichain_drake.runs.paths.output import write_report
from ichain_drake.runs.paths.result import PathRun
from ichain_drake.runs.pieces import check_settings
from ichain_drake.runs.run import carry_out, start_run
from ichain_drake.scenarios import PathScenario, Scenario, build_world


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


def known_of(scenario: Scenario, library: Path | None, *, lift: bool = False) -> Known | None:
    """What a library knows of a scenario's graph; arguments as the command has them.

    Raises:
        InputError: if it is none, empty or damaged; if something is to be lifted out of no library.
    """
    if lift and library is None:
        raise InputError("--lift is for --library: it lifts what that knows of one object to all of its type")
    if library is None:
        return None
    check_filled(library)
    return load(library, scenario, lift=lift)


def goal_of(scenario: Any, expressions: Sequence[str]) -> tuple[str, ...]:
    """The goal asked for, or the scenario's own.

    Raises:
        InputError: if there is neither, or it can't be read.
    """
    goal = tuple(expressions) or own_goal(scenario)
    if not goal:
        raise InputError(f"{scenario.name} has no goal of its own; give one with --goal 'object.variable >= value'")
    check_goal_text(goal, scenario.graph)
    return goal


def taught_by(scenario: Scenario, taught: Taught) -> Taught:
    """What demonstrations say beside states, as the command line has it.

    Raises:
        InputError: on options that are not for a scenario that follows paths, and on a graph that can't be read.
    """
    if isinstance(scenario, PathScenario) and taught != Taught():
        raise InputError(f"{scenario.name} follows paths: its links need no flags, and its chain is its own")
    taught.graph(scenario.graph)
    return taught


def asked_for(
    scenario: Scenario,
    goal: Sequence[str],
    path: Sequence[Path],
    paths: Sequence[str],
    *,
    smooth: bool,
    taught: Taught,
) -> PathRun | GraphRun:
    """The run that the command line asks for: towards a goal, or along paths.

    Args:
        scenario: what runs.
        goal, path, paths, smooth, taught: as the command's options.

    Raises:
        InputError: on options that are for the other kind, and on goals or paths that can't be.
    """
    name = scenario.name
    if not isinstance(scenario, PathScenario):
        if path or paths:
            raise InputError(f"{name} is asked for a goal: --path and --paths are not for it")
        run = start_run(scenario, goal_of(scenario, goal))
        assert isinstance(run, GraphRun)
        run.taught = taught
        return run
    if goal:
        raise InputError(f"{name} follows paths: give --path or --paths, not --goal")
    if smooth and not path:
        raise InputError("--smooth is for --path: reference paths are smooth")
    if path and paths:
        raise InputError("--path and --paths: give one of the two")
    return start_run(scenario, choose_paths(scenario, paths, path), smooth=smooth)


def robot_asked_for(run: PathRun | GraphRun, address: str, *, oracle: bool, meshcat: bool) -> str:
    """The address of the robot that a run drives; empty for a world of its own.

    Raises:
        InputError: on what a robot elsewhere can't do.
    """
    if address and isinstance(run, PathRun) and len(run.paths) > 1:
        raise InputError("--robot: it can't be put back to a start; give one path with --paths NAME or --path FILE")
    if address and meshcat:
        raise InputError("--robot: --meshcat shows a world in this process; look at the playback afterwards")
    if address and oracle:
        raise InputError("--robot: the oracle needs the true model of a world in this process; leave --oracle out")
    return address


def run_scenario(
    run: PathRun | GraphRun,
    files: RunFiles,
    read: Sequence[Path],
    demos: Path | None,
    library: Path | None,
    *,
    oracle: bool = True,
    lift: bool = False,
    resampled: bool = False,
    meshcat: bool = False,
    realtime: bool = False,
) -> int:
    """`ichain run`; what the library knows of the scenario's graph is not recorded or learned again.

    Args:
        run: to be carried out.
        files: where it writes.
        read: files that it reads.
        demos, library, oracle, lift, resampled, meshcat, realtime: as the command's options.

    Returns:
        The exit status: 0 if the goal was reached or every path completed, else 1; 130 if interrupted.

    Raises:
        InputError: on bad input.
        UnreachableError: if the arm can't get where it has to; the report is written first.
    """
    files.check_apart(read)
    check_settings(run.scenario)
    check_there(demos)
    scenario: Any = run.scenario
    known = known_of(scenario, library, lift=lift)
    files.prepare()
    interrupted, unreachable = False, None
    with (
        held(files.folder),
        Reporter() as say,
        shown_live(scenario, say, meshcat=meshcat, realtime=realtime) as (live, tell),
    ):
        for earlier in sorted(files.folder.glob("demonstrations*")):
            save_left_behind(earlier, scenario.graph, say.note)
        try:
            keep = files.demonstrations
            carry_out(run, known=known, demos=demos, keep_demos=keep, oracle=oracle, resampled=resampled, progress=tell)
        except KeyboardInterrupt:
            interrupted = True
        except UnreachableError as error:
            unreachable = error
        tell("writing report, playback and pictures")
        written = _write_all(run, files, {} if live is None else {"live": live.report()})
    if files.report != "-":
        _print_results(run, written)
    if interrupted:
        print("ichain: interrupted; what was done so far is kept", file=sys.stderr)
        return 130
    if unreachable is not None:
        raise unreachable
    return 0 if run.goal_reached else 1


def _write_all(run: PathRun | GraphRun, files: RunFiles, extra: dict[str, Any]) -> list[Path]:
    """Report first: it is small and says most."""
    written: list[Path] = []
    report = run.report() | extra
    if files.report == "-":
        print(json.dumps(report, indent=2, allow_nan=False))
    else:
        file = Path(files.report) if files.report else files.folder / "report.json"
        write_report(report, file)
        written.append(file)
    written += write_playback_of(run, files.playback)
    written += [] if files.rerun is None else write_rerun_of(run, files.rerun)
    return [*written, *write_pictures_of(run, files.folder)]


def _print_results(run: PathRun | GraphRun, written: list[Path]) -> None:
    if isinstance(run, PathRun):
        Console().print(_paths_table(run))
        print(f"{run.reason}; {run.scenario.name}, {run.scenario.physics} physics, seed {run.scenario.seed}")
    else:
        if isinstance(run.plan, Plan):
            print(format_plan(run.plan, run.scenario.graph))
        steps, replans = (0, 0) if run.memory is None else (run.memory.tick, run.memory.replans)
        print(f"{run.reason}; {steps} control steps, {replans} replans")
        if run.advice is not None:
            print(run.advice.text(run.scenario.graph))
    for file in written:
        print(f"written: {file}")


def _paths_table(run: PathRun) -> Table:
    unit = run.scenario.unit
    known = any(not math.isnan(result.oracle_error) for result in run.results)
    oracle = [f"oracle ({unit})"] if known else []
    table = Table("path", "completed", f"mean error ({unit})", *oracle, f"paper's metric ({unit})", box=None)
    for result in run.results:
        oracle = [f"{result.oracle_error:.3f}".replace("nan", "")] if known else []
        done = "yes" if result.completed else "no"
        table.add_row(result.name, done, f"{result.error:.3f}", *oracle, f"{result.paper_metric:.3f}")
    return table


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
