"""HDF5 as robomimic writes it: a group a demonstration, arrays of a row a step in it."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np

from ichain_drake.demonstrations.importing.hdf5_file import group_in, groups_of, numbers, opened_hdf5
from ichain_drake.demonstrations.importing.log_map import LogMap
from ichain_drake.demonstrations.importing.pieces import check_size, columns_of, few, piece_of
from ichain_drake.demonstrations.table import Demonstration
from ichain_drake.errors import InputError
from ichain_drake.files import printable


def read_robomimic(file: Path, mapping: LogMap) -> list[Demonstration]:
    """Every demonstration as a piece, in order of its number.

    Links to other places and files are not followed, data kept in other files is not read.

    Args:
        file: of HDF5, with a group `data`.
        mapping: sources are data sets in a demonstration's group, such as `obs/object[0]` or `actions[3]`. Without
            `rate` or `time`, the control frequency in the file's `env_args` says how far apart rows are.

    Raises:
        InputError: if it is no such file, a data set is missing or links elsewhere, or it is too large.
    """
    pieces, rows = [], 0
    with opened_hdf5(file) as stored:
        group = group_in(stored, "data", str(file))
        if group is None:
            raise InputError(f"{file}: it has no group data; robomimic keeps its demonstrations there")
        rate = None if mapping.time else mapping.rate or _rate(group, file)
        for name, demonstration in groups_of(group, str(file)):
            where = f"{file}: {printable(name)}"
            values = {s: numbers(demonstration, s, where) for s in mapping.sources}
            lengths = {len(v) for v in values.values()}
            if len(lengths) > 1:
                raise InputError(f"{where}: its data sets have {few([str(n) for n in sorted(lengths)])} rows")
            rows += max(lengths)
            check_size(rows, mapping, str(file))
            times = np.arange(max(lengths)) / rate if rate else values[mapping.time]  # type: ignore[index]
            pieces.append(piece_of(name, times, columns_of(values, mapping, where), mapping))
    if not pieces:
        raise InputError(f"{file}: its group data holds no demonstration")
    return pieces


def _rate(group: Any, file: Path) -> float:
    """Rows a second, from what robomimic keeps about the environment."""
    try:
        about = json.loads(group.attrs["env_args"])
        rate = float(about["env_kwargs"]["control_freq"])
    except (KeyError, TypeError, ValueError, RecursionError):
        rate = math.nan
    if not 0 < rate < math.inf:
        raise InputError(f"{file}: nothing tells how far apart its rows are; give rate in the map, in Hz")
    return rate
