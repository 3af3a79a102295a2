"""What the columns of a piece are called and hold, and what is asked of a piece by whoever checks it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

import numpy as np
import pandas as pd

from ichain_drake.state import FloatArray, StateSpace

TIME = "time"
COMMAND = "command"
"""Object name under which the hand command in force since a row is recorded (paper sec. III: A_1)."""


def column(obj: str, variable: str) -> str:
    """Name of a measured variable's column: `object.variable`."""
    return f"{obj}.{variable}"


def as_numbers(values: pd.Series) -> FloatArray:
    """A column as floats, shape (n_rows,); NaN where something is no number."""
    try:
        return np.asarray(pd.to_numeric(values, errors="coerce").to_numpy(dtype=float, na_value=np.nan))
    except (TypeError, ValueError, OverflowError):  # lists, complex numbers, huge integers
        return np.array([_number(v) for v in values], dtype=float)


def _number(value: object) -> float:
    try:
        return float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError, OverflowError):
        return float("nan")


class Piece(Protocol):
    """A piece of demonstration as its checks see it; see `Demonstration`."""

    @property
    def table(self) -> pd.DataFrame: ...  # noqa: D102

    @property
    def units(self) -> Mapping[str, str]: ...  # noqa: D102

    @property
    def name(self) -> str: ...  # noqa: D102

    @property
    def first_line(self) -> int: ...  # noqa: D102

    def has(self, obj: str, space: StateSpace) -> bool: ...  # noqa: D102
