"""Files made to break readers: whatever is in them, a reader gives a table or one line, soon, and runs none of it.

`ICHAIN_MANY=100000 pytest tests/test_hostile_files.py` tries so many of each kind; a few hundred by default. Files that
claim or unpack to much are in `test_bombs.py`.
"""

from __future__ import annotations

import io
import json
import os
import time
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from peak import taking_less_than

from ichain_drake.control.planning.goal_text import read_goal_text
from ichain_drake.control.tracking.path import read_path
from ichain_drake.demonstrations import Demonstration, read_demonstration, resample
from ichain_drake.demonstrations.parquet import parquet_bytes
from ichain_drake.demonstrations.reading import prepare
from ichain_drake.errors import InputError
from ichain_drake.graph import InteractionGraph
from ichain_drake.learning.chain.link import EstimatorSpec
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

MANY = int(os.environ.get("ICHAIN_MANY", "300"))
SLOWEST = 2.0  # [s] of this process's work; how long it waited for a busy machine says nothing
LARGEST = 2**30  # [bytes] beyond what the process had before

quick = settings(
    max_examples=MANY,
    derandomize=MANY <= 1000,
    deadline=None,
    database=None,
    suppress_health_check=list(HealthCheck),
)

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

# What CSV readers stumble over, in pieces that join to tables that are almost right.
CELLS = st.sampled_from(
    ["", "0", "1", "0.3333", "-1e3", "1e300", "1e-400", "9" * 400, "nan", "inf", "0,5", "1_0", "٣", "=1+1",
     "__import__('os')",
     '"', '"a\n', "#", "\0", "\ufeff", "true", "2026-01-02T03:04:05", "9999-99-99T99:99:99", "x" * 200]
)  # fmt: skip
NAMES = st.sampled_from(
    ["time", "time [ms]", "time [9**9**9]", "arm.x", "arm.x [mm]", "arm.grip", "kart.place [px]", "kart.h [deg]",
     "arm->kart", "command.x", "", "index", "kart.place", "kart.h", "->", ".", "[", "a [b] [c]", "timestamp"]
)  # fmt: skip
SEPARATORS = st.sampled_from([",", ";", "\t", "|", " ", ", "])


@st.composite
def tables(draw: st.DrawFn) -> bytes:
    """Text that is almost a table."""
    separator, end = draw(SEPARATORS), draw(st.sampled_from(["\n", "\r\n", "\r"]))
    width = draw(st.integers(0, 6))
    rows = [draw(st.lists(NAMES, min_size=width, max_size=width))]
    for _ in range(draw(st.integers(0, 5))):
        wide = width if draw(st.integers(0, 9)) else draw(st.integers(0, 8))
        rows.append(draw(st.lists(CELLS, min_size=wide, max_size=wide)))
    text = draw(st.sampled_from(["", "# log\n", "sep=;\n", "\n\n"])) + end.join(separator.join(r) for r in rows)
    return text.encode(draw(st.sampled_from(["utf-8", "utf-16", "utf-16-le", "utf-8-sig"])))


@st.composite
def damaged(draw: st.DrawFn, good: bytes) -> bytes:
    """A good file with bytes changed, cut out, doubled or put in."""
    data = bytearray(good)
    for _ in range(draw(st.integers(1, 8))):
        at = draw(st.integers(0, max(0, len(data) - 1)))
        what = draw(st.sampled_from(["set", "flip", "cut", "end", "put", "double"]))
        if what == "set" and data:
            data[at] = draw(st.integers(0, 255))
        elif what == "flip" and data:
            data[at] ^= 1 << draw(st.integers(0, 7))
        elif what == "cut":
            del data[at : at + draw(st.integers(1, 16))]
        elif what == "end":
            del data[at:]
        elif what == "put":
            data[at:at] = draw(st.binary(max_size=12))
        else:
            data[at:at] = data[at : at + draw(st.integers(1, 32))]
    return bytes(data)


def tried(read: Callable[[], object]) -> None:
    """Nothing but a result or one line, soon."""
    began = time.process_time()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            read()
    except InputError as error:
        assert str(error)
        assert len(str(error).splitlines()) == 1, str(error)
    assert time.process_time() - began < SLOWEST


def used(file: Path) -> None:
    """Everything that is done with a piece before it is learned from."""
    piece = read_demonstration(file)
    for part in prepare([piece], GRAPH, resampled=True):
        part.check(GRAPH)


@pytest.fixture(autouse=True)
def little_memory() -> Iterator[None]:
    with taking_less_than(LARGEST):
        yield


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("hostile")


@quick
@given(data=st.one_of(tables(), damaged(CSV), st.binary(max_size=200)))
def test_csv(place: Path, data: bytes) -> None:
    (place / "a.csv").write_bytes(data)
    tried(lambda: used(place / "a.csv"))


@quick
@given(data=st.one_of(tables(), damaged(b"x [px],y [px]\n1,2\n3,4\n"), st.binary(max_size=100)))
def test_paths(place: Path, data: bytes) -> None:
    (place / "p.csv").write_bytes(data)
    tried(lambda: read_path(place / "p.csv", ("x", "y"), "px"))


@quick
@given(data=st.sampled_from(PARQUETS).flatmap(damaged))
def test_parquet(place: Path, data: bytes) -> None:
    (place / "a.parquet").write_bytes(data)
    tried(lambda: used(place / "a.parquet"))


@quick
@given(data=damaged(NPZ))
def test_arrays(data: bytes) -> None:
    tried(lambda: unpack_arrays(data, "a.npz"))


@quick
@given(data=damaged(NPZ))
def test_recordings(place: Path, data: bytes) -> None:
    (place / "r.npz").write_bytes(data)
    tried(lambda: load_recording(place / "r.npz"))


def json_of(*names: str) -> st.SearchStrategy[object]:
    """Whatever JSON can hold, with names that a reader asks for."""
    plain = st.one_of(
        st.none(), st.booleans(), st.integers(-2, 10**20), st.floats(), st.text(max_size=5), st.sampled_from(names)
    )
    return st.recursive(
        plain,
        lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.sampled_from(names), inner, max_size=4),
        max_leaves=8,
    )


def text_of(content: object, cut: int) -> bytes:
    text = json.dumps(content)
    return text[: len(text) - cut if cut < 10 else None].encode()


CUT = st.integers(0, 40)


@quick
@given(content=json_of("format", "files", "parent", "x"), cut=CUT)
def test_manifests(content: object, cut: int) -> None:
    tried(lambda: read_manifest({"manifest.json": text_of(content, cut)}, Path("lib/a-b")))


@quick
@given(content=json_of("table", "row", "reached", "runs", "rows"), cut=CUT)
def test_reports(place: Path, content: object, cut: int) -> None:
    (place / "r.json").write_bytes(text_of(content, cut))
    tried(lambda: read_scoreboard(place / "r.json"))


@quick
@given(
    lines=st.lists(json_of("about", "id", "found"), max_size=4),
    cut=CUT,
    first=st.sampled_from([b'{"about": {}}\n', b"", b"\xff"]),
)
def test_kept_rows(place: Path, lines: list[object], cut: int, first: bytes) -> None:
    (place / "r.rows.jsonl").write_bytes(first + b"\n".join(text_of(line, cut) for line in lines))
    tried(lambda: RowFile(place / "r.rows.jsonl", {}, resume=True))


OPEN = b"""{"columns": ["arm.x", "kart.h"], "units": {"arm.x": "m"}}
[0.1, 0.2]
[0.1, 0.3]
{"first": 0, "marks": {"arm->kart": [3, 9]}, "before": {"arm->kart": false}}
[0.2, 0.3]
"""


@quick
@given(
    data=damaged(OPEN)
    | st.lists(json_of("columns", "units", "first", "marks", "before"), max_size=4).map(
        lambda lines: b"".join(text_of(line, 40) + b"\n" for line in lines)
    )
)
def test_open_pieces(place: Path, data: bytes) -> None:
    folder = place / "teaching"
    folder.mkdir(exist_ok=True)
    (folder / ".piece.open").write_bytes(data)
    tried(lambda: left_behind(folder))


YAML = b"""robot: {home: {x: .5}, linear_speed: 0.4}
noise: &n
  scale: 2.0
camera: {yaw_deg: 5}
learning: {samples: 100, links: [{interaction: hand->joystick, aims: [1, 2]}]}
"""
VALUES = st.sampled_from(
    ["1", "-1", ".nan", "1e999", "[1, 2]", "{a: 1}", "&a [*a]", "*a", "!!python/object:os.system x", "2001-01-01",
     "0x1F", "1:2:3", "? a", "!!binary AA==", "!!set {a}", "'", "\"", "|", "~", "yes", "<<", "{<<: [1]}", "text", "",
     "\t", "\0", "!!float x", "!!int ''", "!!timestamp x", "%"]
)  # fmt: skip


@quick
@given(data=damaged(YAML) | st.binary(max_size=80) | VALUES.map(lambda v: b"noise: {scale: " + v.encode() + b"}"))
def test_scenario_files(place: Path, data: bytes) -> None:
    (place / "s.yaml").write_bytes(data)
    tried(lambda: load_config(HeldControlConfig, place / "s.yaml"))


KEYS = st.sampled_from(
    ["noise.scale", "noise", "robot", "robot.home", "robot.home.x", "robot.kp", "robot.arm", "learning.links", "",
     "learning.estimator", "control.efforts", "path.speed", "joystick.pivot", "fault.kind", ".", "a.b", "description"]
)  # fmt: skip


@quick
@given(key=KEYS | st.text(max_size=12), value=VALUES | st.text(max_size=12))
def test_values_of_settings(key: str, value: str) -> None:
    tried(lambda: check_settings(load_config(HeldControlConfig, None, f"{key}={value}")))


GOAL = st.sampled_from(
    ["arm.x", "kart.place", "arm->kart", ">=", "<=", ">", "<", "and", "0.5", "-1e9", "1e999", "nan", "..", "->", "(",
     " ", "arm", ".", "==", "not"]
)  # fmt: skip


@quick
@given(text=st.lists(GOAL, max_size=8).map(" ".join) | st.text(max_size=30))
def test_goals(text: str) -> None:
    tried(lambda: read_goal_text(text, GRAPH))


@quick
@given(
    text=st.lists(
        st.sampled_from(["Ridge", "polynomial", "(", ")", "alpha", "degree", "=", "1", "-1", ",", "[", "]", "'a'",
                         "None", "9**9**9", "lambda: 1", "*", "{}"]),
        max_size=8,
    ).map("".join)
    | st.text(max_size=20)
)  # fmt: skip
def test_names_of_estimators(text: str) -> None:
    tried(lambda: EstimatorSpec.parse(text).make())


@quick
@given(unit=st.text(st.sampled_from("mskgradpx*/^0123456789 ()[]._%°e-"), max_size=20))
def test_units(unit: str) -> None:
    tried(lambda: convert(np.ones(2), unit, "m"))


@quick
@given(
    times=st.lists(st.floats(-1e12, 1e12) | st.sampled_from([0.0, 1 / 3, 0.01, 0.02, float("nan")]), max_size=12),
    scale=st.sampled_from([1e-9, 1e-3, 0.1, 1.0, 1e9]),
)
def test_resampling(times: list[float], scale: float) -> None:
    at = scale * np.array(times, dtype=float)
    table = pd.DataFrame({"time": at, "arm.x": at, "arm->kart": 0.0})
    tried(lambda: resample(Demonstration(table), GRAPH.objects))


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
