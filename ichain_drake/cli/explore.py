"""The command `explore`."""

from __future__ import annotations

from pathlib import Path

import click

from ichain_drake.cli.options import PATH, options, scenario_named
from ichain_drake.errors import InputError


@click.command()
@options("scenario", "seed")
@click.option("-o", "--output", type=PATH, metavar="DIR", required=True, help="folder for pieces, graph and report")
@click.option("--physics", default="ideal", show_default=True, help="ideal or arm")
@click.option("--goal", metavar="EXPR", multiple=True, help="that it is to reach in the end; default the system's own")
@click.option("--no-goal", is_flag=True, help="only the graph")
@click.option("--budget", type=float, metavar="SECONDS", help="that the robot may move; default 600")
@click.option("--confidence", type=float, metavar="P", help="from which on an interaction is known; default 0.95")
@options("settings")
def explore(
    scenario: str,
    seed: int,
    output: Path,
    physics: str,
    goal: tuple[str, ...],
    no_goal: bool,
    budget: float | None,
    confidence: float | None,
    settings: tuple[str, ...],
) -> int:
    """Let the robot find out by itself which objects act on which: it tries what would tell most.

    Exit status 0 if the graph is known and the goal was reached, 1 if the budget was spent before.
    """
    from ichain_drake.cli.console import Reporter
    from ichain_drake.cli.run import goal_of
    from ichain_drake.demonstrations import write_demonstrations
    from ichain_drake.files import held, unused_folder
    from ichain_drake.learning.discovery.graph_file import write_graph
    from ichain_drake.runs.exploring.explore import Exploration
    from ichain_drake.runs.exploring.explore import explore as carry_out
    from ichain_drake.runs.exploring.settings import settings_for
    from ichain_drake.runs.paths.output import prepare_folder, write_report
    from ichain_drake.scenarios import PathScenario

    if physics == "contact":
        raise InputError("explore: ways of the hand are straight, and would strike things; choose ideal or arm")
    if no_goal and goal:
        raise InputError("--goal and --no-goal: give one of the two")
    loaded = scenario_named(scenario, settings, physics, seed)
    if goal and isinstance(loaded, PathScenario):
        raise InputError(f"{loaded.name} follows paths: --goal is not for it")
    asked = goal_of(loaded, goal) if goal else () if no_goal else None
    run = Exploration(loaded, asked, settings_for(budget, confidence))
    prepare_folder(output)
    pieces = unused_folder(output / "pieces")
    interrupted = False
    with held(output), Reporter() as say:
        try:
            carry_out(run, say.note)
        except KeyboardInterrupt:
            interrupted = True
    reached = unused_folder(output / "reached") if run.successes else pieces
    for file in (*write_demonstrations(run.pieces, pieces), *write_demonstrations(run.successes, reached)):
        print(f"written: {file}")
    if run.found is not None:
        write_graph(run.found, output / "graph.yaml")
        print(f"written: {output / 'graph.yaml'}")
    write_report(run.report(), output / "report.json")
    print(f"written: {output / 'report.json'}")
    for line in run.lines():
        print(line)
    if interrupted:
        raise KeyboardInterrupt
    return 0 if run.over else 1
