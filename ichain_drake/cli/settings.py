"""The command `settings`."""

from __future__ import annotations

import textwrap

from ichain_drake.scenarios.settings_list import list_settings
from ichain_drake.systems import scenario_class

_WIDTH = 100
_LONG = 60  # characters of a default; longer ones are cut, as the file has them


def print_settings(name: str) -> None:
    """One paragraph a setting: key, default, unit and range, then its meaning.

    Raises:
        InputError: on an unknown scenario.
    """
    for line in list_settings(scenario_class(name)):
        default = textwrap.shorten(line.default, _LONG, placeholder=" ...")
        unit = f" [{line.unit}]" if line.unit else ""
        allowed = f"  ({line.allowed})" if line.allowed else ""
        print(f"{line.key}={default}{unit}{allowed}")
        if line.meaning:
            print(textwrap.fill(line.meaning, _WIDTH, initial_indent="    ", subsequent_indent="    "))
