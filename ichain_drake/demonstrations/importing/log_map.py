"""What becomes of somebody's log: which of its numbers is which variable of which object, in which unit."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ichain_drake.demonstrations.columns import TIME
from ichain_drake.errors import InputError
from ichain_drake.files import printable
from ichain_drake.units import split_unit

_KEYS = ("columns", "rate", "time")
_TARGET = re.compile(r"[^\s.\[\]<>-]+(\.[^\s.\[\]]+|->[^\s.\[\]<>-]+)")
_PLACE = re.compile(r"(?P<name>.*?)(?:\[(?P<place>[^\[\]]+)\])?")
_FORM = 'columns: {"source[0]": "object.variable [unit]", ...}, and where needed rate (Hz) and time (a source)'


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


@dataclass(frozen=True)
class LogMap:
    """What a mapping file says.

    Attributes:
        columns: what each source becomes: `object.variable`, `command.variable` or `parent->child`, in order.
        units: of these, where they are said.
        rate: rows a second, for logs that don't say it [Hz]; None if it isn't given.
        time: source of the time [s]; None for what the format itself says.
    """

    columns: Mapping[Source, str]
    units: Mapping[str, str]
    rate: float | None = None
    time: Source | None = None

    @property
    def sources(self) -> list[Source]:
        """Everything that is read, the time included."""
        return [*self.columns, *([self.time] if self.time else [])]


def parse_map(plain: Any, where: str) -> LogMap:
    """A mapping from what its file holds.

    Args:
        plain: as YAML gives it.
        where: what to call it in errors.

    Raises:
        InputError: on another form, a target that is no variable, command or interaction, or one that is named twice.
    """
    if not isinstance(plain, Mapping) or not isinstance(plain.get("columns"), Mapping) or not plain["columns"]:
        raise InputError(f"{where}: a map has {_FORM}")
    for key in plain:
        if key not in _KEYS:
            raise InputError(f"{where}: {printable(str(key))!r:.80} is unknown; a map has {_FORM}")
    columns: dict[Source, str] = {}
    units: dict[str, str] = {}
    for source, written in plain["columns"].items():
        if not isinstance(source, str) or not isinstance(written, str):
            raise InputError(f"{where}: {printable(str(source))!r:.80}: write texts on both sides; {_FORM}")
        target, unit = split_unit(written)
        if not _TARGET.fullmatch(target) or target == TIME:
            raise InputError(
                f"{where}: {printable(written)!r:.80} is no target; write object.variable [unit], command.variable "
                "[unit], or parent->child"
            )
        if target in columns.values():
            raise InputError(f"{where}: {target} is named twice; one source makes a column")
        columns[Source.parse(source)] = target
        if unit is not None:
            units[target] = unit
    rate, time = plain.get("rate"), plain.get("time")
    if rate is not None and (isinstance(rate, bool) or not isinstance(rate, int | float) or not 0 < rate < math.inf):
        raise InputError(f"{where}: rate {printable(str(rate))!r:.40}: give rows a second, a number above 0")
    if time is not None and not isinstance(time, str):
        raise InputError(f"{where}: time {printable(str(time))!r:.40}: give the source that holds it, in seconds")
    return LogMap(columns, units, None if rate is None else float(rate), None if time is None else Source.parse(time))
