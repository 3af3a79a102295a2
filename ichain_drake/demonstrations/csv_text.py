"""Tables as text: encoding, comments, separator and decimal mark are found out, and said where they can't be."""

from __future__ import annotations

import codecs
import csv
import gzip
import io
import re
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from ichain_drake.errors import InputError
from ichain_drake.files import MOST_BYTES, printable, read_whole

ENDINGS = (".csv", ".csv.gz")

_SEPARATORS = {",": "comma", ";": "semicolon", "\t": "tab", "|": "bar"}
_COMMENT = re.compile(r"\s*(#|%|//)")
_NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?")
_DECIMAL_COMMA = re.compile(r"[-+]?(\d+,\d*|,\d+)([eE][-+]?\d+)?")
_WORDS = {"true": 1.0, "false": 0.0, "": np.nan, "nan": np.nan, "na": np.nan, "null": np.nan, "none": np.nan}
_INFINITE = {"inf", "+inf", "-inf", "infinity", "+infinity", "-infinity"}
_PACKED = {
    b"PK\x03\x04": "a zip archive (or a spreadsheet)", b"\xfd7zXZ": "an xz archive",
    b"\x28\xb5\x2f\xfd": "a zstd archive", b"BZh": "a bzip2 archive",
    b"PAR1": "Parquet", b"\x89HDF": "HDF5", b"\x7fELF": "a program",
}  # fmt: skip
_BOMS = {codecs.BOM_UTF8: "utf-8-sig", codecs.BOM_UTF16_LE: "utf-16", codecs.BOM_UTF16_BE: "utf-16"}


@dataclass(frozen=True)
class TextTable:
    """What a file of text holds.

    Attributes:
        table: columns by the header's names, as written (units included, doubled names kept); numbers, and text where
            something is no number.
        first_line: line of the file in which the first row is.
    """

    table: pd.DataFrame
    first_line: int


def read_csv(file: Path, what: str, columns: str) -> TextTable:
    """Read a table of numbers in whatever dialect of CSV it is.

    Comma, semicolon, tab or bar between columns; decimal comma with the others; UTF-8 or UTF-16, with or without a byte
    order mark; comment lines before the header; packed by gzip.

    Args:
        file: which.
        what: it should be, for errors: `the demonstration`.
        columns: what its columns should be, for errors: `time, object.variable`.

    Raises:
        InputError: in one line, what was found and what was expected.
    """
    text = _text(_unpacked(read_whole(file, what), file, what), file, what)
    lines = re.split(r"\r\n|\r|\n", text)  # not `splitlines`, which knows more line ends than editors count
    first, header = _header(lines)
    if not header:
        raise InputError(f"{file}: can't read {what}: it is empty; a first line names the columns: {columns}")
    separator = _separator(header)
    names = [name.strip() for name in _fields([header], separator, file, what)[0]]
    rows = _fields(lines[first:], separator, file, what)
    if names and not names[-1] and all(len(r) == len(names) and not r[-1].strip() for r in rows if r):
        names, rows = names[:-1], [r[:-1] for r in rows]  # a separator at the end of every line
    if all(_NUMBER.fullmatch(n) or _DECIMAL_COMMA.fullmatch(n) for n in names):
        raise InputError(
            f"{file}: can't read {what}: its first line is {_short(header)}; a header is needed: {columns}"
        )
    cells = []
    for number, row in enumerate(rows):
        if row and len(row) != len(names):
            hint = "" if separator != "," else ("; decimal commas? Separate the columns by semicolons" if _commas(row)
                                                else "")  # fmt: skip
            raise InputError(
                f"{file}: can't read {what}: line {first + number + 1} has {len(row)} fields, the header {len(names)} "
                f"({_short(header)}, separated by {_SEPARATORS[separator]}s){hint}"
            )
        cells.append(row)
    while cells and not cells[-1]:
        cells.pop()
    blank = next((i for i, row in enumerate(cells) if not row), None)
    if blank is not None:
        raise InputError(f"{file}: can't read {what}: line {first + blank + 1} is empty; remove it, or split the piece")
    decimal = "," if separator != "," else "."
    data = {i: _numbers([row[i].strip() for row in cells], decimal) for i in range(len(names))}
    table = pd.DataFrame(data, index=pd.RangeIndex(len(cells)))
    table.columns = pd.Index([printable(name) for name in names])
    return TextTable(table, first + 1)


def _unpacked(data: bytes, file: Path, what: str) -> bytes:
    if data[:2] == b"\x1f\x8b":
        try:
            with gzip.open(io.BytesIO(data)) as stream:
                data = stream.read(MOST_BYTES + 1)
        except (OSError, EOFError, zlib.error) as error:
            raise InputError(f"{file}: can't read {what}: it is packed by gzip and damaged ({error})") from None
        if len(data) > MOST_BYTES:
            raise InputError(f"{file}: can't read {what}: unpacked it is over {MOST_BYTES / 1e6:.0f} MB; split it")
    for magic, kind in _PACKED.items():
        if data.startswith(magic):
            raise InputError(f"{file}: can't read {what}: it is {kind}, not text; {' or '.join(ENDINGS)} is expected")
    return data


def _text(data: bytes, file: Path, what: str) -> str:
    encoding = next((name for mark, name in _BOMS.items() if data.startswith(mark)), "")
    if not encoding:  # UTF-16 of plain letters has a zero in every other place
        zeros = data[:200].count(0)
        encoding = "utf-8" if 2 * zeros < len(data[:200]) - 1 else "utf-16-be" if data[:1] == b"\0" else "utf-16-le"
    try:
        text = data.decode(encoding)
    except UnicodeDecodeError as error:
        line = data[: error.start].count(b"\n") + 1
        raise InputError(
            f"{file}: can't read {what}: line {line} holds the byte 0x{data[error.start]:02x}, which is not "
            f"{encoding.removesuffix('-sig')}; save it as UTF-8"
        ) from None
    if "\0" in text:
        raise InputError(f"{file}: can't read {what}: it holds zero bytes, so it is no text; save it as UTF-8")
    return text


def _header(lines: Sequence[str]) -> tuple[int, str]:
    """Number of the line behind the header, from 0, and the header."""
    comment = ""
    for number, line in enumerate(lines):
        if not line.strip() or line.lower().startswith("sep="):
            continue
        if not _COMMENT.match(line):
            # A header that is a comment itself, as numpy writes it.
            row, above = re.split(r"[,;\t|]", line), re.split(r"[,;\t|]", comment)
            if len(row) == len(above) > 1 and all(_NUMBER.fullmatch(c.strip()) for c in row):
                return number, comment
            return number + 1, line
        comment = _COMMENT.sub("", line, count=1).strip()
    return len(lines), ""


def _separator(header: str) -> str:
    """What separates the header's names; a comma where there is one name."""
    plain = re.sub(r'"[^"]*"|\[[^\]]*\]', "", header)  # not inside quotes, nor inside a unit
    return max(_SEPARATORS, key=plain.count)


def _fields(lines: Sequence[str], separator: str, file: Path, what: str) -> list[list[str]]:
    reader = csv.reader(lines, delimiter=separator, skipinitialspace=True, strict=True)
    try:
        rows = list(reader)
    except csv.Error as error:
        raise InputError(f"{file}: can't read {what}: line {reader.line_num}: {error}") from None
    if reader.line_num != len(rows):
        raise InputError(f"{file}: can't read {what}: a quoted text goes over several lines; quote no line ends")
    return [row if any(cell.strip() for cell in row) or len(row) > 1 else [] for row in rows]


def _numbers(cells: list[str], decimal: str) -> np.ndarray:
    """A column as numbers, to the last bit; as what was written where something is no number."""
    out = []
    for cell in cells:
        if _NUMBER.fullmatch(cell):
            out.append(float(cell))
        elif decimal == "," and _DECIMAL_COMMA.fullmatch(cell):
            out.append(float(cell.replace(",", ".")))
        elif cell.lower() in _WORDS:
            out.append(_WORDS[cell.lower()])
        elif cell.lower() in _INFINITE:
            out.append(float(cell))
        else:
            return np.array(cells, dtype=object)
    return np.array(out, dtype=float)


def _commas(row: Sequence[str]) -> bool:
    return len(row) % 2 == 0 and all(re.fullmatch(r"\s*[-+]?\d+\s*", cell) for cell in row)


def _short(text: str) -> str:
    """A line as it stands in an error: in quotes, at most 60 characters."""
    line = " ".join(text.split())
    return repr(line if len(line) <= 60 else line[:57] + "...")
