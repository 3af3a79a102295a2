"""What several scenarios refuse in their configurations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ichain_drake.errors import InputError


def check_numbers(scenario: str, lists: Mapping[str, tuple[Sequence[float], int]]) -> None:
    """Refuse lists that are not so many finite numbers.

    Args:
        scenario: its name, for the error.
        lists: values and how many there must be, by key.

    Raises:
        InputError: naming the key.
    """
    for key, (values, size) in lists.items():
        if len(values) != size or not np.isfinite(values).all():
            raise InputError(f"{scenario}: {key} is {values}; give {size} numbers")


def check_ranges(scenario: str, ranges: Mapping[str, tuple[Sequence[float], float]]) -> None:
    """Refuse ranges that do not lead upwards from 0 or more.

    Args:
        scenario: its name, for the error.
        ranges: from and to, and the most that is possible, by key.

    Raises:
        InputError: naming the key.
    """
    for key, ((low, high), most) in ranges.items():
        if not 0.0 <= low <= high <= most:
            raise InputError(f"{scenario}: {key} is {[low, high]}; give from and to within 0..{most:g}")
