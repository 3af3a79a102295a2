"""The command `check`: what a set of demonstrations shows, and what is odd about it."""

from __future__ import annotations

from pathlib import Path

import click

from ichain_drake.cli.options import PATH, options, scenario_alone
from ichain_drake.errors import InputError


@click.command()
@click.argument("demos", type=PATH)
@click.option("--system", metavar="SCENARIO", default="", help="whose they are; default: what the tables say")
@options("resample", "report")
@click.option("--page", type=PATH, metavar="FILE.html", help="the same as a page")
def check(demos: Path, system: str, resample: bool, report: str | None, page: Path | None) -> int:
    """Say what a folder of demonstrations shows, and what is odd about it.

    Exit status: 0 if every piece can be read and used, 2 if one can't.
    """
    from ichain_drake.cli.console import Reporter
    from ichain_drake.cli.run import deliver_report
    from ichain_drake.demonstrations import Demonstration, read_demonstration
    from ichain_drake.demonstrations.overview import inferred_graph, overview, overview_page, overview_text
    from ichain_drake.demonstrations.piece_file import piece_files
    from ichain_drake.demonstrations.reading import prepare
    from ichain_drake.files import shown, write_whole
    from ichain_drake.runs.paths.demonstrations import check_in_plane
    from ichain_drake.runs.paths.output import prepare_file
    from ichain_drake.scenarios import PathScenario

    say = Reporter().note
    scenario = scenario_alone(system) if system else None
    if page is not None and page.suffix != ".html":
        raise InputError(f"--page {page}: a page ends in .html")
    for written in (page, Path(report) if report and report != "-" else None):
        if written is not None:
            prepare_file(written)
    pieces: list[Demonstration] = []
    refused: list[str] = []
    for file in piece_files(demos, say):
        try:
            pieces.append(read_demonstration(file))
        except InputError as error:
            refused.append(str(error))
    if not pieces:
        raise InputError(f"{demos}: none of its {len(refused)} files can be read: {refused[0]}")
    graph = inferred_graph(pieces) if scenario is None else scenario.graph
    good: list[Demonstration] = []
    for piece in pieces:
        try:
            ready = prepare([piece], graph, resampled=resample, say=say)
            for part in ready:
                part.check(graph)
            if isinstance(scenario, PathScenario):
                check_in_plane(ready, scenario)
            good += ready
        except InputError as error:
            refused.append(str(error))
    found = overview(good, graph, refused)
    deliver_report(found, report, overview_text(found))
    if page is not None:
        write_whole(page, overview_page(found, f"Demonstrations in {shown(demos.resolve())}"))
        say(f"written: {page}")
    if refused:
        raise InputError(f"{demos}: {len(refused)} of its pieces can't be used; the report says why")
    return 0
