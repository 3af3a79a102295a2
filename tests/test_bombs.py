"""Files that are small and claim, or unpack to, much: they are refused before they take memory or time."""

from __future__ import annotations

import gzip
import io
import time
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from peak import taking_less_than

from ichain_drake.demonstrations import read_demonstration
from ichain_drake.demonstrations.parquet_claims import read_claims
from ichain_drake.demonstrations.thrift import DamagedError
from ichain_drake.errors import InputError
from ichain_drake.learning.library.files import read_files
from ichain_drake.learning.library.weights import unpack_arrays
from ichain_drake.scenarios.yaml_text import read_yaml
from ichain_drake.visualization import load_recording

SOON = 2.0  # [s] of work
LARGE = 2**30  # [bytes]


def refused(read: Callable[[], object], match: str) -> None:
    """One line, soon, and without much memory."""
    began = time.process_time()
    with taking_less_than(LARGE), pytest.raises(InputError, match=match or None) as caught:
        read()
    assert time.process_time() - began < SOON
    assert len(str(caught.value).splitlines()) == 1


def parquet(columns: dict[str, pa.Array], **how: object) -> bytes:
    stream = io.BytesIO()
    pq.write_table(pa.table(columns), stream, **how)
    return stream.getvalue()


ZEROS = pa.array(np.zeros(10**6))
# How it is made and what is said; each takes much more where it is simply read.
CLAIMS: dict[str, tuple[Callable[[], bytes], str]] = {
    "values": (lambda: parquet({f"a{i}": ZEROS for i in range(11)}), "claims 11000000 values, and 10000000 are read"),
    "pages": (
        lambda: parquet({"a": pa.array([b"\0" * 2**23], pa.binary())}, compression="gzip", use_dictionary=False),
        "it unpacks to more than 1 MB",
    ),
    "many texts": (lambda: parquet({f"a{i}": pa.array(["x"] * 10**6) for i in range(3)}), "more than 2000000 texts"),
    "texts on texts": (
        lambda: parquet({"a": pa.array(["xy"])}, use_dictionary=False, column_encoding={"a": "DELTA_BYTE_ARRAY"}),
        "DELTA_BYTE_ARRAY",
    ),
}  # fmt: skip


@pytest.mark.parametrize("what", CLAIMS)
def test_parquet_that_claims_much(what: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    make, match = CLAIMS[what]
    if what == "pages":
        monkeypatch.setattr("ichain_drake.demonstrations.parquet_claims._MOST_BYTES", 10**6)
    (tmp_path / "a.parquet").write_bytes(make())
    refused(lambda: read_demonstration(tmp_path / "a.parquet"), match)


def test_lists_and_long_texts_in_many_rows_take_no_memory(tmp_path: Path) -> None:
    """A text in a dictionary, and a list of zeros, cost a few bytes a row on disk; read, they are not written out."""
    rows = 300
    lists = pa.FixedSizeListArray.from_arrays(pa.array(np.zeros(rows * 10**4)), 10**4)
    text = pa.DictionaryArray.from_arrays(pa.array(np.zeros(rows, np.int32)), pa.array(["x" * 10**6]))
    data = parquet({"time": pa.array(np.arange(rows) / 3), "note": text, "pixels": lists})
    assert len(data) < 10**6
    (tmp_path / "a.parquet").write_bytes(data)
    with taking_less_than(10**8):
        piece = read_demonstration(tmp_path / "a.parquet")
    assert list(piece.table) == ["time", "note", "pixels"]
    assert piece.table["pixels"].isna().all()
    assert piece.table["note"].iloc[-1] == "x" * 10**6


@pytest.mark.parametrize("size", [2**20, 2**31 - 1])
def test_a_page_that_claims_more_than_is_there(size: int) -> None:
    """The head of the first page: 15 00 (data) 15 <unpacked> 15 <packed>, numbers as zigzag varints."""
    data = bytearray(parquet({"a": pa.array([1.0, 2.0])}, use_dictionary=False, compression="none"))
    assert data[4:7] == b"\x15\x00\x15"

    def varint(value: int) -> bytes:
        out = bytearray()
        while value > 0x7F:
            out.append(value & 0x7F | 0x80)
            value >>= 7
        return bytes([*out, value])

    changed = bytes(data[:7]) + varint(2 * size) + bytes(data[8:])
    with pytest.raises((DamagedError, ValueError)):
        read_claims(changed)  # nothing behind it is where the file says any more
    with pytest.raises(DamagedError, match="a page claims more than is there"):
        read_claims(bytes(data[:9]) + b"\x7e" + bytes(data[10:]))


def test_every_cut_of_a_description_is_refused() -> None:
    data = parquet({"a": pa.array([1.0, 2.0]), "b": pa.array([[1], [2]])})
    assert [column.leaf for column in read_claims(data).columns] == [0, None]
    size = int.from_bytes(data[-8:-4], "little")
    for kept in range(size):
        cut = data[: len(data) - 8 - size + kept] + kept.to_bytes(4, "little") + b"PAR1"
        with pytest.raises(DamagedError):
            read_claims(cut)


@pytest.mark.parametrize(
    "text",
    [b"a,b\n" + b"\n" * 10**7, b"#\n" * 10**7, b"a," * 10**7, b"\0" * 2**26, b'a\n"' + b"x" * 10**7],
    ids=["blank", "comments", "columns", "zeros", "quote"],
)
def test_gzip_that_unfolds(text: bytes, tmp_path: Path) -> None:
    (tmp_path / "a.csv.gz").write_bytes(gzip.compress(text, 1))
    refused(lambda: read_demonstration(tmp_path / "a.csv.gz"), r"a\.csv\.gz: can't read the demonstration: ")


def npz(**members: bytes) -> bytes:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in members.items():
            archive.writestr(f"{name}.npy", data)
    return stream.getvalue()


def array(kind: str, shape: str, body: bytes = b"\0" * 64) -> bytes:
    header = f"{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}".ljust(117).encode() + b"\n"
    return b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header + body


ARRAYS = {
    "terabytes": (array("<f8", "(9999999999999,)"), "claims to be 8e[+]13 bytes, and"),
    "overflow": (array("<f8", "(2, 4611686018427387904)"), "claims to be"),
    "negative": (array("<f8", "(-1,)"), ""),
    "dimensions": (array("<f8", "(1,) * 40"), ""),
    "unfolds": (array("<f8", "(37748736,)", b"\0" * (8 * 37748736)), "it unpacks to 302 MB, and 268 are read"),
    "one text": (array("<U9999999", "()", b"\0" * 39999996), "one item of contents claims to be 40 MB"),
    "many texts": (array("<U1", "(4000000,)", b"\0" * 16000000), "claims 4e[+]06 texts"),
}


@pytest.mark.parametrize("what", ARRAYS)
def test_arrays_that_claim_or_unfold(what: str, tmp_path: Path) -> None:
    member, match = ARRAYS[what]
    (tmp_path / "r.npz").write_bytes(npz(contents=member))
    refused(lambda: load_recording(tmp_path / "r.npz"), match)
    refused(lambda: unpack_arrays((tmp_path / "r.npz").read_bytes(), "a.npz"), "")
    stored = io.BytesIO()
    with zipfile.ZipFile(stored, "w") as archive:
        archive.writestr("a.npy", member[: 10**6])
    refused(lambda: unpack_arrays(stored.getvalue(), "a.npz"), "")


MERGED = "a0: &a0 {k: 1}\n" + "".join(f"a{i}: &a{i} {{<<: [{', '.join([f'*a{i - 1}'] * 10)}]}}\n" for i in range(1, 10))


@pytest.mark.parametrize(
    "text",
    ["- a\n" * 10**6, "[" * 50000, "- 1\n" * 25000, MERGED, "x: " + "9" * 90000],
    ids=["long", "deep", "wide", "merged", "number"],
)
def test_yaml_that_unfolds(text: str) -> None:
    refused(lambda: read_yaml(text, "a.yaml"), r"a\.yaml: ")


def test_a_manifest_as_large_as_a_disk_is_not_read(tmp_path: Path) -> None:
    with (tmp_path / "manifest.json").open("wb") as stream:
        stream.truncate(10**10)
    refused(lambda: read_files(tmp_path), "10000 MB, and 8 are read at most")
