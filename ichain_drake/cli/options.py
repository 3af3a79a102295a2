"""Options that several commands share, and the scenario that they are about."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, TypeVar

import click
from click.core import ParameterSource

FunctionT = TypeVar("FunctionT", bound=Callable[..., Any])
PATH = click.Path(path_type=Path)


def options(*names: str) -> Callable[[FunctionT], FunctionT]:
    """Options that several commands share, in the order named."""
    known = {
        "scenario": click.argument("scenario"),
        "physics": click.option("--physics", default="contact", show_default=True, help="ideal, arm or contact"),
        "seed": click.option("--seed", default=0, show_default=True, help="seed of the run, from 0"),
        "settings": click.option("--set", "settings", metavar="KEY=VALUE", multiple=True, help="change a setting"),
        "report": click.option("--report", metavar="FILE", help="report as JSON; - for stdout"),
        "output": click.option("-o", "--output", type=PATH, metavar="DIR", help="folder for what is written"),
        "resume": click.option("--resume", is_flag=True, help="go on from the rows kept beside the report"),
        "jobs": click.option("--jobs", default=1, show_default=True, help="processes, up to cores and free memory"),
        "cluster": click.option(
            "--cluster", metavar="KIND", default="", help="dask or ray; dask=tcp://HOST:PORT for one that runs"
        ),
        "trial_timeout": click.option(
            "--trial-timeout", type=float, metavar="SECONDS", help="stop a trial that takes longer; it counts as failed"
        ),
        "without": click.option(
            "--without", metavar="RULE", multiple=True, help="switch a rule off; `ichain scoreboard --rules` lists them"
        ),
        "resample": click.option(
            "--resample", is_flag=True, help="take demonstrations of another rate, or with gaps, to 3 Hz"
        ),
        "unlabelled": click.option(
            "--unlabelled", is_flag=True, help="goals: flags of demonstrations are inferred where they are missing"
        ),
        "no_graph": click.option(
            "--no-graph", is_flag=True, help="with --unlabelled: which objects act on which is found out, too"
        ),
        "graph_file": click.option(
            "--graph", "graph_file", type=PATH, metavar="FILE", help="goals: edges from `ichain discover`"
        ),
        "library": click.option("--library", type=PATH, metavar="DIR", help="a library of learned interactions"),
        "lift": click.option(
            "--lift", is_flag=True, help="with --library: what was learned on one object holds for all of its type"
        ),
    }

    def decorate(function: FunctionT) -> FunctionT:
        for name in reversed(names):
            function = known[name](function)
        return function

    return decorate


_NO_MATTER = {"jobs", "cluster", "report", "output", "resume", "against"}  # what found figures do not depend on


def command_said() -> str:
    """The command line that runs, without what its figures don't depend on; empty outside a command."""
    context = click.get_current_context(silent=True)
    if context is None:
        return ""
    words = ["ichain", str(context.info_name)]
    for param in context.command.params:
        name = str(param.name)
        if context.get_parameter_source(name) is not ParameterSource.COMMANDLINE or name in _NO_MATTER:
            continue
        value = context.params[name]
        values = value if isinstance(value, tuple) else (value,)
        if isinstance(param, click.Argument):
            words += [str(v) for v in values]
        elif isinstance(param, click.Option) and param.is_flag:
            words.append(param.opts[0] if value else param.secondary_opts[0])
        else:
            words += [w for v in values for w in (param.opts[0], str(v))]
    return shlex.join(words)


def scenario_named(name: str, settings: Sequence[str], physics: str, seed: int) -> Any:
    """The scenario of that name.

    Raises:
        InputError: on an unknown name or a bad setting.
    """
    from ichain_drake.systems import load_scenario

    return load_scenario(name, settings, physics, seed)  # type: ignore[arg-type]


def scenario_alone(name: str, settings: Sequence[str] = ()) -> Any:
    """The scenario of that name where its physics is no matter: in the plainest that it has.

    Raises:
        InputError: as `scenario_named`.
    """
    from ichain_drake.scenarios.base import ROBOT_PHYSICS
    from ichain_drake.systems import scenario_class

    kind = scenario_class(name)
    return kind(settings, getattr(kind, "physics_kinds", ROBOT_PHYSICS)[0], 0)
