"""A recording for rerun, read back by rerun's own reader."""

from pathlib import Path
from typing import Any

import numpy as np


def read_rrd(file: Path) -> dict[tuple[str, str], tuple[np.ndarray | None, list[Any]]]:
    """By entity and component: times [s], None for what holds always, and the values of each row."""
    from rerun.chunk import RrdReader  # noqa: PLC0415

    rows: dict[tuple[str, str], list[tuple[float | None, Any]]] = {}
    for chunk in RrdReader(str(file)).stream():
        batch = chunk.to_record_batch()
        moments = [None] if chunk.is_static else (batch.column("time").cast("int64").to_numpy() / 1e9).tolist()
        for name in batch.schema.names:
            if ":" in name:
                key = (chunk.entity_path.replace("\\", ""), name)
                rows.setdefault(key, []).extend(zip(moments, batch.column(name).to_pylist(), strict=True))
    found: dict[tuple[str, str], tuple[np.ndarray | None, list[Any]]] = {}
    for key, values in rows.items():
        if values[0][0] is None:
            assert len(values) == 1, key
            found[key] = None, [values[0][1]]
        else:
            values.sort(key=lambda row: row[0])  # chunks come in any order
            found[key] = np.array([t for t, _ in values]), [v for _, v in values]
    return found
