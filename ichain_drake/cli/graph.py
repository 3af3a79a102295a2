"""The commands `run` and `plan` for scenarios that are asked for a goal over their interaction graph."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

from ichain_drake.cli.console import Reporter
from ichain_drake.cli.run import RunFiles
from ichain_drake.control.graph.format import format_plan
from ichain_drake.control.graph.plan import Plan
from ichain_drake.demonstrations import read_demonstrations
from ichain_drake.errors import InputError
from ichain_drake.scenarios.graph_run import GraphRun, learn_graph, look, make_plan, run_graph
from ichain_drake.scenarios.path_output import write_report
from ichain_drake.visualization import write_playback


def _goal(scenario: Any, expressions: list[str]) -> tuple[str, ...]:
    """The goal asked for, or the scenario's own.

    Raises:
        InputError: if there is neither.
    """
    goal = tuple(expressions or getattr(scenario.config, "goal", ()))
    if not goal:
        raise InputError(f"{scenario.name} has no goal of its own; give one with --goal 'object.variable >= value'")
    return goal


def run_goal_scenario(scenario: Any, files: RunFiles, expressions: list[str], demos: Path | None) -> int:
    """`ichain run` for a scenario with a goal.

    Returns:
        The exit status: 0 if the goal was reached, else 1; 130 if interrupted.

    Raises:
        InputError: on bad input.
    """
    run = GraphRun(scenario, _goal(scenario, expressions))
    files.prepare()
    interrupted = False
    with Reporter() as say:
        try:
            run_graph(run, demos=demos, keep_demos=files.folder / "demonstrations", progress=say)
        except KeyboardInterrupt:
            interrupted = True
        say("writing report and playback")
        report = run.report()
        if files.report == "-":
            print(json.dumps(report, indent=2, allow_nan=False))
        else:
            file = Path(files.report) if files.report else files.folder / "report.json"
            write_report(report, file)
        if run.log is not None and len(run.log.times) > 1:
            write_playback(run.recording(), scenario.drawings(), files.playback, plant=scenario.drawn_plant())
    if files.report != "-":
        if isinstance(run.plan, Plan):
            print(format_plan(run.plan, scenario.graph))
        print(f"{run.reason}; {report['control_steps']} control steps, {report['metrics']['replans']} replans")
        print(f"written: {file}")
        if run.log is not None:
            print(f"written: {files.playback}")
    if interrupted:
        print("ichain: interrupted; what was done so far is kept", file=sys.stderr)
        return 130
    return 0 if run.goal_reached else 1


def print_plan(scenario: Any, expressions: list[str], demos: Path | None) -> int:
    """`ichain plan`: learn, look, plan, print.

    Returns:
        The exit status: 0 with a plan, 1 without.

    Raises:
        InputError: on bad input.
    """
    goal = _goal(scenario, expressions)
    with Reporter() as say:
        if demos is None:
            say("recording demonstrations")
            pieces = list(scenario.record_demonstrations(say))
        else:
            pieces = read_demonstrations(demos, scenario.graph)
        say("learning the graph")
        knowledge = learn_graph(pieces, scenario.graph)
        start = look(scenario)
        say("planning")
        _, plan = make_plan(knowledge, goal, start)
    if isinstance(plan, Plan):
        print(format_plan(plan, scenario.graph, start))
        return 0
    print(plan.reason)
    return 1
