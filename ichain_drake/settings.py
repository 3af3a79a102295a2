"""Settings: what a configuration's dataclass declares about each of its fields, and the check of values against it.

Unit, range and default of a setting stand beside its field, its meaning in the class's docstring under `Attributes`.
`check_settings` refuses values by them, `ichain settings` and the documentation list them. A field without
`setting(...)`, such as those of a user's own classes, has to be finite, and that is all.
"""

# No `from __future__ import annotations`: Drake's typed YAML reader needs the fields' types themselves.

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import MISSING, dataclass, field, fields, is_dataclass
from typing import Any

from ichain_drake.errors import InputError

_KEY = "ichain_drake.setting"


@dataclass(frozen=True)
class Declared:
    """What is declared about a setting. Bounds hold for every number in it, where it is a list or a mapping.

    Attributes:
        unit: of the numbers; `{unit}` in it stands for the unit of the plane that paths lie in.
        above, below: numbers must be greater, or less, than these.
        lower, upper: least and greatest number.
        size: how many items a list has; None for any number.
        filled: whether an empty text or list is refused.
        rising: whether a list must not fall, as from and to.
        choices: texts that are allowed; empty for any.
    """

    unit: str = ""
    above: float | None = None
    lower: float | None = None
    below: float | None = None
    upper: float | None = None
    size: int | None = None
    filled: bool = False
    rising: bool = False
    choices: tuple[str, ...] = ()

    def allows(self, value: float) -> bool:
        """Whether a number is finite and within the bounds."""
        if isinstance(value, float) and not math.isfinite(value):
            return False
        return (
            (self.above is None or value > self.above)
            and (self.lower is None or value >= self.lower)
            and (self.below is None or value < self.below)
            and (self.upper is None or value <= self.upper)
        )

    def bounds(self) -> str:
        """The range in words; empty if there is none."""
        low = f"above {self.above:g}" if self.above is not None else ""
        low = f"from {self.lower:g}" if self.lower is not None else low
        high = f"below {self.below:g}" if self.below is not None else ""
        joined = "to" if low.startswith("from") else "up to"
        high = f"{joined} {self.upper:g}" if self.upper is not None else high
        return f"{low} and {high}" if low.startswith("above") and high else f"{low} {high}".strip()


def setting(default: Any, unit: str = "", **declared: Any) -> Any:
    """A field of a configuration, with what is declared about it.

    Args:
        default: the value, or a function of no arguments that makes it (for lists and the like).
        unit: of its numbers.
        declared: further fields of `Declared`.
    """
    metadata = {_KEY: Declared(unit, **declared)}
    if callable(default):
        return field(default_factory=default, metadata=metadata)
    return field(default=default, metadata=metadata)


def declared_of(item: Any) -> Declared:
    """What is declared about a dataclass field; nothing but its kind if nothing is."""
    return item.metadata.get(_KEY, Declared())


def default_of(item: Any) -> Any:
    """Default of a dataclass field; None if it has none."""
    if item.default is not MISSING:
        return item.default
    return item.default_factory() if item.default_factory is not MISSING else None


def check_settings(config: Any, unit: str = "unit", where: str = "") -> None:
    """Refuse values that are not what their settings allow.

    Args:
        config: a dataclass; those inside it are checked too.
        unit: in place of `{unit}`.
        where: key of `config` itself.

    Raises:
        InputError: naming the key, the value, and what is allowed.
    """
    for item in fields(config):
        key = f"{where}.{item.name}" if where else item.name
        _check(getattr(config, item.name), declared_of(item), key, unit)


def _check(value: Any, declared: Declared, key: str, unit: str) -> None:
    if is_dataclass(value) and not isinstance(value, type):
        check_settings(value, unit, key)
        return
    if isinstance(value, list | tuple) and any(is_dataclass(v) for v in value):
        for k, part in enumerate(value):
            _check(part, declared, f"{key}[{k}]", unit)
        return
    if declared.choices:
        for text in [value] if isinstance(value, str) else value:
            if text not in declared.choices:
                raise InputError(f"{key} {text!r}: choose {_either(declared.choices)}")
    numbers = list(_numbers(value))
    size_fits = declared.size is None or not isinstance(value, list) or len(value) == declared.size
    falls = declared.rising and any(b < a for a, b in zip(numbers, numbers[1:], strict=False))
    empty = declared.filled and isinstance(value, str | Sequence) and not value
    if falls or empty or not size_fits or not all(declared.allows(n) for n in numbers):
        raise InputError(f"{key} is {value!r}; give {_wanted(value, declared, unit)}")


def _numbers(value: Any) -> Iterator[float]:
    """All numbers in a value."""
    if isinstance(value, int | float) and not isinstance(value, bool):
        yield value
    elif isinstance(value, Mapping):
        for part in value.values():
            yield from _numbers(part)
    elif isinstance(value, Collection) and not isinstance(value, str | bytes):
        for part in value:
            yield from _numbers(part)


def _wanted(value: Any, declared: Declared, unit: str) -> str:
    """What a setting allows, in words."""
    if isinstance(value, str):
        return "a text that is not empty"
    if isinstance(value, list | Mapping):
        count = "" if declared.size is None else f"{declared.size} "
        what = f"{'one or more ' if declared.filled else ''}{count}numbers"
    else:
        what = "a whole number" if isinstance(value, int) else "a number"
    bounds = declared.bounds() or ("" if isinstance(value, int) else "that is finite").replace(
        "that is", "that are" if isinstance(value, list | Mapping) else "that is"
    )
    parts = f"{what} {bounds}".strip()
    rising = ", from and to" if declared.rising else ""
    return parts + rising + (f", in {declared.unit.format(unit=unit)}" if declared.unit else "")


def _either(choices: Sequence[str]) -> str:
    return f"{', '.join(choices[:-1])} or {choices[-1]}" if len(choices) > 1 else choices[0]


__all__ = ["Declared", "check_settings", "declared_of", "default_of", "setting"]
