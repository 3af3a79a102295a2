"""HDF5 as robomimic writes it: a group a demonstration, arrays of a row a step in it."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path
from typing import Any

import numpy as np

from ichain_drake.demonstrations.importing.extra import require
from ichain_drake.demonstrations.importing.log_map import LogMap, Source
from ichain_drake.demonstrations.importing.pieces import MOST_CELLS, check_size, few, pick, piece_of
from ichain_drake.demonstrations.table import Demonstration
from ichain_drake.errors import InputError
from ichain_drake.files import is_file, printable
from ichain_drake.state import FloatArray

_MOST_DEMONSTRATIONS = 10**5
_OWN_FILTERS = frozenset({1, 2, 3, 4, 5, 6, 32000})
"""Of the HDF5 library and h5py: for others a file could ask for a program on this machine to be loaded."""


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
    h5py = require("h5py", "reading HDF5")
    if not is_file(file):
        raise InputError(f"{file}: there is no such file of HDF5")
    try:
        with h5py.File(file, "r") as opened:
            group = _member(h5py, opened, "data", str(file))
            if not isinstance(group, h5py.Group):
                raise InputError(f"{file}: it has no group data; robomimic keeps its demonstrations there")
            if len(group) > _MOST_DEMONSTRATIONS:
                raise InputError(f"{file}: {len(group)} demonstrations are too many; split it")
            rate = None if mapping.time else mapping.rate or _rate(group, file)
            pieces, rows = [], 0
            for name in sorted(group, key=_number):
                where = f"{file}: {printable(name)}"
                demonstration = _member(h5py, group, name, where)
                if not isinstance(demonstration, h5py.Group):
                    continue
                values = {s: _numbers(h5py, demonstration, s, where) for s in mapping.sources}
                lengths = {len(v) for v in values.values()}
                if len(lengths) > 1:
                    raise InputError(f"{where}: its data sets have {few([str(n) for n in sorted(lengths)])} rows")
                rows += max(lengths)
                check_size(rows, mapping, str(file))
                times = np.arange(max(lengths)) / rate if rate else values[mapping.time]  # type: ignore[index]
                pieces.append(piece_of(name, times, values, mapping))
    except InputError:
        raise
    except Exception as error:  # whatever h5py makes of damage
        line = printable((str(error).splitlines() or [""])[0][:200])
        raise InputError(f"{file}: can't read it as HDF5: {line or type(error).__name__}") from None
    if not pieces:
        raise InputError(f"{file}: its group data holds no demonstration")
    return pieces


def _number(name: str) -> tuple[int, str]:
    found = re.search(r"\d{1,18}", name)
    return (int(found[0]) if found else -1), name


def _member(h5py: Any, group: Any, name: str, where: str) -> Any:
    """What is under a name, `a/b` for a member of a member; None if nothing is.

    Raises:
        InputError: if it is a link to somewhere else.
    """
    found = group
    for part in name.split("/"):
        if not isinstance(found, h5py.Group) or not part or part == ".." or part not in found:
            return None
        if not isinstance(found.get(part, getlink=True), h5py.HardLink):
            raise InputError(f"{where}: {printable(name)} is a link to somewhere else, and is not followed; copy it")
        found = found[part]
    return found


def _numbers(h5py: Any, group: Any, source: Source, where: str) -> FloatArray:
    stored = _member(h5py, group, source.name, where)
    if not isinstance(stored, h5py.Dataset):
        raise InputError(f"{where}: it has no data set {printable(source.name)}; it has {few(list(group))}")
    if stored.ndim == 0 or stored.dtype.kind not in "fiub":
        raise InputError(f"{where}: {printable(source.name)} holds no rows of numbers; map another source")
    if stored.size > MOST_CELLS:
        raise InputError(f"{where}: {printable(source.name)} claims {stored.size} numbers; too many are not read")
    plan = stored.id.get_create_plist()
    filters = {plan.get_filter(i)[0] for i in range(plan.get_nfilters())}
    if stored.external or stored.is_virtual or not filters <= _OWN_FILTERS:
        raise InputError(f"{where}: {printable(source.name)} is kept in other files, or packed by a program of its own")
    return pick(stored[()], source, (), where)


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
