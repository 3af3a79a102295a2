"""What the columns of a piece are, for who writes them in another format, and pieces sorted by what they hold."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import yaml

from ichain_drake.demonstrations.columns import COMMAND, TIME
from ichain_drake.demonstrations.table import Demonstration
from ichain_drake.errors import InputError


@dataclass(frozen=True)
class Columns:
    """The columns of a piece by kind, in their order.

    Attributes:
        states: `object.variable`.
        commands: `command.variable`.
        flags: `parent->child`.
    """

    states: tuple[str, ...]
    commands: tuple[str, ...]
    flags: tuple[str, ...]

    @classmethod
    def of(cls, piece: Demonstration) -> Columns:
        """Those of a piece.

        Raises:
            InputError: if it has no time, no state, a cell that is empty, or a column of another kind.
        """
        names = [str(c) for c in piece.table.columns if c != TIME]
        flags = tuple(n for n in names if "->" in n)
        commands = tuple(n for n in names if n.startswith(f"{COMMAND}.") and n not in flags)
        states = tuple(n for n in names if "." in n and n not in commands and n not in flags)
        other = [n for n in names if n not in flags and n not in commands and n not in states]
        if other:
            raise InputError(f"{piece.name}: column {other[0]} is no object.variable and no parent->child; remove it")
        if TIME not in piece.table or not states or not len(piece):
            raise InputError(f"{piece.name}: it holds no {TIME} or no object.variable; there is nothing to write")
        if piece.table.isna().any(axis=None):
            raise InputError(f"{piece.name}: it has empty cells; take its rows together with --resample")
        return cls(states, commands, flags)


def by_columns(pieces: Sequence[Demonstration]) -> dict[Columns, list[Demonstration]]:
    """Pieces that hold the same, together."""
    found: dict[Columns, list[Demonstration]] = {}
    for piece in pieces:
        found.setdefault(Columns.of(piece), []).append(piece)
    return found


def map_text(columns: Mapping[str, str], units: Mapping[str, str], time: str = "", rate: float = 0.0) -> bytes:
    """The mapping file that `ichain import` reads what was written back with.

    Args:
        columns: what each source becomes.
        units: of these.
        time: source of the time; empty for what the format says.
        rate: rows a second [Hz]; 0 for what the format says.
    """
    written = {s: f"{t} [{units[t]}]" if t in units else t for s, t in columns.items()}
    plain = {"columns": written, **({"time": time} if time else {}), **({"rate": rate} if rate else {})}
    return yaml.safe_dump(plain, sort_keys=False, allow_unicode=True).encode()
