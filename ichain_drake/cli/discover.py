"""The command `discover`."""

from __future__ import annotations

from pathlib import Path

import click

from ichain_drake.cli.log_spaces import log_spaces, spaces_options
from ichain_drake.cli.options import PATH, options
from ichain_drake.errors import InputError

_EDGE = "'A->B'"


@click.command()
@click.argument("logs", type=PATH)
@click.option("-o", "--output", type=PATH, metavar="GRAPH.yaml", required=True, help="the graph that was found")
@spaces_options
@click.option("--forbid", metavar=_EDGE, multiple=True, help="an interaction that there can't be")
@click.option("--require", metavar=_EDGE, multiple=True, help="an interaction that there is")
@click.option("--no-cause", metavar="OBJECT", multiple=True, help="an object that acts on nothing")
@options("resample")
def discover(
    logs: Path,
    output: Path,
    system: str | None,
    objects: Path | None,
    robot: str,
    forbid: tuple[str, ...],
    require: tuple[str, ...],
    no_cause: tuple[str, ...],
    resample: bool,
) -> None:
    """Find out which objects act on which, from LOGS of states alone: a folder, or one file."""
    from ichain_drake.cli.console import Reporter
    from ichain_drake.graph import Interaction
    from ichain_drake.learning.discovery.edges import Prior, discover_graph
    from ichain_drake.learning.discovery.graph_file import write_graph
    from ichain_drake.learning.discovery.raw import read_raw

    if output.suffix not in (".yaml", ".yml"):
        raise InputError(f"{output}: a graph ends in .yaml")
    prior = Prior(
        frozenset(map(Interaction.parse, forbid)), frozenset(map(Interaction.parse, require)), frozenset(no_cause)
    )
    with Reporter() as say:
        what = log_spaces(logs, system, objects, robot, say.note)
        pieces = read_raw(logs, what.spaces, what.root, resampled=resample, say=say.note)
        found = discover_graph(pieces, what.spaces, what.root, prior, say=say)
    write_graph(found, output, what.guessed)
    for f in found.found:
        rivals = "".join(f"; or it is {r.parent} ({r.probability:.2f})" for r in f.rivals)
        print(f"{f.edge.name}: sure by {f.confidence:.3f}, shows in {f.ticks} of {found.rows} rows{rivals}")
    for name in found.free:
        print(f"{name}: nothing acts on it")
    for name in found.still:
        print(f"{name}: never changes; show it moving, or leave it out")
    for note in found.notes:
        print(note)
    print(f"written: {output}")
