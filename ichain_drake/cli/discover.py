"""The command `discover`."""

from __future__ import annotations

from pathlib import Path

import click

from ichain_drake.cli.options import PATH, options, scenario_alone
from ichain_drake.errors import InputError

_EDGE = "'A->B'"


@click.command()
@click.argument("logs", type=PATH)
@click.option("-o", "--output", type=PATH, metavar="GRAPH.yaml", required=True, help="the graph that was found")
@click.option("--system", metavar="SCENARIO", help="whose state spaces the logs have; else they are guessed")
@click.option("--objects", type=PATH, metavar="GRAPH.yaml", help="state spaces from a file that you have mended")
@click.option("--robot", default="", metavar="OBJECT", help="the robot; else the object that has command columns")
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
    """Find out which objects act on which, from a folder of LOGS of states alone."""
    from ichain_drake.cli.console import Reporter
    from ichain_drake.demonstrations import read_folder
    from ichain_drake.graph import Interaction
    from ichain_drake.learning.discovery.edges import Prior, discover_graph
    from ichain_drake.learning.discovery.graph_file import read_spaces, write_graph
    from ichain_drake.learning.discovery.guess import guess_spaces
    from ichain_drake.learning.discovery.raw import read_raw

    if system is not None and objects is not None:
        raise InputError("--system and --objects: give one of the two")
    if output.suffix not in (".yaml", ".yml"):
        raise InputError(f"{output}: a graph ends in .yaml")
    prior = Prior(
        frozenset(map(Interaction.parse, forbid)), frozenset(map(Interaction.parse, require)), frozenset(no_cause)
    )
    guessed: tuple[str, ...] = ()
    with Reporter() as say:
        if system is not None:
            graph = scenario_alone(system).graph
            spaces, root = {n: s.observable for n, s in graph.objects.items()}, robot or graph.root
        elif objects is not None:
            spaces, named = read_spaces(objects)
            root = robot or named
        else:
            guess = guess_spaces(read_folder(logs), robot)
            spaces, root, guessed = guess.spaces, guess.robot, guess.notes
            for note in guessed:
                say.note(f"guessed: {note}")
        pieces = read_raw(logs, spaces, root, resampled=resample, say=say.note)
        found = discover_graph(pieces, spaces, root, prior, say=say)
    write_graph(found, output, guessed)
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
