"""Options that several commands share, and the scenario that they are about."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, TypeVar

import click

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
        "resample": click.option(
            "--resample", is_flag=True, help="take demonstrations of another rate, or with gaps, to 3 Hz"
        ),
        "library": click.option("--library", type=PATH, metavar="DIR", help="a library of learned interactions"),
    }

    def decorate(function: FunctionT) -> FunctionT:
        for name in reversed(names):
            function = known[name](function)
        return function

    return decorate


def scenario_named(name: str, settings: Sequence[str], physics: str, seed: int) -> Any:
    """The scenario of that name.

    Raises:
        InputError: on an unknown name or a bad setting.
    """
    from ichain_drake.systems import load_scenario

    return load_scenario(name, settings, physics, seed)  # type: ignore[arg-type]
