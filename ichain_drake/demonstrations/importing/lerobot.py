"""LeRobot data sets, version 2.0 to 3.0: Parquet files of many rows, told apart by their episode."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from ichain_drake.demonstrations.columns import as_numbers
from ichain_drake.demonstrations.importing.log_map import LogMap
from ichain_drake.demonstrations.importing.pieces import check_size, columns_of, few, pick, piece_of
from ichain_drake.demonstrations.importing.sources import Source
from ichain_drake.demonstrations.parquet import read_parquet
from ichain_drake.demonstrations.table import Demonstration
from ichain_drake.errors import InputError
from ichain_drake.files import check_folder, printable, read_whole
from ichain_drake.state import FloatArray

_VERSIONS = ("v2.0", "v2.1", "v3.0")
_EPISODE, _FRAME = "episode_index", "frame_index"
_MOST_INFO = 10**7  # bytes of meta/info.json; those of large data sets have some ten thousand


def read_lerobot(folder: Path, mapping: LogMap) -> list[Demonstration]:
    """Every episode of a data set as a piece, at frame / fps seconds unless the map names a time.

    What `meta/info.json` says of where files are is not followed: as LeRobot itself does, all of `data/*/*.parquet` is
    read. Pictures and videos are left alone.

    Args:
        folder: with `meta` and `data`.
        mapping: sources are columns; places in them numbers, or the names that `meta/info.json` gives.

    Raises:
        InputError: if it is no such data set, a column is missing, or it is too large.
    """
    check_folder(folder, "a LeRobot data set")
    info = _info(folder / "meta" / "info.json")
    rate = mapping.rate or _rate(info, folder)
    files = sorted((folder / "data").glob("*/*.parquet"))
    if not files:
        raise InputError(f"{folder}: data/*/*.parquet is missing; a LeRobot data set keeps its rows there")
    wanted = list(dict.fromkeys([_EPISODE, _FRAME, *(s.name for s in mapping.sources)]))
    names = {s.name: _names(info, s.name) for s in mapping.sources}
    rows, parts = 0, []
    for file in files:
        table, _ = read_parquet(file, "the data set", wanted)
        for name in wanted:
            if name not in table.columns:
                known = info.get("features")
                raise InputError(
                    f"{file}: it has no column {printable(name)}; the data set has "
                    f"{few(known) if isinstance(known, Mapping) else few(list(table.columns))}"
                )
        rows += len(table)
        check_size(rows, mapping, str(folder))
        values = {s.text: _column(table[s.name], s, names[s.name], file) for s in mapping.sources}
        parts.append(pd.DataFrame({_EPISODE: as_numbers(table[_EPISODE]), _FRAME: as_numbers(table[_FRAME]), **values}))
    every = pd.concat(parts, ignore_index=True)
    if not np.isfinite(every[[_EPISODE, _FRAME]].to_numpy()).all():
        raise InputError(f"{folder}: {_EPISODE} or {_FRAME} is no number in some row; mend the data set")
    pieces = []
    for number in sorted(set(every[_EPISODE])):
        episode = every[every[_EPISODE] == number]
        name = f"episode_{int(number):06d}"
        data = {s: episode[s.text].to_numpy() for s in mapping.values}
        times = episode[_FRAME].to_numpy() / rate if mapping.time is None else episode[mapping.time.text].to_numpy()
        columns = columns_of(data, mapping, f"{folder}: {name}")
        pieces.append(piece_of(name, times, columns, mapping))
    return pieces


def _column(column: pd.Series, source: Source, names: Sequence[str], file: Path) -> FloatArray:
    if column.dtype != object:
        return pick(column.to_numpy(), source, names, str(file))
    try:
        values = np.stack([np.asarray(v) for v in column])
    except (ValueError, TypeError):
        raise InputError(f"{file}: cells of {printable(source.name)} differ in size; map another source") from None
    return pick(values, source, names, str(file))


def _info(file: Path) -> Mapping[str, Any]:
    """What a data set says of itself, as far as it is used."""
    text = read_whole(file, "the data set's description", _MOST_INFO)
    try:
        info: Any = json.loads(text)
    except (ValueError, RecursionError):
        raise InputError(f"{file}: it is no JSON; a LeRobot data set describes itself there") from None
    version = info.get("codebase_version") if isinstance(info, dict) else None
    if version not in _VERSIONS:
        raise InputError(
            f"{file}: codebase_version {printable(str(version))!r:.40}; data sets of {', '.join(_VERSIONS)} are read: "
            "convert it with LeRobot"
        )
    return info  # type: ignore[no-any-return]


def _rate(info: Mapping[str, Any], folder: Path) -> float:
    rate = info.get("fps")
    if isinstance(rate, bool) or not isinstance(rate, int | float) or not 0 < rate < math.inf:
        raise InputError(f"{folder}: fps {printable(str(rate))!r:.40} in meta/info.json; give rate in the map, in Hz")
    return float(rate)


def _names(info: Mapping[str, Any], name: str) -> list[str]:
    """Names of a vector's entries: a list, or a list under one key such as `motors`."""
    features = info.get("features")
    feature = features.get(name) if isinstance(features, dict) else None
    names = feature.get("names") if isinstance(feature, dict) else None
    if isinstance(names, dict) and len(names) == 1:
        names = next(iter(names.values()))
    return [str(n) for n in names] if isinstance(names, list) else []
