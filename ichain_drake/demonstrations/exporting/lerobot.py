"""Pieces as a LeRobot data set, version 3.0: without pictures, one Parquet file of all episodes."""

from __future__ import annotations

import io
import json
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from ichain_drake.demonstrations.exporting.columns import Columns, map_text
from ichain_drake.demonstrations.resampling import is_at
from ichain_drake.demonstrations.table import Demonstration
from ichain_drake.errors import InputError

_FILE = "chunk-000/file-000.parquet"
_COUNTS = ("frame_index", "episode_index", "index", "task_index")


def lerobot_files(pieces: Sequence[Demonstration], columns: Columns, task: str) -> dict[str, bytes]:
    """The files of a data set, by their path in its folder, and the map that reads it back.

    States become `observation.state`, commands `action`, flags `observation.active`, in single precision.

    Args:
        pieces: all with these columns.
        columns: theirs.
        task: what they show, in a sentence.

    Raises:
        InputError: if a piece isn't at a whole number of rows a second.
    """
    rate = _rate(pieces)
    groups = {"observation.state": columns.states, "action": columns.commands, "observation.active": columns.flags}
    groups = {key: names for key, names in groups.items() if names}
    tables, episodes, first = [], [], 0
    for number, piece in enumerate(pieces):
        rows = len(piece)
        data: dict[str, NDArray[Any]] = {k: piece.table[list(n)].to_numpy(dtype=np.float32) for k, n in groups.items()}
        data["timestamp"] = (np.arange(rows) / rate).astype(np.float32)[:, None]
        counts = (np.arange(rows), np.full(rows, number), np.arange(first, first + rows), np.zeros(rows))
        data |= {k: v.astype(np.int64)[:, None] for k, v in zip(_COUNTS, counts, strict=True)}
        tables.append(pa.table({k: _cells(v) for k, v in data.items()}))
        episodes.append(
            {"episode_index": number, "tasks": [task], "length": rows, "data/chunk_index": 0, "data/file_index": 0}
            | {"dataset_from_index": first, "dataset_to_index": first + rows}
            | {"meta/episodes/chunk_index": 0, "meta/episodes/file_index": 0}
            | {f"stats/{k}/{s}": v for k, array in data.items() for s, v in _statistics(array).items()}
        )
        first += rows
    every = {k: np.concatenate([_matrix(t[k]) for t in tables]) for k in tables[0].column_names}
    features = {k: _feature("float32", names) for k, names in groups.items()}
    features |= {"timestamp": _feature("float32"), **{k: _feature("int64") for k in _COUNTS}}
    info = {
        "codebase_version": "v3.0", "robot_type": None, "total_episodes": len(pieces), "total_frames": first,
        "total_tasks": 1, "chunks_size": 1000, "data_files_size_in_mb": 100, "video_files_size_in_mb": 200,
        "fps": rate, "splits": {"train": f"0:{len(pieces)}"},
        "data_path": "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet", "video_path": None,
        "features": features,
    }  # fmt: skip
    tasks = pd.DataFrame({"task_index": [0]}, index=pd.Index([task], name="task"))
    return {
        f"data/{_FILE}": _parquet(tables),
        f"meta/episodes/{_FILE}": _parquet([pa.Table.from_pylist(episodes)]),
        "meta/tasks.parquet": _parquet([pa.Table.from_pandas(tasks)]),
        "meta/stats.json": _json({k: _statistics(v) for k, v in every.items()}),
        "meta/info.json": _json(info),
        "map.yaml": map_text(
            {f"{key}[{i}]": n for key, names in groups.items() for i, n in enumerate(names)}, pieces[0].units
        ),
    }


def _rate(pieces: Sequence[Demonstration]) -> int:
    """Rows a second, which LeRobot counts in whole numbers."""
    period = pieces[0].period if len(pieces[0]) > 1 else np.nan
    rate = round(1 / period) if np.isfinite(period) and period > 0 else 0
    for piece in pieces:
        if rate < 1 or not is_at(piece, 1 / rate):
            raise InputError(f"{piece.name}: LeRobot has a whole number of rows a second, all alike; use --resample")
    return rate


def _cells(values: NDArray[Any]) -> pa.Array:
    """A column: numbers, or lists of a fixed size."""
    flat = pa.array(values.ravel())
    return flat if values.shape[1] == 1 else pa.FixedSizeListArray.from_arrays(flat, values.shape[1])


def _matrix(column: pa.ChunkedArray) -> NDArray[Any]:
    return np.stack([np.atleast_1d(v) for v in column.to_pylist()])


def _feature(kind: str, names: Sequence[str] = ()) -> dict[str, Any]:
    return {"dtype": kind, "shape": [max(len(names), 1)], "names": list(names) or None}


def _statistics(values: NDArray[Any]) -> dict[str, list[float]]:
    """What LeRobot normalises with."""
    found = {name: getattr(values, name)(axis=0).tolist() for name in ("min", "max", "mean", "std")}
    return {**found, "count": [len(values)]}


def _parquet(tables: Sequence[pa.Table]) -> bytes:
    """A file with a row group a table."""
    stream = io.BytesIO()
    with pq.ParquetWriter(stream, tables[0].schema) as writer:
        for table in tables:
            writer.write_table(table)
    return stream.getvalue()


def _json(content: Mapping[str, Any]) -> bytes:
    return json.dumps(content, indent=4, ensure_ascii=False).encode()
