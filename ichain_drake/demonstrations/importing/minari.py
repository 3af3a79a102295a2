"""Minari data sets: HDF5 with a group an episode, which has one observation more than actions."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ichain_drake.demonstrations.importing.hdf5_file import groups_of, numbers, opened_hdf5
from ichain_drake.demonstrations.importing.log_map import LogMap
from ichain_drake.demonstrations.importing.pieces import check_size, columns_of, few, piece_of
from ichain_drake.demonstrations.importing.sources import Source
from ichain_drake.demonstrations.table import Demonstration
from ichain_drake.errors import InputError
from ichain_drake.files import is_file, is_folder, printable
from ichain_drake.state import FloatArray

_FILE = "main_data.hdf5"
_EPISODE = "episode_"


def read_minari(source: Path, mapping: LogMap) -> list[Demonstration]:
    """Every episode as a piece, in order of its number.

    The row of an observation has the action that was taken at it. At the last observation none was: there the last
    action is still in force, as it is in what this library records. Neither Minari nor Gymnasium is asked, and what
    the data set says about its environment is not made.

    Args:
        source: the folder of a data set, with `data` in it, or that folder, or `main_data.hdf5` itself.
        mapping: sources are data sets of an episode, such as `observations[3]`, `observations/cup[0]`, `actions[0]`
            or `observations/_index_1[2]` (of a tuple). It says how far apart rows are, by `rate` or `time`.

    Raises:
        InputError: if it is no such data set, is kept in another format, a source is missing or links elsewhere, or it
            is too large.
    """
    rate = None if mapping.time else mapping.rate
    if rate is None and mapping.time is None:
        raise InputError("map: Minari doesn't tell how far apart rows are; give rate, in Hz, or time, a source")
    file = _file(source)
    pieces, rows = [], 0
    with opened_hdf5(file) as stored:
        for name, episode in groups_of(stored, str(file)):
            if not name.startswith(_EPISODE):
                continue
            where = f"{file}: {printable(name)}"
            values = _side_by_side({s: numbers(episode, s, where) for s in mapping.sources}, where)
            count = len(next(iter(values.values())))
            rows += count
            check_size(rows, mapping, str(file))
            times = np.arange(count) / rate if rate else values[mapping.time]  # type: ignore[index]
            pieces.append(piece_of(name, times, columns_of(values, mapping, where), mapping))
    if not pieces:
        raise InputError(f"{file}: it holds no episode")
    return pieces


def _file(source: Path) -> Path:
    """The file that holds the episodes.

    Raises:
        InputError: if there is none.
    """
    if not is_folder(source):
        return source
    for folder in (source / "data", source):
        if is_file(folder / _FILE):
            return folder / _FILE
    for folder in (source / "data", source):
        if is_file(folder / "metadata.json"):
            raise InputError(f"{folder}: {_FILE} is missing; of Minari's formats hdf5 is read: write it as that")
    raise InputError(f"{source}: data/{_FILE} is missing; a Minari data set keeps its episodes there")


def _side_by_side(values: dict[Source, FloatArray], where: str) -> dict[Source, FloatArray]:
    """Columns of one length: the last action once more beside the last observation."""
    lengths = sorted({len(v) for v in values.values()})
    if len(lengths) > 2 or lengths[-1] - lengths[0] > 1:  # noqa: PLR2004 - actions, observations
        counts = few([str(n) for n in lengths])
        raise InputError(f"{where}: its data sets have {counts} rows; an observation more than actions is read")
    return {s: v if len(v) == lengths[-1] else np.append(v, v[-1]) for s, v in values.items()}
