"""The commands `import` and `export`: demonstrations from and in other people's formats."""

from __future__ import annotations

from pathlib import Path

import click

from ichain_drake.cli.options import PATH, options, scenario_alone
from ichain_drake.errors import InputError


@click.command("import")
@click.argument("form", metavar="FORMAT")
@click.argument("source", type=PATH)
@click.option("--map", "map_file", type=PATH, metavar="MAP.yaml", required=True, help="which source is which variable")
@click.option("-o", "--output", type=PATH, metavar="DEMOS", required=True, help="folder for the demonstrations")
@click.option("--system", metavar="SCENARIO", default="", help="whose they are: units are converted, pieces checked")
@options("resample")
def import_command(form: str, source: Path, map_file: Path, output: Path, system: str, resample: bool) -> int:
    """Read demonstrations of another format: lerobot, mcap, minari, robomimic or ros2."""
    from ichain_drake.cli.console import Reporter
    from ichain_drake.demonstrations import write_demonstrations
    from ichain_drake.demonstrations.importing import import_logs, parse_map
    from ichain_drake.demonstrations.overview import inferred_graph
    from ichain_drake.demonstrations.reading import check_unused, prepare
    from ichain_drake.files import read_whole
    from ichain_drake.scenarios.yaml_text import read_yaml

    say = Reporter().note
    if output.is_dir():
        check_unused(output)
    try:
        text = read_whole(map_file, "the map").decode()
    except UnicodeDecodeError:
        raise InputError(f"{map_file}: the map is no UTF-8") from None
    pieces = import_logs(form, source, parse_map(read_yaml(text, str(map_file)), str(map_file)))
    if system or resample:
        graph = scenario_alone(system).graph if system else inferred_graph(pieces)
        pieces = prepare(pieces, graph, resampled=resample, say=say)
        for piece in pieces if system else ():
            piece.check(graph)
    if not pieces:
        raise InputError(f"{source}: nothing of it is long enough for a piece")
    for file in write_demonstrations(pieces, output):
        print(f"written: {file}")
    return 0


@click.command("export")
@click.argument("form", metavar="FORMAT")
@click.argument("demos", type=PATH)
@click.option("-o", "--output", type=PATH, metavar="DIR", required=True, help="folder for what is written")
@click.option("--task", default="demonstration", show_default=True, help="what they show, in a sentence (lerobot)")
@options("resample")
def export_command(form: str, demos: Path, output: Path, task: str, resample: bool) -> int:
    """Write demonstrations in another format: lerobot or mcap."""
    from ichain_drake.cli.console import Reporter
    from ichain_drake.demonstrations import read_folder
    from ichain_drake.demonstrations.exporting import export_pieces
    from ichain_drake.demonstrations.overview import inferred_graph
    from ichain_drake.demonstrations.reading import prepare

    say = Reporter().note
    pieces = read_folder(demos, say)
    if resample:
        pieces = prepare(pieces, inferred_graph(pieces), resampled=True, say=say)
    for folder in export_pieces(form, pieces, output, task):
        print(f"written: {folder} (read back by ichain import {form} {folder} --map {folder / 'map.yaml'})")
    return 0
