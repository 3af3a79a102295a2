"""What becomes of somebody's log: which of its numbers is which variable of which object, in which unit."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ichain_drake.demonstrations.importing.rotations import FORM, Quaternion, parse_rotation
from ichain_drake.demonstrations.importing.sources import Source, split_target
from ichain_drake.errors import InputError
from ichain_drake.files import printable

_KEYS = ("columns", "rotations", "rate", "time")
_FORM = (
    'columns: {"source[0]": "object.variable [unit]", ...}, and where needed rotations (a list), rate (Hz) and time '
    "(a source)"
)


@dataclass(frozen=True)
class LogMap:
    """What a mapping file says.

    Attributes:
        columns: what each source becomes: `object.variable`, `command.variable` or `parent->child`, in order.
        units: of these, where they are said, and of all angles of rotations.
        rate: rows a second, for logs that don't say it [Hz]; None if it isn't given.
        time: source of the time [s]; None for what the format itself says.
        rotations: quaternions that become angles.
    """

    columns: Mapping[Source, str]
    units: Mapping[str, str]
    rate: float | None = None
    time: Source | None = None
    rotations: tuple[Quaternion, ...] = ()

    @property
    def values(self) -> list[Source]:
        """Everything that becomes something, each once."""
        return list(dict.fromkeys([*self.columns, *(s for r in self.rotations for s in r.sources)]))

    @property
    def sources(self) -> list[Source]:
        """Everything that is read, the time included."""
        return [*self.values, *([self.time] if self.time else [])]


def parse_map(plain: Any, where: str) -> LogMap:
    """A mapping from what its file holds.

    Args:
        plain: as YAML gives it.
        where: what to call it in errors.

    Raises:
        InputError: on another form, a target that is no variable, command or interaction, or one that is named twice.
    """
    if not isinstance(plain, Mapping) or not (plain.get("columns") or plain.get("rotations")):
        raise InputError(f"{where}: a map has {_FORM}")
    for key in plain:
        if key not in _KEYS:
            raise InputError(f"{where}: {printable(str(key))!r:.80} is unknown; a map has {_FORM}")
    written, listed = plain.get("columns", {}), plain.get("rotations", [])
    if not isinstance(written, Mapping):
        raise InputError(f"{where}: a map has {_FORM}")
    if not isinstance(listed, list):
        raise InputError(f"{where}: rotations is a list of {FORM}")
    columns: dict[Source, str] = {}
    units: dict[str, str] = {}
    for source, text in written.items():
        if not isinstance(source, str) or not isinstance(text, str):
            raise InputError(f"{where}: {printable(str(source))!r:.80}: write texts on both sides; {_FORM}")
        columns[Source.parse(source)], unit = split_target(text, where)
        if unit is not None:
            units[columns[Source.parse(source)]] = unit
    rotations = tuple(parse_rotation(entry, where) for entry in listed)
    found = Counter([*columns.values(), *(target for r in rotations for target in r.angles.values())])
    for target, times in found.items():
        if times > 1:
            raise InputError(f"{where}: {target} is named twice; one source makes a column")
    units |= {target: unit for r in rotations for target, unit in r.units.items()}
    rate, time = plain.get("rate"), plain.get("time")
    if rate is not None and (isinstance(rate, bool) or not isinstance(rate, int | float) or not 0 < rate < math.inf):
        raise InputError(f"{where}: rate {printable(str(rate))!r:.40}: give rows a second, a number above 0")
    if time is not None and not isinstance(time, str):
        raise InputError(f"{where}: time {printable(str(time))!r:.40}: give the source that holds it, in seconds")
    return LogMap(
        columns,
        units,
        None if rate is None else float(rate),
        None if time is None else Source.parse(time),
        rotations,
    )
