"""The two sides of a map: a number of a log, and what it becomes."""

from __future__ import annotations

import re
from dataclasses import dataclass

from ichain_drake.demonstrations.columns import TIME
from ichain_drake.errors import InputError
from ichain_drake.files import printable
from ichain_drake.units import split_unit

_TARGET = re.compile(r"[^\s.\[\]<>-]+(\.[^\s.\[\]]+|->[^\s.\[\]<>-]+)")
_PLACE = re.compile(r"(?P<name>.*?)(?:\[(?P<place>[^\[\]]+)\])?")


@dataclass(frozen=True)
class Source:
    """One number in every row, or message, of a log.

    Attributes:
        text: as it was written.
        name: of the column, data set or field that holds it.
        place: in that, where it is a vector: a number from 0, or the name of an entry; empty for a plain number.
    """

    text: str
    name: str
    place: str = ""

    @classmethod
    def parse(cls, text: str) -> Source:
        """`name` or `name[place]`."""
        found = _PLACE.fullmatch(text)
        if found is None or not found["name"]:
            raise InputError(f"map: {printable(text)!r:.80} is no source; write column, or column[0] for a part of it")
        return cls(text, found["name"], found["place"] or "")


def split_target(written: object, where: str) -> tuple[str, str | None]:
    """A target and its unit, None where none is said.

    Args:
        written: `object.variable [unit]`, `command.variable [unit]` or `parent->child`.
        where: what to call the map in errors.

    Raises:
        InputError: if it is none.
    """
    target, unit = split_unit(written) if isinstance(written, str) else ("", None)
    if not _TARGET.fullmatch(target) or target == TIME:
        raise InputError(
            f"{where}: {printable(str(written))!r:.80} is no target; write object.variable [unit], command.variable "
            "[unit], or parent->child"
        )
    return target, unit
