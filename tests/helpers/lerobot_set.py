"""A small LeRobot data set, as `datasets` writes it."""

import json
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq


def data_set(folder: Path, version: str = "v3.0", files: int = 2, **info: object) -> Path:
    """Two episodes of 4 rows, as `datasets` writes them; in v3 an episode may go on in the next file."""
    features = {"observation.state": {"dtype": "float32", "shape": [2], "names": {"motors": ["x", "y"]}}}
    about = {"codebase_version": version, "fps": 10, "features": features, **info}
    (folder / "meta").mkdir(parents=True)
    (folder / "meta" / "info.json").write_text(json.dumps(about))
    state = np.arange(16, dtype=np.float32).reshape(8, 2)
    table = pa.table(
        {
            "observation.state": pa.FixedSizeListArray.from_arrays(pa.array(state.ravel()), 2),
            "observation.state.more": pa.array(np.zeros(8)),
            "done": pa.array([False] * 7 + [True]),
            "timestamp": pa.array((np.tile(np.arange(4), 2) / 10).astype(np.float32)),
            "frame_index": pa.array(np.tile(np.arange(4), 2)),
            "episode_index": pa.array(np.repeat([0, 1], 4)),
        }
    )
    place = folder / "data" / "chunk-000"
    place.mkdir(parents=True)
    for i in range(files):
        name = f"file-{i:03d}" if version == "v3.0" else f"episode_{i:06d}"
        pq.write_table(table.slice(i * 8 // files, 8 // files), place / f"{name}.parquet")
    return folder
