"""What a Parquet file claims to hold, looked at before a library is asked to unpack it.

A page of a few bytes may claim gigabytes, one value in a dictionary may stand in a million rows, and pyarrow takes the
memory before it looks at what is there. Format: https://github.com/apache/parquet-format/blob/master/README.md
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Protocol

from ichain_drake.demonstrations.thrift import CompactReader, DamagedError
from ichain_drake.files import MOST_CELLS

_MAGIC = b"PAR1"
_MOST_BYTES = 2**28
"""All pages of a file together, unpacked [bytes]: as much as a table of text may have."""
_MOST_PARTS = 100
"""Times the values, where a file is read by parts: the time to read them is bounded, too."""
_MOST_TEXTS = 2 * 10**6
"""Cells of text; each that differs from all others takes some sixty bytes more."""
_MOST_WIDTH = 16
"""Bytes of a value of fixed width: the widest numbers have as many."""
_MOST_ABOUT = 2**21
"""The description [bytes]; and the heads of all pages together."""
_HEAD = 2**13
"""The head of a page is shorter [bytes]."""
_FIXED, _TEXT = 7, 6  # types of columns
_REPEATED = 2
_PAGES = (0, 2, 3)  # data, dictionary, data of the second version
_INDEX = 1
_REBUILT = 7  # DELTA_BYTE_ARRAY: each text begins with a part of the one before it, as long as it likes


class TooMuchError(ValueError):
    """The file claims more than is read."""


@dataclass(frozen=True)
class Column:
    """A column at the top.

    Attributes:
        name: its name.
        leaf: its number among all columns that hold values; None where it holds lists or parts of its own.
        text: whether its values are texts.
    """

    name: str
    leaf: int | None
    text: bool


@dataclass(frozen=True)
class Claims:
    """What a file says of itself that was found to hold.

    Attributes:
        columns: at the top, in order.
        rows: how many there are.
    """

    columns: tuple[Column, ...]
    rows: int


class Bytes(Protocol):
    """Bytes, all in memory or not; see `FileBytes`."""

    def __len__(self) -> int: ...

    def __getitem__(self, part: slice) -> bytes: ...


def read_claims(data: Bytes, *, by_parts: bool = False) -> Claims:
    """Look at a file's description and at the heads of all its pages; nothing is unpacked.

    Args:
        data: the whole file.
        by_parts: whether no more than one of its row groups will be in memory at a time, and no texts: then the bounds
            hold for each of them, and all may have a hundred times as many values.

    Raises:
        DamagedError: if it is no Parquet, or its description and its pages don't fit together.
        TooMuchError: if it would take more memory than it may.
    """
    if len(data) < 12 or data[:4] != _MAGIC or data[-4:] != _MAGIC:  # noqa: PLR2004 - both ends and a length
        raise DamagedError("it is no Parquet, or cut short")
    size = int.from_bytes(data[-8:-4], "little")
    if size > len(data) - 12:
        raise DamagedError(f"its description claims to be {size} bytes")
    if size > _MOST_ABOUT:
        raise TooMuchError(
            f"its description is {size / 1e6:.0f} MB, and {_MOST_ABOUT / 1e6:.0f} are read at most; split it"
        )
    about = CompactReader(data[len(data) - 8 - size : len(data) - 8]).struct()
    columns, rows = _columns(_structs(about, 2)), _number(about, 3)
    cells = _MOST_PARTS * MOST_CELLS if by_parts else MOST_CELLS
    if rows * max(1, len(columns)) > cells:
        raise TooMuchError(f"it claims {rows * len(columns)} values, and {cells} are read at most; split it")
    if not by_parts and rows * sum(column.text for column in columns) > _MOST_TEXTS:
        raise TooMuchError(f"it claims more than {_MOST_TEXTS} texts; leave columns of text out")
    groups = _structs(about, 4)
    if sum(_number(group, 3) for group in groups) != rows:
        raise DamagedError("its parts don't have as many rows as it says")
    unpacked, heads = 0, 0
    for group in groups:
        unpacked = 0 if by_parts else unpacked
        for page in (page for column in _structs(group, 1) for page in _pages(column, data)):
            unpacked, heads = unpacked + page[0], heads + page[1]
            if unpacked > _MOST_BYTES or heads > _MOST_ABOUT:
                whose = "a row group of it" if by_parts else "it"
                raise TooMuchError(
                    f"{whose} unpacks to more than {_MOST_BYTES / 1e6:.0f} MB, or to too many pages; split it"
                )
    return Claims(columns, rows)


def _number(fields: Any, key: int) -> int:
    value = fields.get(key) if isinstance(fields, dict) else None
    if not isinstance(value, int) or value < 0:
        raise DamagedError("a number in its description is missing or negative")
    return value


def _structs(fields: Any, key: int) -> list[dict[int, Any]]:
    value = fields.get(key) if isinstance(fields, dict) else None
    if not isinstance(value, list) or not all(isinstance(item, dict) for item in value):
        raise DamagedError("a list in its description is missing")
    return value


def _columns(schema: list[dict[int, Any]]) -> tuple[Column, ...]:
    if not schema:
        raise DamagedError("it describes no columns")
    found, place, leaf = [], 1, 0
    for _ in range(_number(schema[0], 5) if 5 in schema[0] else 0):
        start, first, left = place, leaf, 1
        while left:  # the column's own parts, parts of parts, ...
            if place >= len(schema):
                raise DamagedError("it describes fewer columns than it counts")
            parts = _number(schema[place], 5) if 5 in schema[place] else 0
            left, place, leaf = left + parts - 1, place + 1, leaf + (not parts)
        about = schema[start]
        if not isinstance(about.get(4), bytes):
            raise DamagedError("a column has no name")
        wide = about.get(1) == _FIXED and _number(about, 2) > _MOST_WIDTH
        plain = place - start == 1 and leaf == first + 1 and about.get(3) != _REPEATED and not wide
        found.append(
            Column(about[4].decode(errors="backslashreplace"), first if plain else None, about.get(1) == _TEXT)
        )
    if place != len(schema):
        raise DamagedError("it describes more columns than it counts")
    return tuple(found)


def _pages(column: dict[int, Any], data: Bytes) -> Iterator[tuple[int, int]]:
    """Bytes that each page of a part of a column unpacks to, and that its head takes."""
    about = column.get(3)
    starts = [_number(about, 9)]
    if isinstance(about, dict) and about.get(11):
        starts.append(_number(about, 11))
    place = min(starts)
    end = place + _number(about, 7)
    if 1 in column or end > len(data):
        raise DamagedError("a column's values are elsewhere")
    while place < end:
        reader = CompactReader(data[place : min(end, place + _HEAD)])
        head = reader.struct()
        kind, unpacked, packed = _number(head, 1), _number(head, 2), _number(head, 3)
        if kind not in (*_PAGES, _INDEX) or packed > end - place - reader.place:
            raise DamagedError("a page claims more than is there")
        for key, encoding in ((5, 2), (7, 2), (8, 4)):
            if key in head and _number(head[key], encoding) == _REBUILT:
                raise TooMuchError("its texts are packed one after another (DELTA_BYTE_ARRAY); write it in another way")
        yield unpacked, reader.place
        place += reader.place + packed
