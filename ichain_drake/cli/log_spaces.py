"""State spaces of logs: a system's, those of a file, or guessed from columns; shared by commands that read logs."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import click

from ichain_drake.cli.options import PATH, FunctionT, scenario_alone
from ichain_drake.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable

    from ichain_drake.graph import InteractionGraph
    from ichain_drake.state import StateSpace


@dataclass(frozen=True)
class LogSpaces:
    """What objects logs are of.

    Attributes:
        spaces: observable state space per object.
        root: the robot.
        guessed: what was guessed, a line a variable.
        system: the system's graph, where one was named.
    """

    spaces: dict[str, StateSpace]
    root: str
    guessed: tuple[str, ...] = ()
    system: InteractionGraph | None = None

    @property
    def graph(self) -> InteractionGraph:
        """The system's graph, else one that only says which objects there are."""
        from ichain_drake.graph import Interaction, InteractionGraph

        if self.system is not None:
            return self.system
        return InteractionGraph(self.spaces, [Interaction(self.root, n) for n in self.spaces if n != self.root])


def spaces_options(function: FunctionT) -> FunctionT:
    """Options that say what objects logs are of."""
    for option in (
        click.option("--robot", default="", metavar="OBJECT", help="the robot; else what has command columns"),
        click.option("--objects", type=PATH, metavar="GRAPH.yaml", help="state spaces from a file, mended by you"),
        click.option("--system", metavar="SCENARIO", help="whose state spaces the logs have; else they are guessed"),
    ):
        function = option(function)
    return function


def log_spaces(
    logs: Path, system: str | None, objects: Path | None, robot: str, say: Callable[[str], None]
) -> LogSpaces:
    """State spaces of logs.

    Args:
        logs: a folder, or one file.
        system: name of a scenario.
        objects: a file that `ichain discover` wrote.
        robot: which object is the robot, if not what those say.
        say: called with a line on each variable that was guessed.

    Raises:
        InputError: if both are given, a file can't be read, there is no such object, or a system has several robots.
    """
    from ichain_drake.demonstrations import read_folder
    from ichain_drake.learning.discovery.graph_file import read_spaces
    from ichain_drake.learning.discovery.guess import guess_spaces

    if system is not None and objects is not None:
        raise InputError("--system and --objects: give one of the two")
    if system is not None:
        graph = scenario_alone(system).graph
        root = graph.only_root("finding out from logs what acts on what")
        found = LogSpaces({n: s.observable for n, s in graph.objects.items()}, robot or root, system=graph)
    elif objects is not None:
        spaces, named = read_spaces(objects)
        found = LogSpaces(spaces, robot or named)
    else:
        guess = guess_spaces(read_folder(logs), robot)
        found = LogSpaces(guess.spaces, guess.robot, guess.notes)
        for note in guess.notes:
            say(f"guessed: {note}")
    if found.root not in found.spaces:
        raise InputError(
            f"there is no object {found.root!r} in the logs to be the robot; objects are {', '.join(found.spaces)}"
        )
    return found
