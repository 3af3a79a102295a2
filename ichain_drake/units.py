"""Units: whether one can be converted into another, and what a value becomes."""

from __future__ import annotations

import re
from functools import cache
from typing import Any

import numpy as np

from ichain_drake.errors import InputError
from ichain_drake.state import FloatArray

_SYMBOL = r"(?:[A-Za-zµμΩ°_]{1,20}(?:(?:\^|\*\*)?[-+]?[1-9])?|1|%)"
# No arithmetic reaches pint: `9**9**9` would be worked out.
_UNIT = re.compile(rf"{_SYMBOL}(?:\s*[*/·. ]\s*{_SYMBOL}){{0,4}}")
_HEADER = re.compile(r"^(?P<name>.*?)\s*(?:\[(?P<unit>[^\[\]]*)\]|\((?P<round>[^()]*)\))$")


def split_unit(header: str) -> tuple[str, str | None]:
    """A column's name and the unit behind it in brackets, as in `car.x [px]`; None where there is none."""
    found = _HEADER.match(header)
    if found is None or not found["name"]:
        return header.strip(), None
    return found["name"].strip(), (found["unit"] if found["unit"] is not None else found["round"]).strip()


def convert(values: FloatArray, unit: str, wanted: str) -> FloatArray:
    """Values in another unit.

    Args:
        values: any shape, in `unit`.
        unit: such as `mm`, `deg/s`, `°`, `1`.
        wanted: the same.

    Returns:
        The same shape, in `wanted`.

    Raises:
        InputError: if a unit isn't known, or there is no way from the one to the other. An angle is no plain number
            here, and a pixel no length.
    """
    if unit == wanted:
        return values
    first, second = _parsed(unit), _parsed(wanted)
    try:
        # Not by dimension: to pint an angle has none, and degrees would become stick axes.
        if _registry().get_root_units(first)[1] != _registry().get_root_units(second)[1]:
            raise InputError(f"there is no way from {unit} to {wanted}")
        return np.asarray(_registry().Quantity(values, first).m_as(second), dtype=float)
    except InputError:
        raise
    except Exception as error:  # offsets (degC) within products
        raise InputError(f"{unit} can't be converted into {wanted} ({error})") from None


def _parsed(unit: str) -> Any:
    if len(unit) > 40 or not _UNIT.fullmatch(unit):
        raise InputError(f"{unit!r:.50} is no unit; write it as m, rad/s or px")
    plain = re.sub(r"\b(px|pixels?)\b", "screen_pixel", unit)
    plain = plain.replace("°C", "degC").replace("°", "degree").replace("·", "*").replace("%", "percent")
    try:
        return _registry().parse_units(re.sub(r"(?<![\w^*+-])1(?!\w)", "dimensionless", plain))
    except Exception:  # pint's own kinds, and of its parser
        raise InputError(f"unit {unit!r} is not known") from None


@cache
def _registry() -> Any:
    """Pint's units, loaded at the first conversion: that takes half a second."""
    import pint  # noqa: PLC0415

    units: Any = pint.UnitRegistry()
    units.define("screen_pixel = [screen]")  # pint's own pixel is a printer's, of a known length
    return units
