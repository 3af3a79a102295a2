"""Tables as text: encoding, comments, separator and decimal mark are found out, and said where they can't be."""

from __future__ import annotations

import codecs
import csv
import gzip
import io
import itertools
import re
import zlib
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from ichain_drake.errors import InputError
from ichain_drake.files import MOST_CELLS, printable, read_whole

ENDINGS = (".csv", ".csv.gz")

_MOST_BYTES = 2**27
"""Of text, unpacked [bytes]: with one rare character in it, it takes four times as much for a moment."""
_MOST_COLUMNS = 10**4
_MOST_BARE = 10**4
"""Lines without a row: before the header, and behind the last row."""
_BLOCK = 2**12
"""Rows that are text at a time; as numbers they take a tenth of the memory."""

_SEPARATORS = {",": "comma", ";": "semicolon", "\t": "tab", "|": "bar"}
_COMMENT = re.compile(r"\s*(#|%|//)")
_NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?")
_PLAIN = re.compile(r"[-+.0-9eE]*")  # of these characters Python's numbers are those of `_NUMBER`
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
    data = _unpacked(read_whole(file, what, _MOST_BYTES), file, what)
    # One line after the other: all of them together take ten times the memory of their bytes.
    with io.TextIOWrapper(io.BytesIO(data), _encoding(data, file, what), newline=None) as stream:
        lines = (line.removesuffix("\n") for line in stream)  # not `splitlines`, which knows ends that editors don't
        first, header, ahead = _header(lines, file, what)
        if not header:
            raise InputError(f"{file}: can't read {what}: it is empty; a first line names the columns: {columns}")
        separator = _separator(header)
        if header.count(separator) > _MOST_COLUMNS:
            raise InputError(f"{file}: can't read {what}: it has more than {_MOST_COLUMNS} columns")
        names = [name.strip() for name in next(_rows([header], separator, file, what, 1))]
        if all(_NUMBER.fullmatch(n) or _DECIMAL_COMMA.fullmatch(n) for n in names):
            raise InputError(
                f"{file}: can't read {what}: its first line is {_short(header)}; a header is needed: {columns}"
            )
        rows = _Rows(names, header, separator, f"{file}: can't read {what}", first)
        for row in _rows(itertools.chain(ahead, lines), separator, file, what, first):
            rows.add(row)
        table = rows.table()
    return TextTable(table, first + 1)


class _Rows:
    """Rows of a table as they come, a block as text, all before it as numbers.

    Args:
        names: of the columns.
        header: the line that they stand in, for errors.
        separator: what separates them.
        where: begins an error.
        first: number of the header's line.
    """

    def __init__(self, names: list[str], header: str, separator: str, where: str, first: int) -> None:
        self._names, self._header, self._separator, self._where, self._first = names, header, separator, where, first
        self._ended = bool(names) and not names[-1]  # whether a separator ends every line, as far as is known
        self._count = 0
        self._blank = 0  # line of the first empty one
        self._text: list[list[str]] = []
        self._parts: list[list[NDArray[Any]]] = []

    def add(self, row: list[str]) -> None:
        """Take the next row; empty for an empty line.

        Raises:
            InputError: if it has not as many fields as the header, follows an empty line, or is one too many.
        """
        self._count += 1
        line = self._first + self._count
        if self._count * len(self._names) > MOST_CELLS:
            raise InputError(f"{self._where}: it has more than {MOST_CELLS} values; split it into pieces")
        if not row:
            self._blank = self._blank or line
            if line - self._blank > _MOST_BARE:
                raise InputError(f"{self._where}: from line {self._blank} on there are only empty lines; cut them off")
            return
        if self._blank:
            raise InputError(f"{self._where}: line {self._blank} is empty; remove it, or split the piece")
        if len(row) != len(self._names):
            comma = self._separator == "," and _commas(row)
            hint = "; decimal commas? Separate the columns by semicolons" if comma else ""
            raise InputError(
                f"{self._where}: line {line} has {len(row)} fields, the header {len(self._names)} "
                f"({_short(self._header)}, separated by {_SEPARATORS[self._separator]}s){hint}"
            )
        self._ended = self._ended and not row[-1].strip()
        self._text.append(row)
        if len(self._text) == _BLOCK:
            self._pack()

    def _pack(self) -> None:
        decimal = "," if self._separator != "," else "."
        if self._text:
            self._parts.append([_numbers([c.strip() for c in cells], decimal) for cells in zip(*self._text)])  # noqa: B905
        self._text = []

    def table(self) -> pd.DataFrame:
        """All rows."""
        self._pack()
        names = self._names[:-1] if self._ended else self._names
        parts = self._parts or [[np.zeros(0) for _ in names]]
        data = {i: _joined([part[i] for part in parts]) for i in range(len(names))}
        table = pd.DataFrame(data, index=pd.RangeIndex(sum(len(part[0]) for part in parts if part)))
        table.columns = pd.Index([printable(name) for name in names])
        return table


def _joined(parts: list[NDArray[Any]]) -> NDArray[Any]:
    """Blocks of a column. Where one holds text, numbers before it are text again, as a number is written."""
    if len(parts) > 1 and any(part.dtype == object for part in parts):
        parts = [part if part.dtype == object else np.array([repr(float(v)) for v in part], object) for part in parts]
    return np.concatenate(parts) if len(parts) > 1 else parts[0]


def _unpacked(data: bytes, file: Path, what: str) -> bytes:
    if data[:2] == b"\x1f\x8b":
        try:
            with gzip.open(io.BytesIO(data)) as stream:
                data = stream.read(_MOST_BYTES + 1)
        except (OSError, EOFError, zlib.error) as error:
            raise InputError(f"{file}: can't read {what}: it is packed by gzip and damaged ({error})") from None
        if len(data) > _MOST_BYTES:
            raise InputError(f"{file}: can't read {what}: unpacked it is over {_MOST_BYTES / 1e6:.0f} MB; split it")
    for magic, kind in _PACKED.items():
        if data.startswith(magic):
            raise InputError(f"{file}: can't read {what}: it is {kind}, not text; {' or '.join(ENDINGS)} is expected")
    return data


def _encoding(data: bytes, file: Path, what: str) -> str:
    """The encoding of a text; what can't be text is refused."""
    encoding = next((name for mark, name in _BOMS.items() if data.startswith(mark)), "")
    if not encoding:  # UTF-16 of plain letters has a zero in every other place
        zeros = data[:200].count(0)
        wide = zeros and 2 * zeros >= len(data[:200]) - 1
        encoding = "utf-8" if not wide else "utf-16-be" if data[:1] == b"\0" else "utf-16-le"
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
    return encoding


def _header(lines: Iterator[str], file: Path, what: str) -> tuple[int, str, list[str]]:
    """Number of the header's line, the header, and the line behind it if that was read already."""
    comment = ""
    for number, line in enumerate(lines, start=1):
        if number > _MOST_BARE:
            raise InputError(f"{file}: can't read {what}: there is no header in its first {_MOST_BARE} lines")
        if not line.strip() or line.lower().startswith("sep="):
            continue
        if not _COMMENT.match(line):
            # A header that is a comment itself, as numpy writes it.
            row, above = re.split(r"[,;\t|]", line), re.split(r"[,;\t|]", comment)
            if len(row) == len(above) > 1 and all(_NUMBER.fullmatch(c.strip()) for c in row):
                return number - 1, comment, [line]
            return number, line, []
        comment = _COMMENT.sub("", line, count=1).strip()
    return 0, "", []


def _separator(header: str) -> str:
    """What separates the header's names; a comma where there is one name."""
    plain = re.sub(r'"[^"]*"|\[[^\]]*\]', "", header)  # not inside quotes, nor inside a unit
    return max(_SEPARATORS, key=plain.count)


def _rows(lines: Iterable[str], separator: str, file: Path, what: str, first: int) -> Iterator[list[str]]:
    """The fields of each line; none for an empty one."""
    reader = csv.reader(lines, delimiter=separator, skipinitialspace=True, strict=True)
    where = f"{file}: can't read {what}"
    try:
        for number, row in enumerate(reader, start=1):
            if reader.line_num != number:
                raise InputError(f"{where}: a quoted text goes over several lines; quote no line ends")
            yield row if len(row) > 1 or any(cell.strip() for cell in row) else []
    except csv.Error as error:
        raise InputError(f"{where}: line {first + reader.line_num}: {error}") from None


def _numbers(cells: list[str], decimal: str) -> NDArray[Any]:
    """A column as numbers, to the last bit; as what was written where something is no number."""
    if _PLAIN.fullmatch("".join(cells)):
        with suppress(ValueError):
            return np.array([float(cell) for cell in cells])
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
