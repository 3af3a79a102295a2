"""The command `settings`."""

from __future__ import annotations

import textwrap

from ichain_drake.errors import InputError
from ichain_drake.scenarios.settings_list import list_constants, list_settings
from ichain_drake.systems import scenario_class

_WIDTH = 100
_LONG = 60  # characters of a default; longer ones are cut, as the file has them


def print_settings(name: str | None, *, constants: bool = False) -> None:
    """One paragraph a setting: key, default, unit and range, then its meaning.

    Args:
        name: of the scenario.
        constants: those of learning and control instead, which are the same for every scenario.

    Raises:
        InputError: on an unknown scenario, or none.
    """
    if name is None and not constants:
        raise InputError("settings of what? name a scenario from `ichain list`, or give --constants")
    for line in list_settings(scenario_class(name)) if name is not None and not constants else list_constants():
        default = textwrap.shorten(line.default, _LONG, placeholder=" ...")
        unit = f" [{line.unit}]" if line.unit else ""
        allowed = f"  ({line.allowed})" if line.allowed else ""
        print(f"{line.key}={default}{unit}{allowed}")
        if line.meaning:
            print(textwrap.fill(line.meaning, _WIDTH, initial_indent="    ", subsequent_indent="    "))
