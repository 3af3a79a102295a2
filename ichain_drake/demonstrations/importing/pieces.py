"""From columns that a reader found to pieces, and what every reader says when it finds something else."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from ichain_drake.demonstrations.columns import TIME
from ichain_drake.demonstrations.importing.log_map import LogMap
from ichain_drake.demonstrations.importing.rotations import angles_of
from ichain_drake.demonstrations.importing.sources import Source
from ichain_drake.demonstrations.table import Demonstration
from ichain_drake.errors import InputError
from ichain_drake.files import printable
from ichain_drake.state import FloatArray

MOST_CELLS = 5 * 10**7
"""Numbers that are read of one log at most: 400 MB; two hundred hours at 30 Hz of a graph of the size of ours."""


def pick(values: Any, source: Source, names: Sequence[str], where: str) -> FloatArray:
    """The numbers of one source out of its column.

    Args:
        values: shape (n,), or (n, ...) where `source` has a place in it.
        source: which.
        names: of a vector's entries, where they are known.
        where: what to call the log in errors.

    Raises:
        InputError: if there is nothing, no such place, or the source is a vector and none is said.
    """
    array = np.asarray(values)
    if array.dtype.kind not in "fiub":
        raise InputError(f"{where}: {printable(source.name)} holds no numbers; map another source")
    if not array.size:
        raise InputError(f"{where}: {printable(source.name)} has no rows, or nothing in them")
    flat = array.reshape(len(array), -1)
    if not source.place:
        if flat.shape[1] != 1:
            raise InputError(
                f"{where}: {printable(source.name)} has {flat.shape[1]} numbers; say which, as in {source.name}[0]"
            )
        return flat[:, 0].astype(float)
    places = {str(i): i for i in range(flat.shape[1])} | {n: i for i, n in enumerate(names) if i < flat.shape[1]}
    if source.place not in places:
        known = f", or {few(names)}" if names else ""
        raise InputError(
            f"{where}: {printable(source.text)}: there are places 0 to {flat.shape[1] - 1}{known}; choose one"
        )
    return flat[:, places[source.place]].astype(float)


def few(names: Collection[str]) -> str:
    """Some names, for an error."""
    shown = [printable(str(n)) for n in names]
    return (", ".join(shown[:8]) + (", ..." if len(shown) > 8 else "")) or "nothing"  # noqa: PLR2004 - a line's worth


def columns_of(values: Mapping[Source, FloatArray], mapping: LogMap, where: str) -> dict[str, FloatArray]:
    """What sources become, each of shape (n,), by the names of the columns.

    Args:
        values: of each source, shape (n,).
        mapping: says what they become.
        where: what to call the log in errors.

    Raises:
        InputError: if there should be a rotation and is none.
    """
    columns = {target: values[source] for source, target in mapping.columns.items()}
    for rotation in mapping.rotations:
        columns |= angles_of(rotation, values, where)
    return columns


def piece_of(name: str, times: FloatArray, columns: Mapping[str, FloatArray], mapping: LogMap) -> Demonstration:
    """One piece, its time from 0.

    Args:
        name: of it.
        times: [s], shape (n,).
        columns: as `columns_of` gives them, shape (n,).
        mapping: says their units.
    """
    start = times[0] if len(times) else 0.0
    return Demonstration(pd.DataFrame({TIME: times - start, **columns}), dict(mapping.units), name)


def check_size(rows: int, mapping: LogMap, where: str) -> None:
    """Refuse what would take more memory than any log needs.

    Raises:
        InputError: says how much it is.
    """
    columns = len(mapping.values)
    if rows * (columns + 1) > MOST_CELLS:
        raise InputError(f"{where}: {rows} rows of {columns} columns are too many; split it")
