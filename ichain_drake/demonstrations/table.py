"""A demonstration: one recorded piece as a table, and the check of it where it enters."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from ichain_drake.demonstrations.checks import check_columns, check_values
from ichain_drake.demonstrations.columns import TIME, column
from ichain_drake.errors import InputError
from ichain_drake.graph import InteractionGraph
from ichain_drake.state import FloatArray, StateSpace


@dataclass(frozen=True)
class Demonstration:
    """One piece of demonstration.

    Attributes:
        table: columns `time` [s], `object.variable` for each measured variable, `command.variable` for the hand
            command in force from a row to the next (optional), and `parent->child` for active flags (0 or 1, optional).
        units: unit of each variable column.
        name: what errors call it; the file it came from.
        first_line: line of that file in which the first row is.
        open: per interaction name rows, shape (n_rows,), in which nothing shows whether it is active, for
            interactions whose flags were inferred from states (see `learning.discovery`).
    """

    table: pd.DataFrame
    units: Mapping[str, str] = field(default_factory=dict)
    name: str = "demonstration"
    first_line: int = 2
    open: Mapping[str, NDArray[np.bool_]] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.table)

    @property
    def period(self) -> float:
        """Median time between rows [s]."""
        return float(np.median(np.diff(self.table[TIME])))

    def has(self, obj: str, space: StateSpace) -> bool:
        """Whether every observable variable of an object is in the table."""
        return all(column(obj, v) in self.table for v in space.observable.names)

    def states(self, obj: str, space: StateSpace) -> FloatArray:
        """Measured states of one object, shape (n_rows, n_observable).

        Raises:
            InputError: if a variable's column is missing.
        """
        names = [column(obj, v) for v in space.observable.names]
        missing = [n for n in names if n not in self.table]
        if missing:
            raise InputError(f"{self.name}: column {missing[0]} is missing; it has {', '.join(self.table.columns)}")
        return self.table[names].to_numpy(dtype=float)

    def check(self, graph: InteractionGraph, objects: Sequence[str] | None = None) -> None:
        """Check a table where it enters.

        Args:
            graph: names the objects, variables, units and interactions that may appear.
            objects: objects that must be there; default: none, but at least one object must be complete.

        Raises:
            InputError: on missing or unknown columns, wrong units, times that are unsorted, doubled or not at the
                library's period, NaN, flags other than 0 and 1, or values far beyond their bounds; with table, column
                and line.
        """
        check_columns(self, graph, objects)
        check_values(self, graph)


def data_hash(pieces: Sequence[Demonstration]) -> str:
    """A hash of demonstrations' values, for a library's manifest."""
    digest = hashlib.sha256()
    for piece in pieces:
        digest.update(",".join(piece.table.columns).encode())
        digest.update(pd.util.hash_pandas_object(piece.table, index=False).to_numpy().tobytes())
    return digest.hexdigest()
