"""Files made to break readers: whatever is in them, a reader gives a table or one line, soon, and runs none of it.

`ICHAIN_MANY=100000 pytest tests/test_hostile_files.py` tries so many of each kind. Logs of other tools are in
`demonstrations/importing/test_hostile_logs.py`, whole libraries in `learning/library/test_hostile_library.py`, files
that claim or unpack to much in `test_bombs.py`.
"""

from __future__ import annotations

import io
import json
import math
import os
import random
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
import yaml
from damage import altered, damaged, letters, table, text_of
from hostile import survives, tried

from ichain_drake.control.planning.goal_text import read_goal_text
from ichain_drake.control.tracking.path import read_path
from ichain_drake.demonstrations import Demonstration, read_demonstration, resample
from ichain_drake.demonstrations.long_logs import outline_of, read_stretches
from ichain_drake.demonstrations.parquet import parquet_bytes
from ichain_drake.demonstrations.reading import prepare
from ichain_drake.errors import InputError
from ichain_drake.graph import InteractionGraph
from ichain_drake.learning.chain.link import EstimatorSpec
from ichain_drake.learning.discovery.graph_file import read_edges, read_spaces
from ichain_drake.learning.library.manifest import read_manifest
from ichain_drake.learning.library.weights import pack_arrays, unpack_arrays
from ichain_drake.runs.open_piece import left_behind
from ichain_drake.runs.row_file import RowFile
from ichain_drake.runs.scoreboard.against import read_scoreboard
from ichain_drake.scenarios.config import load_config
from ichain_drake.scenarios.held_control_config import HeldControlConfig
from ichain_drake.settings import check_settings
from ichain_drake.state import StateSpace, Variable
from ichain_drake.units import convert
from ichain_drake.visualization import load_recording
from ichain_drake.visualization.recording import Readout, RecordedEpisode, Recording, Strip
from ichain_drake.visualization.recording_file import save_recording

GRAPH = InteractionGraph(
    {
        "arm": StateSpace("arm", (Variable("x", "m", -1, 1), Variable("grip", kind="binary"))),
        "kart": StateSpace("kart", (Variable("place", "px"), Variable("h", "rad", -np.pi, np.pi, "angle"))),
    },
    ["arm->kart"],
)
TABLE = pd.DataFrame(
    {
        "time": np.arange(6) / 3, "arm.x": 0.1, "arm.grip": 1.0, "kart.place": np.arange(6.0), "kart.h": 0.2,
        "arm->kart": [0.0, 1, 1, 1, 0, 0],
    }
)  # fmt: skip
CSV = TABLE.to_csv(index=False).encode()
PARQUET = parquet_bytes(TABLE, {"arm.x": "m"})


def stored(**how: object) -> bytes:
    """A Parquet table of many kinds of columns."""
    table = TABLE.assign(
        text=["a", "b", None, "a" * 30, "", "c"], lists=[[1.0], [], [2.0, 3.0], [], [], [4.0]], when=pd.Timestamp(0),
        many=range(6), flags=[True, False, None, True, True, False],
    )  # fmt: skip
    stream = io.BytesIO()
    pq.write_table(pa.Table.from_pandas(table), stream, **how)
    return stream.getvalue()


PARQUETS = (
    PARQUET, stored(), stored(compression="none", use_dictionary=False), stored(compression="gzip"),
    stored(compression="zstd", data_page_version="2.0", row_group_size=2), stored(compression="lz4"),
    stored(column_encoding={"many": "DELTA_BINARY_PACKED", "arm.x": "BYTE_STREAM_SPLIT"}, use_dictionary=False),
)  # fmt: skip
NPZ = pack_arrays({"a": np.arange(6.0).reshape(2, 3), "name": np.array("x")})


@cache
def recording_bytes() -> bytes:
    """A recording of two episodes."""
    times = np.arange(4) / 30
    episodes = tuple(
        RecordedEpisode(
            name=name, times=times,
            states={o: np.zeros((4, len(s))) for o, s in GRAPH.objects.items()},
            readouts={"speed": Readout(times, "m/s"), "mode": Readout(["a", "b", "a", "b"], "")},
            lines={"path": np.zeros((3, 2))}, active={"arm->kart": np.ones(4, bool)},
            strips={"x": Strip(times, "m", 0.0, 1.0)},
        )
        for name in ("first", "second")
    )  # fmt: skip
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "r.npz"
        save_recording(Recording("kart", "ideal", 0, dict(GRAPH.objects), episodes, GRAPH.interactions), file)
        return file.read_bytes()


@cache
def recording_arrays() -> dict[str, np.ndarray]:
    return dict(np.load(io.BytesIO(recording_bytes())))


def used(file: Path) -> None:
    """Everything that is done with a piece before it is learned from."""
    piece = read_demonstration(file)
    for part in prepare([piece], GRAPH, resampled=True):
        part.check(GRAPH)


def csv(rng: random.Random, place: Path) -> None:
    data = rng.choice([table, lambda r: damaged(r, CSV), lambda r: r.randbytes(r.randint(0, 200))])(rng)
    (place / "a.csv").write_bytes(data)
    tried(lambda: used(place / "a.csv"))


def paths(rng: random.Random, place: Path) -> None:
    good = b"x [px],y [px]\n1,2\n3,4\n"
    data = rng.choice([table, lambda r: damaged(r, good), lambda r: r.randbytes(r.randint(0, 100))])(rng)
    (place / "p.csv").write_bytes(data)
    tried(lambda: read_path(place / "p.csv", ("x", "y"), "px"))


def parquet(rng: random.Random, place: Path) -> None:
    (place / "a.parquet").write_bytes(damaged(rng, rng.choice(PARQUETS)))
    tried(lambda: used(place / "a.parquet"))


def long_logs(rng: random.Random, place: Path) -> None:
    """Read by parts, as logs beyond memory are."""
    (place / "a.parquet").write_bytes(damaged(rng, rng.choice(PARQUETS)))

    def read() -> None:
        rows = outline_of(place / "a.parquet", GRAPH, 2).rows
        ranges = [(0, 1), (2, rows)] if rows > 2 else [(0, rows)]  # noqa: PLR2004
        for part in prepare(read_stretches(place / "a.parquet", ranges), GRAPH, resampled=True):
            part.check(GRAPH)

    tried(read)


def arrays(rng: random.Random, place: Path) -> None:
    data = damaged(rng, NPZ)
    tried(lambda: unpack_arrays(data, "a.npz"))


def recordings(rng: random.Random, place: Path) -> None:
    (place / "r.npz").write_bytes(damaged(rng, recording_bytes()))
    tried(lambda: load_recording(place / "r.npz"))


def contents(rng: random.Random, place: Path) -> None:
    """Tables of contents of recordings, in a file that is whole."""
    kept = recording_arrays()
    about = json.loads(str(kept["contents"]))
    altered(rng, about, "name", "kind", "hand", "angle", "car")
    stream = io.BytesIO()
    np.savez(stream, **(kept | {"contents": np.array(json.dumps(about))}))
    (place / "r.npz").write_bytes(stream.getvalue())
    tried(lambda: load_recording(place / "r.npz"))


def manifests(rng: random.Random, place: Path) -> None:
    data = text_of(rng, "format", "files", "parent", "x")
    tried(lambda: read_manifest({"manifest.json": data}, Path("lib/a-b")))


def reports(rng: random.Random, place: Path) -> None:
    (place / "r.json").write_bytes(text_of(rng, "table", "row", "reached", "runs", "rows"))
    tried(lambda: read_scoreboard(place / "r.json"))


def kept_rows(rng: random.Random, place: Path) -> None:
    lines = [text_of(rng, "about", "id", "found") for _ in range(rng.randint(0, 4))]
    (place / "r.rows.jsonl").write_bytes(rng.choice([b'{"about": {}}\n', b"", b"\xff"]) + b"\n".join(lines))
    tried(lambda: RowFile(place / "r.rows.jsonl", {}, resume=True))


OPEN = b"""{"columns": ["arm.x", "kart.h"], "units": {"arm.x": "m"}}
[0.1, 0.2]
[0.1, 0.3]
{"first": 0, "marks": {"arm->kart": [3, 9]}, "before": {"arm->kart": false}}
[0.2, 0.3]
"""


def open_pieces(rng: random.Random, place: Path) -> None:
    names = ("columns", "units", "first", "marks", "before")
    lines = [text_of(rng, *names) + b"\n" for _ in range(rng.randint(0, 4))]
    (place / ".piece.open").write_bytes(damaged(rng, OPEN) if rng.random() < 0.5 else b"".join(lines))
    tried(lambda: left_behind(place))


YAML = b"""robot: {home: {x: .5}, linear_speed: 0.4}
noise: &n
  scale: 2.0
camera: {yaw_deg: 5}
learning: {samples: 100, links: [{interaction: hand->joystick, aims: [1, 2]}]}
"""
VALUES = (
    "1", "-1", ".nan", "1e999", "[1, 2]", "{a: 1}", "&a [*a]", "*a", "!!python/object:os.system x", "2001-01-01",
    "0x1F", "1:2:3", "? a", "!!binary AA==", "!!set {a}", "'", '"', "|", "~", "yes", "<<", "{<<: [1]}", "text", "",
    "\t", "\0", "!!float x", "!!int ''", "!!timestamp x", "%",
)  # fmt: skip
KEYS = (
    "noise.scale", "noise", "robot", "robot.home", "robot.home.x", "robot.kp", "robot.arm", "learning.links", "",
    "learning.estimator", "control.efforts", "path.speed", "joystick.pivot", "fault.kind", ".", "a.b", "description",
)  # fmt: skip


def scenario_files(rng: random.Random, place: Path) -> None:
    value = b"noise: {scale: " + rng.choice(VALUES).encode() + b"}"
    data = rng.choice([damaged(rng, YAML), damaged(rng, YAML), rng.randbytes(rng.randint(0, 80)), value])
    (place / "s.yaml").write_bytes(data)
    tried(lambda: load_config(HeldControlConfig, place / "s.yaml"))


GRAPH_FILE = b"""robot: arm
edges:
  arm->kart: {why: "better by 3"}
objects:
  arm: [{name: x, unit: m, lower: -1, upper: 1, kind: real, role: {kind: position, axis: x}}]
  kart: [{name: h, unit: rad, kind: angle}]
"""


def graph_files(rng: random.Random, place: Path) -> None:
    """Graphs that `ichain discover` wrote and a person mended."""
    data = damaged(rng, GRAPH_FILE)
    if rng.random() < 0.5:
        tree = yaml.safe_load(GRAPH_FILE)
        altered(rng, tree, "x", "angle", "arm", "position", "arm->kart")
        data = yaml.safe_dump(tree).encode()
    (place / "g.yaml").write_bytes(data)
    tried(lambda: read_spaces(place / "g.yaml"))
    tried(lambda: read_edges(place / "g.yaml", GRAPH))


def settings(rng: random.Random, place: Path) -> None:
    key = rng.choice(KEYS) if rng.random() < 0.8 else letters(rng, 12)
    value = rng.choice(VALUES) if rng.random() < 0.7 else letters(rng, 12)
    tried(lambda: check_settings(load_config(HeldControlConfig, None, f"{key}={value}")))


GOAL = (
    "arm.x", "kart.place", "arm->kart", ">=", "<=", ">", "<", "and", "0.5", "-1e9", "1e999", "nan", "..", "->", "(",
    " ", "arm", ".", "==", "not",
)  # fmt: skip


def goals(rng: random.Random, place: Path) -> None:
    text = " ".join(rng.choices(GOAL, k=rng.randint(0, 8))) if rng.random() < 0.7 else letters(rng, 30)
    tried(lambda: read_goal_text(text, GRAPH))


ESTIMATOR = (
    "Ridge", "polynomial", "(", ")", "alpha", "degree", "=", "1", "-1", ",", "[", "]", "'a'", "None", "9**9**9",
    "lambda: 1", "*", "{}",
)  # fmt: skip


def estimators(rng: random.Random, place: Path) -> None:
    text = "".join(rng.choices(ESTIMATOR, k=rng.randint(0, 8))) if rng.random() < 0.7 else letters(rng, 20)
    tried(lambda: EstimatorSpec.parse(text).make())


def units(rng: random.Random, place: Path) -> None:
    unit = "".join(rng.choices("mskgradpx*/^0123456789 ()[]._%\u00b0e-", k=rng.randint(0, 20)))
    tried(lambda: convert(np.ones(2), unit, "m"))


def resampling(rng: random.Random, place: Path) -> None:
    times = [
        rng.choice([0.0, 1 / 3, 0.01, 0.02, math.nan, rng.uniform(-1e12, 1e12)]) for _ in range(rng.randint(0, 12))
    ]
    at = rng.choice([1e-9, 1e-3, 0.1, 1.0, 1e9]) * np.array(times, dtype=float)
    frame = pd.DataFrame({"time": at, "arm.x": at, "arm->kart": 0.0})
    tried(lambda: resample(Demonstration(frame), GRAPH.objects))


READERS: tuple[Callable[[random.Random, Path], None], ...] = (
    csv, paths, parquet, long_logs, arrays, recordings, contents, manifests, reports, kept_rows, open_pieces,
    scenario_files, settings, goals, graph_files, estimators, units, resampling,
)  # fmt: skip


@pytest.mark.parametrize("reader", READERS, ids=lambda r: r.__name__)
def test_nothing_but_a_result_or_one_line(reader: Callable[[random.Random, Path], None], tmp_path: Path) -> None:
    survives(reader, tmp_path)
    assert {file.name for file in tmp_path.iterdir()} <= OWN


OWN = {"a.csv", "p.csv", "a.parquet", "r.npz", "r.json", "r.rows.jsonl", ".piece.open", "s.yaml", "g.yaml"}
"""All that readers may leave: the files that they read."""


class Bomb:
    """Would leave a file where it is unpickled."""

    def __init__(self, file: Path) -> None:
        self.file = file

    def __reduce__(self) -> tuple[Callable[..., object], tuple[str, ...]]:
        return (os.system, (f"touch {self.file}",))


def test_nothing_in_a_file_is_run(tmp_path: Path) -> None:
    bomb = np.array([Bomb(tmp_path / "ran")], dtype=object)
    np.savez(tmp_path / "r.npz", contents=bomb, a=bomb)
    for read in (
        lambda: load_recording(tmp_path / "r.npz"),
        lambda: unpack_arrays((tmp_path / "r.npz").read_bytes(), "a"),
    ):
        with pytest.raises(InputError):
            read()
    import pickle

    for name in ("a.csv", "a.parquet", "a.csv.gz"):
        (tmp_path / name).write_bytes(pickle.dumps(Bomb(tmp_path / "ran")))
        with pytest.raises(InputError):
            read_demonstration(tmp_path / name)
    assert not (tmp_path / "ran").exists()
