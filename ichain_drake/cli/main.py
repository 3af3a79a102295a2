"""`ichain`: the command line. Each command is a thin layer over a function of `scenarios`.

Exit status: 0 goal reached (or the command did its work), 1 goal not reached, 2 wrong usage, bad input or an error that
was not foreseen, with one line on stderr, 130 interrupted (143 by SIGTERM).
"""

from __future__ import annotations

import errno
import os
import re
import sys
import traceback
from collections.abc import Sequence
from pathlib import Path

import click

from ichain_drake.cli.check import check
from ichain_drake.cli.cut import cut
from ichain_drake.cli.discover import discover
from ichain_drake.cli.explore import explore
from ichain_drake.cli.label import label
from ichain_drake.cli.library_commands import library
from ichain_drake.cli.logs import export_command, import_command
from ichain_drake.cli.measuring import benchmarks, evaluate
from ichain_drake.cli.options import PATH, options, scenario_alone, scenario_named
from ichain_drake.cli.robot import robot
from ichain_drake.cli.scoreboard import scoreboard
from ichain_drake.cli.teaching import learn, relearn, teach
from ichain_drake.errors import IchainError, UnreachableError, WorkerLostError
from ichain_drake.files import is_file, printable

TRACEBACK = "ICHAIN_TRACEBACK"
"""Environment variable: set, an error that was not foreseen shows its traceback."""


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="ichain_drake")
def app() -> None:
    """Control one object through another: chains and graphs of learned object interactions, for Drake."""


for _command in (
    teach,
    learn,
    cut,
    label,
    discover,
    explore,
    relearn,
    evaluate,
    benchmarks,
    scoreboard,
    check,
    import_command,
    export_command,
    library,
    robot,
):
    app.add_command(_command)


@app.command("list")
def list_scenarios() -> None:
    """List the scenarios."""
    from ichain_drake.scenarios.config import load_config
    from ichain_drake.systems import OPTIONAL, SCENARIOS

    every = SCENARIOS | OPTIONAL
    width = max(map(len, every))
    for name, kind in every.items():
        config = load_config(kind.config_class, kind.config_path())
        print(f"{name:{width}} {config.description}")


@app.command()
@click.argument("scenario", required=False)
@click.option("--constants", is_flag=True, help="those of learning and control instead, which --set does not change")
def settings(scenario: str | None, constants: bool) -> None:
    """List what --set can change in a scenario: key, default, unit, allowed range and meaning."""
    from ichain_drake.cli.settings import print_settings

    print_settings(scenario, constants=constants)


@app.command()
@options("scenario", "physics", "seed")
@click.option("--path", type=PATH, metavar="FILE.csv", multiple=True, help="follow this path: columns x, y")
@click.option("--smooth", is_flag=True, help="round the corners of --path as far as the demonstrations ask for")
@click.option("--paths", metavar="NAME ...", multiple=True, help="reference paths to follow")
@click.argument("more", nargs=-1, metavar="")
@click.option("--goal", metavar="EXPR ...", multiple=True, help="wanted, such as 'object.variable >= value'")
@click.option("--demos", type=PATH, metavar="DIR", help="learn from these demonstrations instead of recording some")
@options("resample", "unlabelled", "no_graph", "graph_file", "library", "lift")
@click.option("--record", type=PATH, metavar="FILE.html", help="playback file")
@click.option("--rerun", type=PATH, metavar="FILE.rrd", help="also write a recording for rerun's viewer")
@options("report", "output", "without")
@click.option("--oracle/--no-oracle", help="also run the oracle, for comparison; it takes longer than the run")
@click.option("--meshcat", is_flag=True, help="show it in the web browser while it runs")
@click.option("--realtime", is_flag=True, help="with --meshcat: as slow as in reality")
@click.option("--robot", metavar="ADDRESS", default="", help="drive the robot there; see `ichain robot`")
@options("settings")
def run(
    scenario: str,
    physics: str,
    seed: int,
    path: tuple[Path, ...],
    smooth: bool,
    paths: tuple[str, ...],
    more: tuple[str, ...],
    goal: tuple[str, ...],
    demos: Path | None,
    resample: bool,
    unlabelled: bool,
    no_graph: bool,
    graph_file: Path | None,
    library: Path | None,
    lift: bool,
    record: Path | None,
    rerun: Path | None,
    report: str | None,
    output: Path | None,
    without: tuple[str, ...],
    oracle: bool,
    meshcat: bool,
    realtime: bool,
    robot: str,
    settings: tuple[str, ...],
) -> int:
    """Do the whole main job: demonstrations, learning, control, report, playback.

    SCENARIO is a name from `ichain list`, or your own file.py or module:Class, whose code is then run.
    """
    from ichain_drake import rules
    from ichain_drake.cli.run import asked_for, robot_asked_for, run_scenario, taught_by
    from ichain_drake.cli.run_files import RunFiles
    from ichain_drake.runs.goals.unlabelled import Taught

    if more and not (paths or goal):
        raise IchainError(f"unexpected argument {more[0]!r}; names of paths go behind --paths, goals behind --goal")
    if realtime and not meshcat:
        raise IchainError("--realtime is for --meshcat: without it nobody watches")
    loaded = scenario_named(scenario, settings, physics, seed)
    files = RunFiles(output or Path("runs") / f"{loaded.name}-{physics}-{seed}", record, report, rerun)
    with rules.without(without):
        asked = (goal, [*paths, *more]) if paths else ([*goal, *more], paths)
        taught = taught_by(loaded, Taught(unlabelled, no_graph, graph_file))
        started = asked_for(loaded, asked[0], path, asked[1], smooth=smooth, taught=taught)
        started.robot = robot_asked_for(started, robot, oracle=oracle, meshcat=meshcat)
        return run_scenario(
            started, files, path, demos, library, oracle=oracle, lift=lift, resampled=resample, meshcat=meshcat,
            realtime=realtime,
        )  # fmt: skip


@app.command()
@options("scenario")
@click.option("--goal", metavar="EXPR ...", multiple=True, help="wanted, such as 'object.variable >= value'")
@click.argument("more", nargs=-1, metavar="")
@options("physics", "seed")
@click.option("--demos", type=PATH, metavar="DIR", help="learn from these demonstrations instead of recording some")
@click.option("--explain", is_flag=True, help="also what was tried for each condition, and how likely each step is")
@options("resample", "unlabelled", "no_graph", "graph_file", "library", "lift", "settings")
def plan(
    scenario: str,
    goal: tuple[str, ...],
    more: tuple[str, ...],
    physics: str,
    seed: int,
    demos: Path | None,
    explain: bool,
    resample: bool,
    unlabelled: bool,
    no_graph: bool,
    graph_file: Path | None,
    library: Path | None,
    lift: bool,
    settings: tuple[str, ...],
) -> int:
    """Print the plan for a goal over an interaction graph, or why there is none."""
    from ichain_drake.cli.plan import print_plan
    from ichain_drake.runs.goals.unlabelled import Taught
    from ichain_drake.scenarios import PathScenario

    loaded = scenario_named(scenario, settings, physics, seed)
    if isinstance(loaded, PathScenario):
        raise IchainError(f"{scenario} follows paths; `ichain plan` is for scenarios with a goal")
    taught = Taught(unlabelled, no_graph, graph_file)
    return print_plan(
        loaded, [*goal, *more], demos, library, lift=lift, resampled=resample, explain=explain, taught=taught
    )


@app.command()
@options("scenario")
@click.option("-o", "--output", type=PATH, metavar="FILE", help=".svg, .png, .pdf or .dot; text if not given")
@click.option("--diagram", is_flag=True, help="draw the Drake Diagram instead")
@click.option("--physics", default="", help="of the Diagram; the plainest that it has if not given")
def graph(scenario: str, output: Path | None, diagram: bool, physics: str) -> None:
    """Draw the interaction graph, or the Diagram that mirrors it."""
    from ichain_drake.cli.run import draw_graph

    loaded = scenario_named(scenario, (), physics, 0) if physics else scenario_alone(scenario)
    print(draw_graph(loaded, output, diagram=diagram))


@app.command()
@click.argument("file", type=PATH)
def play(file: Path) -> None:
    """Open a playback in the web browser."""
    import webbrowser

    if not is_file(file):
        raise IchainError(f"{file}: no such playback; `ichain run` writes one")
    if not webbrowser.open(file.resolve().as_uri()):
        raise IchainError(f"{file}: no web browser was found; open the file in one by hand")
    print(f"opened {file}")


def _one_line(error: BaseException) -> str:
    return printable(" ".join(str(error).split()))


def _unforeseen(error: Exception) -> str:
    """An error that nothing here foresaw, with the place in this package that it came from.

    It must not end with status 1, which says that a goal was not reached.
    """
    frames = [f for f in traceback.extract_tb(error.__traceback__) if "ichain_drake" in f.filename]
    place = f" ({Path(frames[-1].filename).name}, line {frames[-1].lineno})" if frames else ""
    what = _one_line(error)[:300] or "no reason given"
    return f"{type(error).__name__}: {what}{place}; this was not foreseen: {TRACEBACK}=1 shows where it came from"


def _readable(arguments: Sequence[str]) -> list[str]:
    """The arguments, with a space before a comparison that starts with a negative number: that is no option."""
    return [f" {text}" if re.match(r"-\.?\d[^<>=]*[<>=]", text) else text for text in arguments]


def main(arguments: Sequence[str] | None = None) -> int:
    """Entry point of `ichain`; returns the exit status.

    Args:
        arguments: in place of the command line's.
    """
    try:
        # Not `app.main`: it answers Ctrl-C with an empty line, and a reader that left with status 1.
        with app.make_context("ichain", _readable(sys.argv[1:] if arguments is None else arguments)) as context:
            status = app.invoke(context)
        sys.stdout.flush()
        return status if isinstance(status, int) else 0
    except click.exceptions.Exit as done:  # --help, --version
        return done.exit_code
    except (UnreachableError, WorkerLostError) as error:
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
    except MemoryError:
        print("ichain: there is not enough memory; free some, or ask for less at once (smaller files, --jobs 1)",
              file=sys.stderr)  # fmt: skip
        return 2
    except OSError as error:
        where = f"{error.filename}: " if error.filename else ""
        more = (
            "; raise that limit (ulimit -n), or ask for less at once (--jobs 1)" if error.errno == errno.EMFILE else ""
        )
        print(f"ichain: {where}{error.strerror or _one_line(error)}{more}", file=sys.stderr)
        return 2
    except Exception as error:
        if os.environ.get(TRACEBACK):
            raise
        print(f"ichain: {_unforeseen(error)}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(main())
