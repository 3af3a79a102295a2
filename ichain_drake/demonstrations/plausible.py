"""Values that no reading of a variable can be: far beyond its bounds, or in another unit than the one declared."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from ichain_drake.demonstrations.columns import COMMAND, Piece, as_numbers, column
from ichain_drake.errors import InputError
from ichain_drake.graph import InteractionGraph
from ichain_drake.state import FloatArray, Variable

_MARGIN = 0.5
"""How far beyond its bounds a variable may be read [widths between the bounds]: noise and spans declared too tight are
within it, the next unit, mostly a factor of ten or more, isn't."""

_SLACK = 0.05
"""The same where a unit is guessed [widths]."""

_MOST = 1e9
"""No reading is larger, whatever its unit: squares of such values still are numbers, and grids over them aren't."""

_MOST_TURNS = 16.0
"""An angle may be told without wrapping, but nobody turns more often in one piece [turns]."""

_FACTORS = {
    "m": {"mm": 1e3, "cm": 1e2}, "s": {"ms": 1e3, "us": 1e6, "ns": 1e9}, "rad": {"deg": 180 / math.pi},
    "rad/s": {"deg/s": 180 / math.pi, "rpm": 30 / math.pi}, "m/s": {"mm/s": 1e3, "cm/s": 1e2, "km/h": 3.6},
    "1": {"%": 1e2, "an 8-bit integer": 255.0, "a 16-bit integer": 32767.0},
}  # fmt: skip
"""Units that people log in, by the unit declared, as multiples of it."""


def check_plausible(demo: Piece, graph: InteractionGraph) -> None:
    """Refuse values far beyond the declared bounds, and name the unit that they are likely in.

    Args:
        demo: of finite numbers.
        graph: declares the variables.

    Raises:
        InputError: names the table, the line, the column, the value and the bounds.
    """
    for name, variable in _variables(demo, graph):
        values = as_numbers(demo.table[name])
        huge = np.abs(values) > _MOST
        if huge.any():
            _refuse(demo, name, variable, values, huge, "no reading is that large")
        if variable.kind == "angle":
            _check_angle(demo, name, variable, values)
            continue
        width = variable.upper - variable.lower
        if not math.isfinite(width):
            continue
        beyond = (values < variable.lower - _MARGIN * width) | (values > variable.upper + _MARGIN * width)
        if beyond.any():
            _refuse(demo, name, variable, values, beyond, f"its bounds are {variable.lower:g} to {variable.upper:g}")


def _variables(demo: Piece, graph: InteractionGraph) -> Iterator[tuple[str, Variable]]:
    """Every measured column of a table with its variable; commands are the robots' variables."""
    spaces = {**{obj: space.observable for obj, space in graph.objects.items()}, COMMAND: graph.command}
    for owner, space in spaces.items():
        for variable in space.variables:
            if (name := column(owner, variable.name)) in demo.table:
                yield name, variable


def _check_angle(demo: Piece, name: str, variable: Variable, values: FloatArray) -> None:
    """An angle may wrap anywhere, or not at all; but it begins within a turn, and no two readings are further apart."""
    turn = 2.0 * math.pi * (1.0 + _SLACK)
    beyond = (np.abs(np.diff(values, prepend=0.0)) > turn) | (np.abs(values) > _MOST_TURNS * turn)
    if beyond.any():
        _refuse(demo, name, variable, values, beyond, "an angle is in radians, within half a turn of 0")


def _refuse(demo: Piece, name: str, variable: Variable, values: FloatArray, bad: NDArray[np.bool_], why: str) -> None:
    row = int(np.argmax(bad))
    unit = likely_unit(values, variable)
    hint = f"is it in {unit}? Convert it, or say so in the header ({name} [{unit}])" if unit else "mend or remove it"
    if unit and " " in unit:
        hint = f"is it {unit}? Convert it"
    raise InputError(
        f"{demo.name}: line {demo.first_line + row}, column {name}: {values[row]:.6g} {_word(variable.unit)}given, and "
        f"{why}; {hint}"
    )


def _word(unit: str) -> str:
    return "" if unit == "1" else f"{unit} "


def likely_unit(values: FloatArray, variable: Variable) -> str:
    """The unit in which all the values would be within the variable's bounds; empty if none is known.

    Args:
        values: shape (n,), beyond the bounds as they are.
        variable: which.
    """
    low, high = variable.lower, variable.upper
    if variable.kind == "angle":
        low, high = -2.0 * math.pi, 2.0 * math.pi
    if not (math.isfinite(low) and math.isfinite(high)):
        return ""
    slack = _SLACK * (high - low)
    most = max(abs(low), abs(high)) + slack
    for unit, factor in sorted(_FACTORS.get(variable.unit, {}).items(), key=lambda item: item[1]):
        if (values / factor >= low - slack).all() and np.abs(values / factor).max() <= most:
            return unit
    return ""
