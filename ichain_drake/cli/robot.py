"""The command `robot`: a world for a controller in another process."""

from __future__ import annotations

from pathlib import Path

import click

from ichain_drake.cli.options import PATH, options, scenario_named
from ichain_drake.errors import InputError
from ichain_drake.timing import FRAME


@click.command()
@options("scenario", "physics", "seed")
@click.option("--paths", "name", metavar="NAME", default="", help="paths: the one at whose start it begins")
@click.option("--path", type=PATH, metavar="FILE.csv", help="the same of a file")
@click.option(
    "--address",
    metavar="ADDRESS",
    default="lcm://",
    help="of the line: lcm://HOST:PORT, a multicast group; by default LCM's usual one",
)
@click.option("--seconds", type=float, default=3600.0, show_default=True, help="of the world, at most")
@click.option("--pace", type=float, default=1.0, show_default=True, help="simulated seconds in a second")
@click.option("--lost", type=float, default=0.0, show_default=True, help="share of messages that never arrive")
@click.option("--late", type=float, default=0.0, show_default=True, metavar="MS", help="how late the others are [ms]")
@options("settings")
def robot(
    scenario: str,
    physics: str,
    seed: int,
    name: str,
    path: Path | None,
    address: str,
    seconds: float,
    pace: float,
    lost: float,
    late: float,
    settings: tuple[str, ...],
) -> None:
    """Run a world in real time for `ichain run SYSTEM --robot ADDRESS` in another process.

    It stands at its start until it is commanded, and its hand stays where it was sent last.
    """
    from ichain_drake.remote import RobotServer
    from ichain_drake.runs.paths.choice import choose_paths
    from ichain_drake.scenarios import PathScenario

    if not 0.0 < pace <= 100.0:  # noqa: PLR2004 - what a process can keep to, and some more
        raise InputError(f"--pace {pace:g}: give simulated seconds in a second, above 0 and up to 100")
    if not 0.0 < seconds < float("inf"):
        raise InputError(f"--seconds {seconds:g}: give a time above 0")
    loaded = scenario_named(scenario, settings, physics, seed)
    start = None
    if isinstance(loaded, PathScenario):
        start = next(iter(choose_paths(loaded, (name,) if name else (), path).values()))
    elif name or path:
        raise InputError(f"{loaded.name} is asked for a goal: --path and --paths are not for it")
    world = loaded.start_world("" if start is None else start)
    frames = round(late / 1000.0 / FRAME)
    server = RobotServer(world, address, pace=pace, lost=lost, late=frames, seed=loaded.seed)
    print(f"{loaded.name} at {address}: waiting for commands; Ctrl-C ends it", flush=True)
    told = False

    def seen(running: RobotServer) -> bool:
        nonlocal told
        if running.commanded != told:
            told = running.commanded
            print("commanded" if told else "nobody commands any more: the hand stays where it was sent", flush=True)
        return False

    server.run(seconds, seen)
    print(f"{server.frame * FRAME:.1f} s of the world are over")
