"""The commands `teach`, `learn` and `relearn`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from ichain_drake.cli.options import PATH, options, scenario_alone, scenario_named
from ichain_drake.errors import InputError


@click.command()
@options("scenario")
@click.option("-o", "--output", type=PATH, metavar="DIR", required=True, help="folder for the demonstrations")
@options("physics", "seed")
@click.option("--browser", is_flag=True, help="a person demonstrates, in the web browser")
@click.option("--drive", default="", metavar="OBJECT", help="what the person drives; default the scenario's choice")
@click.option("--open/--no-open", "opened", default=True, show_default=True, help="with --browser: open the browser")
@click.option("--overwrite", is_flag=True, help="replace pieces of the same names in DIR")
@options("settings")
def teach(
    scenario: str,
    output: Path,
    physics: str,
    seed: int,
    browser: bool,
    drive: str,
    opened: bool,
    overwrite: bool,
    settings: tuple[str, ...],
) -> None:
    """Record demonstrations: the scripted ones, or a person's (--browser)."""
    from ichain_drake.cli.console import Reporter
    from ichain_drake.demonstrations import Demonstration
    from ichain_drake.demonstrations.reading import check_unused
    from ichain_drake.files import held
    from ichain_drake.runs.open_piece import save_left_behind
    from ichain_drake.runs.paths.output import prepare_folder
    from ichain_drake.runs.pieces import check_settings, record_pieces

    if drive and not browser:
        raise InputError("--drive is for --browser: a script drives what it has to")
    if overwrite and browser:
        raise InputError("--overwrite is for scripts: a person's pieces get numbers that no other has")
    loaded = scenario_named(scenario, settings, physics, seed)
    if browser:
        from ichain_drake.cli.live import teach_in_browser

        teach_in_browser(loaded, output, drive, opened=opened)
        return
    check_settings(loaded)
    prepare_folder(output)
    pieces: list[Demonstration] = []
    with held(output), Reporter() as say:
        save_left_behind(output, loaded.graph, say.note)
        if not overwrite:
            check_unused(output)
        record_pieces(loaded, pieces, output, say, overwrite=overwrite)
    for piece in pieces:
        print(f"written: {output / piece.name}.parquet, {len(piece)} rows")


@click.command()
@options("scenario")
@click.option("--demos", type=PATH, metavar="DIR", required=True, help="folder of demonstrations")
@click.option("-o", "--output", type=PATH, metavar="LIBRARY", required=True, help="folder for what is learned")
@options("resample", "unlabelled", "no_graph", "graph_file", "settings")
def learn(
    scenario: str,
    demos: Path,
    output: Path,
    resample: bool,
    unlabelled: bool,
    no_graph: bool,
    graph_file: Path | None,
    settings: tuple[str, ...],
) -> None:
    """Learn a scenario's links, or its whole graph, from demonstrations and save them as a library."""
    from ichain_drake.cli.learn_library import learn_library
    from ichain_drake.runs.goals.unlabelled import Taught

    taught = Taught(unlabelled, no_graph, graph_file)
    learn_library(scenario_alone(scenario, settings), demos, output, resampled=resample, taught=taught)


@click.command()
@options("scenario")
@click.option("--link", required=True, metavar="'PARENT->CHILD'", help="the link to learn anew")
@click.option("--library", type=PATH, required=True, metavar="DIR", help="the links learned before")
@options("physics", "seed", "report", "settings")
@click.option("--trials", type=click.IntRange(1), default=1, show_default=True, help="number of seeds")
def relearn(
    scenario: str,
    link: str,
    library: Path,
    physics: str,
    seed: int,
    report: str | None,
    settings: tuple[str, ...],
    trials: int,
) -> None:
    """Learn one link anew after a change of the scenario (--set), keep the others, and compare."""
    from ichain_drake.cli.relearn import relearn_and_compare

    # How it is learned and controlled is no change of the world: that holds for the original too.
    same = [text for text in settings if text.split(".")[0].strip() in ("control", "learning")]

    def make(number: int) -> tuple[Any, Any]:
        return scenario_named(scenario, settings, physics, number), scenario_named(scenario, same, physics, number)

    relearn_and_compare(make, range(seed, seed + trials), link, library, report)
