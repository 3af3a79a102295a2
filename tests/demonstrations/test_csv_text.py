"""CSV as people have it: every dialect gives the same table, and what is none is one line."""

import gzip
from pathlib import Path

import pytest

from ichain_drake.demonstrations.csv_text import read_csv
from ichain_drake.errors import InputError

PLAIN = "time,kart.place [px]\n0,1.5\n0.5,-2e-1\n"
DIALECTS = {
    "plain": PLAIN.encode(),
    "semicolons, decimal commas": b"time;kart.place [px]\n0;1,5\n0,5;-2e-1\n",
    "semicolons, decimal points": b"time;kart.place [px]\n0;1.5\n0.5;-.2\n",
    "tabs": PLAIN.replace(",", "\t").encode(),
    "bars": PLAIN.replace(",", " | ").encode(),
    "spaces around commas": b"time , kart.place [px]\n 0 , 1.5\n0.5 , -0.2 \n",
    "comments before the header": b"# a log\n% of a day\n\n// by me\n" + PLAIN.encode(),
    "a header that is a comment": b"# time,kart.place [px]\n0,1.5\n0.5,-.2\n",
    "sep= of spreadsheets": b"sep=;\ntime;kart.place [px]\n0;1,5\n0,5;-0,2\n",
    "byte order mark": b"\xef\xbb\xbf" + PLAIN.encode(),
    "UTF-16": PLAIN.encode("utf-16"),
    "UTF-16 without a mark": PLAIN.encode("utf-16-be"),
    "lines of other systems": PLAIN.replace("\n", "\r\n").encode(),
    "lines of old systems": PLAIN.replace("\n", "\r").encode(),
    "quotes": b'"time","kart.place [px]"\n"0","1.5"\n"0.5","-0.2"\n',
    "a separator at each end": b"time,kart.place [px],\n0,1.5,\n0.5,-0.2,\n",
    "empty lines at the end": PLAIN.encode() + b"\n\n",
    "gzip": gzip.compress(PLAIN.encode()),
}


@pytest.mark.parametrize("name", DIALECTS)
def test_every_dialect_gives_the_same_table(name: str, tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_bytes(DIALECTS[name])
    table = read_csv(tmp_path / "a.csv", "the log", "time").table
    assert list(table.columns) == ["time", "kart.place [px]"]
    assert table.to_numpy().tolist() == [[0.0, 1.5], [0.5, -0.2]]


def test_one_letter_is_no_utf_16(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_bytes(b"x")
    assert list(read_csv(tmp_path / "a.csv", "the log", "time").table.columns) == ["x"]


def test_lines_are_those_of_the_file(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_bytes(b"# one\n# two\ntime,x\n0,1\n")
    assert read_csv(tmp_path / "a.csv", "the log", "time").first_line == 4


REFUSED = {
    "nothing": (b"", "it is empty; a first line names the columns: time"),
    "comments alone": (b"# x\n", "it is empty"),
    "no header": (b"0,1\n1,2\n", "its first line is '0,1'; a header is needed: time"),
    "decimal commas": (b"x,y\n100,5,300,5\n", "line 2 has 4 fields, the header 2 .*decimal commas.*semicolons"),
    "long line": (b"x;y\n1;2\n1;2;3\n", "line 3 has 3 fields, the header 2 .'x;y', separated by semicolons"),
    "gap of lines": (b"x,y\n1,2\n\n3,4\n", "line 3 is empty"),
    "Latin letters": (b"x,h [\xb0]\n1,2\n", "line 1 holds the byte 0xb0, which is not utf-8; save it as UTF-8"),
    "open quote": (b'x,"y\n1,2\n', "can't read the log"),
    "quoted line end": (b'x,"y\nz"\n1,2\n', "can't read the log"),
    "zip": (b"PK\x03\x04rest", "it is a zip archive .or a spreadsheet., not text"),
    "xz": (b"\xfd7zXZ\x00", "it is an xz archive"),
    "zstd": (b"\x28\xb5\x2f\xfdx", "it is a zstd archive"),
    "Parquet": (b"PAR1xxxx", "it is Parquet"),
    "broken gzip": (gzip.compress(PLAIN.encode())[:-9], "packed by gzip and damaged"),
    "zeros": (b"x,y\n1,\0\n" + b"1,2\n" * 99, "holds zero bytes"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_no_table_is_one_line(name: str, tmp_path: Path) -> None:
    content, message = REFUSED[name]
    (tmp_path / "a.csv").write_bytes(content)
    with pytest.raises(InputError, match=message) as caught:
        read_csv(tmp_path / "a.csv", "the log", "time")
    assert str(caught.value).startswith(f"{tmp_path / 'a.csv'}: can't read the log: ")
    assert "\n" not in str(caught.value)


def test_gzip_that_unfolds_to_more_than_is_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("ichain_drake.demonstrations.csv_text._MOST_BYTES", 1000)
    (tmp_path / "a.csv.gz").write_bytes(gzip.compress(b"x\n" + b"1\n" * 10000))
    with pytest.raises(InputError, match="unpacked it is over"):
        read_csv(tmp_path / "a.csv.gz", "the log", "time")


def test_numbers_that_only_python_would_read_are_none(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("x,y,z,f\n1_000,nan,inf,True\n")
    row = read_csv(tmp_path / "a.csv", "the log", "x").table.iloc[0].to_list()
    assert row[0] == "1_000"
    assert row[1] != row[1]
    assert row[2:] == [float("inf"), 1.0]
