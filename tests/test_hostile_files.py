"""Files made to break readers: whatever is in them, a reader gives a table or one line, soon, and runs none of it.

`ICHAIN_MANY=100000 pytest tests/test_hostile_files.py` tries so many of each kind; a few hundred by default.
"""

from __future__ import annotations

import io
import json
import os
import time
import warnings
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from ichain_drake.control.tracking.path import read_path
from ichain_drake.demonstrations import Demonstration, read_demonstration, resample
from ichain_drake.demonstrations.importing import import_logs, parse_map
from ichain_drake.demonstrations.parquet import parquet_bytes
from ichain_drake.demonstrations.reading import prepare
from ichain_drake.errors import InputError
from ichain_drake.graph import InteractionGraph
from ichain_drake.learning.library.manifest import read_manifest
from ichain_drake.learning.library.weights import pack_arrays, unpack_arrays
from ichain_drake.state import StateSpace, Variable
from ichain_drake.units import convert
from ichain_drake.visualization import load_recording

MANY = int(os.environ.get("ICHAIN_MANY", "300"))
SLOWEST = 2.0  # [s]

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
    began = time.perf_counter()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            read()
    except InputError as error:
        assert str(error)
        assert len(str(error).splitlines()) == 1, str(error)
    assert time.perf_counter() - began < SLOWEST


def used(file: Path) -> None:
    """Everything that is done with a piece before it is learned from."""
    piece = read_demonstration(file)
    for part in prepare([piece], GRAPH, resampled=True):
        part.check(GRAPH)


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
@given(data=damaged(PARQUET))
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


JSON = st.recursive(
    st.one_of(st.none(), st.booleans(), st.integers(-2, 10**20), st.floats(), st.text(max_size=5)),
    lambda inner: (
        st.lists(inner, max_size=3) | st.dictionaries(st.sampled_from(["format", "files", "parent", "x"]), inner)
    ),
    max_leaves=8,
)


@quick
@given(content=JSON, cut=st.integers(0, 40))
def test_manifests(content: object, cut: int) -> None:
    text = json.dumps(content)
    data = text[: len(text) - cut if cut < 10 else None].encode()
    tried(lambda: read_manifest({"manifest.json": data}, Path("lib/a-b")))


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


@pytest.mark.parametrize("shape", ["(9999999999999,)", "(2, 4611686018427387904)", "(-1,)", "(1,) * 40"])
def test_arrays_that_claim_terabytes(shape: str, tmp_path: Path) -> None:
    header = f"{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}".ljust(117).encode() + b"\n"
    array = b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header + b"\0" * 64
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        archive.writestr("a.npy", array)
        archive.writestr("contents.npy", array)
    (tmp_path / "r.npz").write_bytes(stream.getvalue())
    for read in (lambda: unpack_arrays(stream.getvalue(), "a.npz"), lambda: load_recording(tmp_path / "r.npz")):
        with pytest.raises(InputError) as caught:
            read()
        if shape.startswith("(9"):
            assert "claims to be 8e+13 bytes, and" in str(caught.value)


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


# Logs of other tools; those of libraries that are missing are skipped.

LOG_MAP = parse_map({"columns": {"obs/x[0]": "arm.x", "actions[1]": "command.x"}, "rate": 3}, "map")
TOPICS = parse_map({"columns": {"/arm:x": "arm.x", "/kart:list[0]": "kart.place"}}, "map")


def hdf5_bytes() -> bytes:
    h5py = pytest.importorskip("h5py", reason="h5py is missing: pip install 'ichain_drake[logs]'")
    stream = io.BytesIO()
    with h5py.File(stream, "w") as file:
        demo = file.create_group("data/demo_0")
        demo.create_dataset("actions", data=np.arange(12.0).reshape(6, 2), compression="gzip")
        demo.create_dataset("obs/x", data=np.arange(6.0)[:, None])
    return stream.getvalue()


def mcap_bytes() -> bytes:
    writer = pytest.importorskip("mcap.writer", reason="mcap is missing: pip install 'ichain_drake[logs]'")
    stream = io.BytesIO()
    log = writer.Writer(stream, compression=writer.CompressionType.NONE)
    log.start()
    channels = [log.register_channel(t, "json", 0) for t in ("/arm", "/kart")]
    for i in range(3):
        for channel, content in zip(channels, ({"x": i / 10}, {"list": [i]}), strict=True):
            log.add_message(channel, log_time=i, publish_time=i, data=json.dumps(content).encode())
    log.finish()
    return stream.getvalue()


@quick
@given(data=st.data())
def test_hdf5(place: Path, data: st.DataObject) -> None:
    (place / "a.hdf5").write_bytes(data.draw(damaged(hdf5_bytes())))
    tried(lambda: import_logs("robomimic", place / "a.hdf5", LOG_MAP))


@quick
@given(data=st.data())
def test_mcap(place: Path, data: st.DataObject) -> None:
    (place / "a.mcap").write_bytes(data.draw(damaged(mcap_bytes())))
    tried(lambda: import_logs("mcap", place / "a.mcap", TOPICS))
