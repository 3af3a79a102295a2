"""`ichain`: the command line. Each command is a thin layer over a function of `scenarios`.

Exit status: 0 goal reached (or the command did its work), 1 goal not reached, 2 wrong usage or bad input with one line
on stderr, 130 interrupted.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, TypeVar

import click

from ichain_drake.errors import IchainError, UnreachableError

FunctionT = TypeVar("FunctionT", bound=Callable[..., Any])
PATH = click.Path(path_type=Path)


def _options(*names: str) -> Callable[[FunctionT], FunctionT]:
    """Options that several commands share, in the order named."""
    known = {
        "scenario": click.argument("scenario"),
        "physics": click.option("--physics", default="contact", show_default=True, help="ideal, arm or contact"),
        "seed": click.option("--seed", default=0, show_default=True, help="seed of the run, from 0"),
        "settings": click.option("--set", "settings", metavar="KEY=VALUE", multiple=True, help="change a setting"),
        "report": click.option("--report", metavar="FILE", help="report as JSON; - for stdout"),
        "output": click.option("-o", "--output", type=PATH, metavar="DIR", help="folder for what is written"),
        "library": click.option("--library", type=PATH, metavar="DIR", help="a library of learned interactions"),
    }

    def decorate(function: FunctionT) -> FunctionT:
        for name in reversed(names):
            function = known[name](function)
        return function

    return decorate


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="ichain_drake")
def app() -> None:
    """Control one object through another: chains and graphs of learned object interactions, for Drake."""


def _scenario(name: str, settings: Sequence[str], physics: str, seed: int) -> Any:
    from ichain_drake.scenarios import load_scenario

    return load_scenario(name, settings, physics, seed)  # type: ignore[arg-type]


def _path_scenario(name: str, settings: Sequence[str], physics: str, seed: int, command: str) -> Any:
    from ichain_drake.scenarios import PathScenario

    scenario = _scenario(name, settings, physics, seed)
    if not isinstance(scenario, PathScenario):
        raise IchainError(f"`ichain {command}` is for scenarios that follow paths; {name} is not one")
    return scenario


@app.command("list")
def list_scenarios() -> None:
    """List the scenarios."""
    from ichain_drake.robot import models_path
    from ichain_drake.scenarios import SCENARIOS
    from ichain_drake.scenarios.config import load_config

    for name, kind in SCENARIOS.items():
        config = load_config(kind.config_class, models_path() / "scenarios" / f"{name}.yaml")
        print(f"{name:18} {config.description}")


@app.command()
@_options("scenario", "physics", "seed")
@click.option("--path", type=PATH, metavar="FILE.csv", help="follow this path: columns x, y")
@click.option("--paths", metavar="NAME ...", multiple=True, help="reference paths to follow")
@click.argument("more", nargs=-1, metavar="")
@click.option("--goal", metavar="EXPR ...", multiple=True, help="wanted, such as 'object.variable >= value'")
@click.option("--demos", type=PATH, metavar="DIR", help="learn from these demonstrations instead of recording some")
@_options("library")
@click.option("--record", type=PATH, metavar="FILE.html", help="playback file")
@_options("report", "output")
@click.option("--oracle/--no-oracle", default=True, show_default=True, help="also run the oracle, for comparison")
@_options("settings")
def run(
    scenario: str,
    physics: str,
    seed: int,
    path: Path | None,
    paths: tuple[str, ...],
    more: tuple[str, ...],
    goal: tuple[str, ...],
    demos: Path | None,
    library: Path | None,
    record: Path | None,
    report: str | None,
    output: Path | None,
    oracle: bool,
    settings: tuple[str, ...],
) -> int:
    """Do the whole main job: demonstrations, learning, control, report, playback."""
    from ichain_drake.cli.graph import run_goal_scenario
    from ichain_drake.cli.run import RunFiles, run_path_scenario
    from ichain_drake.scenarios import PathScenario

    if more and not (paths or goal):
        raise IchainError(f"unexpected argument {more[0]!r}; names of paths go behind --paths, goals behind --goal")
    loaded = _scenario(scenario, settings, physics, seed)
    files = RunFiles(output or Path("runs") / f"{scenario}-{physics}-{seed}", record, report)
    if not isinstance(loaded, PathScenario):
        if path is not None or paths or library is not None:
            raise IchainError(f"{scenario} is asked for a goal: --path, --paths and --library are not for it")
        return run_goal_scenario(loaded, files, [*goal, *more], demos)
    if goal:
        raise IchainError(f"{scenario} follows paths: give --path or --paths, not --goal")
    return run_path_scenario(loaded, files, path, [*paths, *more], demos, library, oracle=oracle)


@app.command()
@_options("scenario")
@click.option("--goal", metavar="EXPR ...", multiple=True, help="wanted, such as 'object.variable >= value'")
@click.argument("more", nargs=-1, metavar="")
@_options("physics", "seed")
@click.option("--demos", type=PATH, metavar="DIR", help="learn from these demonstrations instead of recording some")
@_options("settings")
def plan(
    scenario: str,
    goal: tuple[str, ...],
    more: tuple[str, ...],
    physics: str,
    seed: int,
    demos: Path | None,
    settings: tuple[str, ...],
) -> int:
    """Print the plan for a goal over an interaction graph, or why there is none."""
    from ichain_drake.cli.graph import print_plan
    from ichain_drake.scenarios import PathScenario

    loaded = _scenario(scenario, settings, physics, seed)
    if isinstance(loaded, PathScenario):
        raise IchainError(f"{scenario} follows paths; `ichain plan` is for scenarios with a goal")
    return print_plan(loaded, [*goal, *more], demos)


@app.command()
@_options("scenario")
@click.option("-o", "--output", type=PATH, metavar="DIR", required=True, help="folder for the demonstrations")
@_options("physics", "seed", "settings")
def teach(scenario: str, output: Path, physics: str, seed: int, settings: tuple[str, ...]) -> None:
    """Record the scripted demonstrations."""
    from ichain_drake.cli.console import Reporter
    from ichain_drake.scenarios import PathScenario, graph_run, path_run
    from ichain_drake.scenarios.path_output import prepare_folder

    loaded = _scenario(scenario, settings, physics, seed)
    started: path_run.PathRun | graph_run.GraphRun
    if isinstance(loaded, PathScenario):
        path_run.check_settings(loaded)
    prepare_folder(output)
    with Reporter() as say:
        if isinstance(loaded, PathScenario):
            started = path_run.PathRun(loaded)
            path_run.record_pieces(started, output, say)
        else:
            started = graph_run.GraphRun(loaded, ())
            graph_run.record_pieces(started, output, say)
    for piece in started.pieces:
        print(f"written: {output / piece.name}.parquet, {len(piece)} rows")


@app.command()
@_options("scenario")
@click.option("--demos", type=PATH, metavar="DIR", required=True, help="folder of demonstrations")
@click.option("-o", "--output", type=PATH, metavar="LIBRARY", required=True, help="folder for the learned links")
@_options("settings")
def learn(scenario: str, demos: Path, output: Path, settings: tuple[str, ...]) -> None:
    """Learn a scenario's links from demonstrations and save them as a library."""
    from ichain_drake.cli.run import learn_library

    learn_library(_path_scenario(scenario, settings, "ideal", 0, "learn"), demos, output)


@app.command()
@_options("scenario")
@click.option("--link", required=True, metavar="'PARENT->CHILD'", help="the link to learn anew")
@click.option("--library", type=PATH, required=True, metavar="DIR", help="the links learned before")
@_options("physics", "seed", "report", "settings")
def relearn(
    scenario: str, link: str, library: Path, physics: str, seed: int, report: str | None, settings: tuple[str, ...]
) -> None:
    """Learn one link anew after a change of the scenario (--set), keep the others, and compare."""
    from ichain_drake.cli.run import relearn_and_compare

    changed = _path_scenario(scenario, settings, physics, seed, "relearn")
    original = _path_scenario(scenario, (), physics, seed, "relearn")
    relearn_and_compare(changed, original, link, library, report)


@app.command()
@_options("scenario")
@_options("physics", "seed")
@click.option("--trials", default=20, show_default=True, help="number of seeds")
@click.option("--methods", metavar="A,B", default="", help="only these methods")
@click.option("--jobs", default=1, show_default=True, help="processes")
@_options("report", "output", "settings")
def evaluate(
    scenario: str,
    physics: str,
    seed: int,
    trials: int,
    methods: str,
    jobs: int,
    report: str | None,
    output: Path | None,
    settings: tuple[str, ...],
) -> None:
    """Compare methods over many seeds, in one table."""
    from ichain_drake.cli.evaluate import evaluate_path_scenario

    loaded = _path_scenario(scenario, settings, physics, seed, "evaluate")
    names = [m.strip() for m in methods.split(",") if m.strip()]
    evaluate_path_scenario(loaded, list(settings), trials, names, jobs, report, output)


@app.command()
@_options("report")
def benchmarks(report: str | None) -> None:
    """Print what the library costs, as ratios measured in one run."""
    from ichain_drake.benchmarks import format_table, run_benchmarks
    from ichain_drake.cli.console import Reporter
    from ichain_drake.cli.run import deliver_report

    with Reporter() as say:
        results = run_benchmarks(say)
    deliver_report(results, report, text=format_table(results))


@app.command()
@_options("scenario")
@click.option("-o", "--output", type=PATH, metavar="FILE", help=".svg, .png, .pdf or .dot; text if not given")
@click.option("--diagram", is_flag=True, help="draw the Drake Diagram instead")
@click.option("--physics", default="ideal", show_default=True, help="of the Diagram")
def graph(scenario: str, output: Path | None, diagram: bool, physics: str) -> None:
    """Draw the interaction graph, or the Diagram that mirrors it."""
    from ichain_drake.cli.run import draw_graph

    print(draw_graph(_scenario(scenario, (), physics, 0), output, diagram=diagram))


@app.command()
@click.argument("file", type=PATH)
def play(file: Path) -> None:
    """Open a playback in the web browser."""
    import webbrowser

    if not file.is_file():
        raise IchainError(f"{file}: no such playback; `ichain run` writes one")
    if not webbrowser.open(file.resolve().as_uri()):
        raise IchainError(f"{file}: no web browser was found; open the file in one by hand")
    print(f"opened {file}")


@app.group()
def library() -> None:
    """Look at saved interactions."""


_LIBRARY = click.option(
    "--library", type=PATH, default=Path("library"), show_default=True, metavar="DIR", help="the library's folder"
)


@library.command("list")
@_LIBRARY
def library_list(library: Path) -> None:
    """List the interactions of a library."""
    from ichain_drake.cli.library import print_list

    print_list(library)


@library.command("show")
@click.argument("name")
@_LIBRARY
def library_show(name: str, library: Path) -> None:
    """Show what is known about one interaction."""
    from ichain_drake.cli.library import print_link

    print_link(library, name)


@library.command("add")
@click.argument("source", type=PATH)
@_LIBRARY
def library_add(source: Path, library: Path) -> None:
    """Add the interactions of another library."""
    from ichain_drake.cli.library import add

    add(source, library)


@library.command("check")
@click.argument("source", type=PATH)
def library_check(source: Path) -> None:
    """Check a library's files without loading anything from them."""
    from ichain_drake.cli.library import check

    check(source)


def _one_line(error: BaseException) -> str:
    return " ".join(str(error).split())


def main(arguments: Sequence[str] | None = None) -> int:
    """Entry point of `ichain`; returns the exit status.

    Args:
        arguments: in place of the command line's.
    """
    try:
        # Not `app.main`: it answers Ctrl-C with an empty line, and a reader that left with status 1.
        with app.make_context("ichain", list(sys.argv[1:] if arguments is None else arguments)) as context:
            status = app.invoke(context)
        sys.stdout.flush()
        return status if isinstance(status, int) else 0
    except click.exceptions.Exit as done:  # --help, --version
        return done.exit_code
    except UnreachableError as error:
        print(f"ichain: {_one_line(error)}", file=sys.stderr)
        return 1
    except IchainError as error:
        print(f"ichain: {_one_line(error)}", file=sys.stderr)
        return 2
    except click.exceptions.NoArgsIsHelpError as error:
        print(error.format_message(), file=sys.stderr)
        return 2
    except click.ClickException as error:
        print(f"ichain: {_one_line(Exception(error.format_message()))}", file=sys.stderr)
        return 2
    except (KeyboardInterrupt, click.Abort):
        print("ichain: interrupted", file=sys.stderr)
        return 130
    except BrokenPipeError:
        # Whoever read our output has left; there is nobody to tell.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0


if __name__ == "__main__":
    sys.exit(main())
