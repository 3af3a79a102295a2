"""The command `cut`: long recordings as pieces, with a table of cuts and of the skills between them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from ichain_drake.cli.log_spaces import LogSpaces, log_spaces, spaces_options
from ichain_drake.cli.options import PATH, options

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from ichain_drake.demonstrations import Demonstration
    from ichain_drake.learning.discovery.cuts import Pieces
    from ichain_drake.learning.discovery.skills import ShownSkill


@click.command()
@click.argument("logs", type=PATH)
@click.option("-o", "--output", type=PATH, metavar="DEMOS", required=True, help="folder for the pieces and cuts.json")
@spaces_options
@click.option("--skills", is_flag=True, help="also what was done between switches; statuses are inferred where missing")
@options("resample")
def cut(
    logs: Path,
    output: Path,
    system: str | None,
    objects: Path | None,
    robot: str,
    skills: bool,
    resample: bool,
) -> None:
    """Cut long recordings (LOGS: a folder, or one file) into pieces where they have gaps, repeat or were reset."""
    from ichain_drake.cli.console import Reporter
    from ichain_drake.demonstrations import write_demonstrations
    from ichain_drake.demonstrations.reading import check_unused
    from ichain_drake.learning.discovery.cuts import TABLE
    from ichain_drake.learning.discovery.raw import read_logs
    from ichain_drake.runs.paths.output import prepare_folder, write_report

    prepare_folder(output)
    check_unused(output)
    with Reporter() as say:
        what = log_spaces(logs, system, objects, robot, say.note)
        found = read_logs(logs, what.graph, resampled=resample, say=say.note)
        shown = _skills(found.pieces, what, say) if skills else []
    print(cut_table(found))
    for skill in shown:
        print(f"skill {skill}")
    for file in write_demonstrations(found.pieces, output):
        print(f"written: {file}")
    write_report(found.report() | ({"skills": [s.report() for s in shown]} if skills else {}), output / TABLE)
    print(f"written: {output / TABLE}")


def cut_table(found: Pieces) -> str:
    """Cuts as text: when, why, how sure."""
    from rich.table import Table

    from ichain_drake.cli.evaluation import table_text

    view = Table("log", "row", "time (s)", "why", "sure", box=None)
    for c in found.cuts:
        view.add_row(c.log, str(c.row), f"{c.time:.4g}", c.why, f"{c.sure:.3f}")
    note = f"{len(found.cuts)} cuts, {len(found.pieces)} pieces"
    return "\n".join([table_text(view, note), *found.left_out])


def _skills(pieces: Sequence[Demonstration], what: LogSpaces, say: Callable[[str], None]) -> list[ShownSkill]:
    """Skills by the system's graph, or by one that is found out of the states."""
    from ichain_drake.learning.discovery.edges import discover_graph
    from ichain_drake.learning.discovery.labels import flagged, label_pieces, raw_piece
    from ichain_drake.learning.discovery.skills import shown_skills

    if what.system is not None:
        labelled = label_pieces(pieces, what.system, say)
    else:
        found = discover_graph([raw_piece(p, what.graph) for p in pieces], what.spaces, what.root, say=say)
        graph = found.graph()
        labelled = flagged(pieces, graph, [f for f in found.found if f.edge in graph.interactions])
    return shown_skills(labelled.pieces, labelled.graph)
