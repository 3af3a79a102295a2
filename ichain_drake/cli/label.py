"""The command `label`: what a person marks in recordings, in the browser or in a table, becomes flags of pieces."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from ichain_drake.cli.log_spaces import LogSpaces, log_spaces, spaces_options
from ichain_drake.cli.options import PATH, options
from ichain_drake.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ichain_drake.cli.console import Reporter
    from ichain_drake.demonstrations import Demonstration
    from ichain_drake.graph import InteractionGraph
    from ichain_drake.learning.discovery.labels import Labelled
    from ichain_drake.learning.discovery.marks import Mark


@click.command()
@click.argument("logs", type=PATH)
@click.option(
    "--marks", type=PATH, metavar="FILE.csv", required=True, help="piece, interaction, from, to, active, name"
)
@click.option("-o", "--output", type=PATH, metavar="DEMOS", help="folder for the pieces with what was marked")
@click.option("--browser", is_flag=True, help="mark on a page in the web browser; saved in FILE.csv")
@click.option("--open/--no-open", "opened", default=True, show_default=True, help="with --browser: open the browser")
@spaces_options
@options("resample")
def label(
    logs: Path,
    marks: Path,
    output: Path | None,
    browser: bool,
    opened: bool,
    system: str | None,
    objects: Path | None,
    robot: str,
    resample: bool,
) -> None:
    """Mark in recordings (LOGS: a folder, or one file) when interactions are active, and where pieces begin."""
    from ichain_drake.cli.console import Reporter
    from ichain_drake.demonstrations import prepare, read_folder, write_demonstrations
    from ichain_drake.demonstrations.reading import check_unused
    from ichain_drake.files import is_file
    from ichain_drake.learning.discovery.cuts import TABLE, cut_pieces
    from ichain_drake.learning.discovery.marks import check_marks, marked, read_marks
    from ichain_drake.learning.discovery.raw import check_logs
    from ichain_drake.runs.paths.output import prepare_folder, write_report

    if output is None and not browser:
        raise InputError("give -o DEMOS for pieces with what FILE.csv marks, --browser for a page to mark on, or both")
    if marks.suffix != ".csv":
        raise InputError(f"{marks}: marks end in .csv")
    if output is not None:
        prepare_folder(output)
        check_unused(output)
    known = read_marks(marks) if is_file(marks) or not browser else []
    with Reporter() as say:
        what = log_spaces(logs, system, objects, robot, say.note)
        graph = what.graph if what.system is not None else _all_pairs(what)
        whole = prepare(read_folder(logs, say.note), graph, resampled=resample, say=say.note)
        check_marks(known, whole, graph)
        if browser:
            check_logs(cut_pieces(whole, graph, marks=known).pieces, graph)
            known = _in_browser(whole, graph, what, known, marks, say, opened=opened)
        if output is None:
            return
        found = cut_pieces([marked(log, known) for log in whole], graph, say.note, known)
        check_logs(found.pieces, graph)
    for file in write_demonstrations(found.pieces, output):
        print(f"written: {file}")
    write_report(found.report(), output / TABLE)
    print(f"written: {output / TABLE}")


def _all_pairs(what: LogSpaces) -> InteractionGraph:
    """Every interaction that there may be."""
    from ichain_drake.graph import Interaction, InteractionGraph

    names = list(what.spaces)
    pairs = [Interaction(a, b) for b in names if b != what.root for a in names if a != b]
    return InteractionGraph(what.spaces, pairs)


def _in_browser(
    whole: Sequence[Demonstration],
    graph: InteractionGraph,
    what: LogSpaces,
    known: Sequence[Mark],
    file: Path,
    say: Reporter,
    *,
    opened: bool,
) -> list[Mark]:
    """Show what can be told without a person, and let her mark."""
    from ichain_drake.cli.live import announce
    from ichain_drake.learning.discovery.cuts import cut_pieces
    from ichain_drake.learning.discovery.marks import CUT, marked
    from ichain_drake.runs.labelling import LabellingSession, page_content

    found = cut_pieces([marked(log, known) for log in whole], graph, say.note, known)
    labelled, notice = None, ""
    try:
        labelled = _inferred(found.pieces, graph, what, say)
    except InputError as error:  # which is what marks are for
        notice = f"nothing was inferred: {error}"
        say.note(notice)
    shown = graph if labelled is None or what.system is not None else labelled.graph
    names = dict.fromkeys([e.name for e in shown.interactions] + [m.interaction for m in known if m.interaction != CUT])
    content = page_content(whole, graph, list(names), found, labelled, known)
    session = LabellingSession(whole, graph, content, known, file, say.note, notice)
    announce(session.address, opened=opened)
    return session.run()


def _inferred(pieces: Sequence[Demonstration], graph: InteractionGraph, what: LogSpaces, say: Reporter) -> Labelled:
    """Statuses of the system's interactions, else of those that are found."""
    from ichain_drake.learning.discovery.edges import discover_graph
    from ichain_drake.learning.discovery.labels import flagged, label_pieces, raw_piece

    if what.system is not None:
        return label_pieces(pieces, what.system, say)
    found = discover_graph([raw_piece(p, graph, graph.interactions) for p in pieces], what.spaces, what.root, say=say)
    shown = found.graph()
    return flagged(pieces, shown, [f for f in found.found if f.edge in shown.interactions])
