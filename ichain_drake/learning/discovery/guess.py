"""State spaces guessed from the columns of tables: names, units and values, for a person to confirm."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ichain_drake.demonstrations import Demonstration
from ichain_drake.demonstrations.columns import COMMAND, TIME, as_numbers
from ichain_drake.errors import InputError
from ichain_drake.state import FloatArray, Kind, Role, StateSpace, Variable

_LENGTHS = ("m", "mm", "cm", "px")
_AMOUNTS = ("l", "ml", "kg", "g", "m^3")
_TEMPERATURES = ("degC", "°C", "K")
_ROBOT, _OTHERS = "robot", "world"


@dataclass(frozen=True)
class Guess:
    """State spaces that columns suggest.

    Attributes:
        spaces: per object.
        robot: the object that commands are given to.
        notes: what was guessed, a line a variable.
    """

    spaces: dict[str, StateSpace]
    robot: str
    notes: tuple[str, ...]


def guess_spaces(pieces: Sequence[Demonstration], robot: str = "") -> Guess:
    """Objects, kinds and roles from columns `object.variable [unit]`.

    Args:
        pieces: as read.
        robot: which object is the robot; by default that whose variables have columns `command.variable`.

    Raises:
        InputError: if there are no such columns, no times, or the robot isn't known.
    """
    columns: dict[str, dict[str, list[FloatArray]]] = {}
    units: dict[str, str] = {}
    commands: set[str] = set()
    for piece in pieces:
        if TIME not in piece.table:
            raise InputError(f"{piece.name}: column {TIME} is missing; give the time of each row in seconds")
        for name in map(str, piece.table.columns):
            obj, dot, variable = name.partition(".")
            if "->" in name or not dot:
                continue
            if obj == COMMAND:
                commands.add(variable)
                continue
            columns.setdefault(obj, {}).setdefault(variable, []).append(as_numbers(piece.table[name]))
            if name in piece.units:
                units[name] = piece.units[name]
    if len(columns) < 2:
        raise InputError("the logs need columns object.variable of at least two objects, such as 'cup.x [m]'")
    robot = robot or _commanded(columns, commands)
    if robot not in columns:
        raise InputError(f"there is no object {robot!r} to be the robot; objects are {', '.join(columns)}")
    spaces, notes = {}, []
    for obj, variables in columns.items():
        frame = _ROBOT if obj == robot else _OTHERS
        amounts = [v for v in variables if units.get(f"{obj}.{v}") in _AMOUNTS]
        guessed = []
        for name, parts in variables.items():
            unit = units.get(f"{obj}.{name}", "")
            found = _variable(name, unit, np.concatenate(parts), frame, amounts)
            guessed.append(found)
            said = "no unit given, taken as a plain number" if not unit else f"in {unit}"
            what = f", {found.role.kind}" if found.role is not None else ", no role"
            notes.append(f"{obj}.{name}: {said}; {found.kind}{what}")
        spaces[obj] = StateSpace(obj, tuple(guessed))
    return Guess(spaces, robot, tuple(notes))


def _commanded(columns: dict[str, dict[str, list[FloatArray]]], commands: set[str]) -> str:
    owners = [obj for obj, variables in columns.items() if commands and commands <= set(variables)]
    if len(owners) != 1:
        raise InputError(f"which object is the robot isn't known; name it with --robot (of {', '.join(columns)})")
    return owners[0]


def _variable(name: str, unit: str, values: FloatArray, frame: str, amounts: Sequence[str]) -> Variable:
    """A variable by its name, unit and readings."""
    known = values[np.isfinite(values)]
    whole = len(known) > 0 and bool((known == np.round(known)).all())
    kind: Kind = "real"
    lower, upper = -math.inf, math.inf
    role: Role | None = None
    if whole and set(np.unique(known)) <= {0.0, 1.0}:
        return Variable(name, unit or "1", 0.0, 1.0, "binary")
    if name in ("x", "y", "z") and unit in _LENGTHS:
        role = Role("position", frame, name)
    elif unit == "rad":
        kind, lower, upper, role = "angle", -math.pi, math.pi, Role("orientation", frame)
    elif unit in _AMOUNTS:
        lower, role = 0.0, Role("amount")
    elif len(amounts) == 1 and unit in _TEMPERATURES:
        role = Role("intensive", of=amounts[0])
    elif whole:
        kind, lower, upper, role = "integer", float(known.min()), float(known.max()), Role("level")
    return Variable(name, unit or "1", lower, upper, kind, role)
