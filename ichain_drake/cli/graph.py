"""The commands `run`, `plan` and `learn` for scenarios that are asked for a goal over their interaction graph."""

from __future__ import annotations

import json
import sys
from collections.abc import Collection, Sequence
from pathlib import Path
from typing import Any

from ichain_drake.cli.console import Reporter
from ichain_drake.cli.live import shown_live
from ichain_drake.cli.run import RunFiles, check_filled, check_there
from ichain_drake.control.planning.format import format_plan
from ichain_drake.control.planning.goal_text import check_goal_text
from ichain_drake.control.planning.plan import Plan
from ichain_drake.demonstrations import Demonstration
from ichain_drake.demonstrations.quality import tell_findings
from ichain_drake.errors import InputError
from ichain_drake.files import held
from ichain_drake.graph import Interaction
from ichain_drake.learning import read_pieces
from ichain_drake.learning.library import LibraryParts
from ichain_drake.runs.goals.knowledge import Knowledge, learn_graph, learn_rest
from ichain_drake.runs.goals.library import load_what_fits, save_knowledge
from ichain_drake.runs.goals.output import write_graph_pictures, write_graph_recording
from ichain_drake.runs.goals.plan import make_plan
from ichain_drake.runs.goals.run import GraphRun, own_goal, run_graph
from ichain_drake.runs.goals.settings import graph_spec
from ichain_drake.runs.paths.output import prepare_folder, write_report
from ichain_drake.simulation.goal_episode import look


def _goal(scenario: Any, expressions: list[str]) -> tuple[str, ...]:
    """The goal asked for, or the scenario's own.

    Raises:
        InputError: if there is neither, or it can't be read.
    """
    goal = tuple(expressions) or own_goal(scenario)
    if not goal:
        raise InputError(f"{scenario.name} has no goal of its own; give one with --goal 'object.variable >= value'")
    check_goal_text(goal, scenario.graph)
    return goal


def _known(scenario: Any, library: Path | None) -> Knowledge | LibraryParts:
    """What the library knows of the scenario's graph: all of it, or each interaction that fits."""
    if library is None:
        return LibraryParts()
    check_filled(library)
    return load_what_fits(library, scenario.name, scenario.graph)


def run_goal_scenario(
    scenario: Any,
    files: RunFiles,
    expressions: list[str],
    demos: Path | None,
    library: Path | None = None,
    *,
    resampled: bool = False,
    meshcat: bool = False,
    realtime: bool = False,
) -> int:
    """`ichain run` for a scenario with a goal; what the library knows of its graph is not recorded or learned again.

    Returns:
        The exit status: 0 if the goal was reached, else 1; 130 if interrupted.

    Raises:
        InputError: on bad input.
    """
    run = GraphRun(scenario, _goal(scenario, expressions))
    graph_spec(scenario.config)  # refuses what is not for it, before anything is written
    files.check_apart()
    known = _known(scenario, library)
    check_there(demos)
    files.prepare()
    interrupted = False
    with (
        held(files.folder),
        Reporter() as say,
        shown_live(scenario, say, meshcat=meshcat, realtime=realtime) as (live, tell),
    ):
        try:
            keep = files.demonstrations
            run_graph(run, demos=demos, keep_demos=keep, knowledge=known, resampled=resampled, progress=tell)
        except KeyboardInterrupt:
            interrupted = True
        tell("writing report, playback and pictures")
        report = run.report() | ({} if live is None else {"live": live.report()})
        if files.report == "-":
            print(json.dumps(report, indent=2, allow_nan=False))
        else:
            file = Path(files.report) if files.report else files.folder / "report.json"
            write_report(report, file)
        shown = write_graph_recording(run, files.playback) + write_graph_pictures(run, files.folder)
    if files.report != "-":
        if isinstance(run.plan, Plan):
            print(format_plan(run.plan, scenario.graph))
        print(f"{run.reason}; {report['control_steps']} control steps, {report['metrics']['replans']} replans")
        print(f"written: {file}")
        for written in shown:
            print(f"written: {written}")
    if interrupted:
        print("ichain: interrupted; what was done so far is kept", file=sys.stderr)
        return 130
    return 0 if run.goal_reached else 1


def print_plan(
    scenario: Any,
    expressions: list[str],
    demos: Path | None,
    library: Path | None = None,
    *,
    resampled: bool = False,
    explain: bool = False,
) -> int:
    """`ichain plan`: learn (what the library doesn't know of the graph), look, plan, print.

    Returns:
        The exit status: 0 with a plan, 1 without.

    Raises:
        InputError: on bad input.
    """
    goal = _goal(scenario, expressions)
    spec = graph_spec(scenario.config)
    knowledge = _known(scenario, library)
    check_there(demos)
    with Reporter() as say:

        def show(known: Collection[Interaction]) -> Sequence[Demonstration]:
            if demos is not None:
                pieces = read_pieces(demos, scenario.graph, known, resampled=resampled, say=say.note)
                tell_findings(pieces, scenario.graph, say.note)
                return pieces
            say("recording demonstrations")
            return list(scenario.record_demonstrations(say, [e.name for e in known]))

        if isinstance(knowledge, LibraryParts):
            knowledge = learn_rest(show, scenario.graph, knowledge, spec, say=say)
        start = look(scenario)
        say("planning")
        _, plan = make_plan(knowledge, goal, start)
    if isinstance(plan, Plan):
        print(format_plan(plan, scenario.graph, start, likely=explain))
        return 0
    print("\n".join([plan.reason, *(plan.tree if explain else ())]))
    return 1


def learn_graph_library(scenario: Any, demos: Path, library: Path, *, resampled: bool = False) -> None:
    """`ichain learn`: learn the whole graph from demonstrations and save it.

    Raises:
        InputError: on bad demonstrations, or a library that can't be written.
    """
    spec = graph_spec(scenario.config)
    with Reporter() as say:
        pieces = read_pieces(demos, scenario.graph, resampled=resampled, say=say.note)
        tell_findings(pieces, scenario.graph, say.note)
        prepare_folder(library)
        say(f"learning from {len(pieces)} pieces")
        knowledge = learn_graph(pieces, scenario.graph, spec)
    save_knowledge(knowledge, pieces, library, scenario.name)
    names = scenario.graph.objects
    for edge, learned in knowledge.model.edges.items():
        changed = ", ".join(names[edge.child].observable.names[e.variable] for e in learned.effects) or "nothing seen"
        status = learned.status
        line = f"{edge.name}: {status.samples} samples, F1 {status.score:.4f}, {status.estimator}; changes {changed}"
        customary = f"; customary: {', '.join(learned.customary.labels)}" if learned.customary.labels else ""
        print(line + customary)
