"""Values in Thrift's compact protocol, as Parquet describes itself: read without trusting a length in it.

Source: https://github.com/apache/thrift/blob/master/doc/specs/thrift-compact-protocol.md
"""

from __future__ import annotations

import struct
from typing import Any

_MOST_DEPTH = 16  # Parquet's own descriptions go 8 deep
_MOST_ITEMS = 10**5  # of one list
_STOP, _TRUE, _FALSE, _BYTE, _I16, _I32, _I64, _DOUBLE, _BINARY, _LIST, _SET, _MAP, _STRUCT, _UUID = range(14)


class DamagedError(ValueError):
    """What is there is no value of this protocol."""


class CompactReader:
    """Reads structures: `{field id: value}`, with lists as lists, texts as bytes.

    Args:
        data: the bytes.
        place: of the first one.

    Attributes:
        place: of the byte behind what was read.
    """

    def __init__(self, data: bytes, place: int = 0) -> None:
        self.data = data
        self.place = place

    def struct(self, depth: int = 0) -> dict[int, Any]:
        """The structure that begins here.

        Raises:
            DamagedError: if there is none, or the bytes end before it does.
        """
        if depth > _MOST_DEPTH:
            raise DamagedError("it is nested too deeply")
        found: dict[int, Any] = {}
        number = 0
        while (head := self._byte()) & 0x0F != _STOP:
            number = number + (head >> 4) if head >> 4 else self._zigzag()
            kind = head & 0x0F
            found[number] = kind == _TRUE if kind in (_TRUE, _FALSE) else self._value(kind, depth + 1)
        return found

    def _byte(self) -> int:
        if self.place >= len(self.data):
            raise DamagedError("it ends too soon")
        self.place += 1
        return self.data[self.place - 1]

    def _bytes(self, count: int) -> bytes:
        if count > len(self.data) - self.place:
            raise DamagedError("it ends too soon")
        self.place += count
        return self.data[self.place - count : self.place]

    def _varint(self) -> int:
        value = 0
        for shift in range(0, 70, 7):
            byte = self._byte()
            value |= (byte & 0x7F) << shift
            if byte < 0x80:  # noqa: PLR2004 - the last one
                return value
        raise DamagedError("a number in it is too long")

    def _zigzag(self) -> int:
        value = self._varint()
        return (value >> 1) ^ -(value & 1)

    def _value(self, kind: int, depth: int) -> Any:  # noqa: PLR0911 - one return a kind
        if kind in (_TRUE, _FALSE, _BYTE):  # truth values in lists take a byte
            return self._byte()
        if kind in (_I16, _I32, _I64):
            return self._zigzag()
        if kind == _DOUBLE:
            return struct.unpack("<d", self._bytes(8))[0]
        if kind == _BINARY:
            return self._bytes(self._varint())
        if kind in (_LIST, _SET):
            return self._list(depth)
        if kind == _MAP:
            return self._map(depth)
        if kind == _STRUCT:
            return self.struct(depth)
        if kind == _UUID:
            return self._bytes(16)
        raise DamagedError(f"there is no kind {kind}")

    def _list(self, depth: int) -> list[Any]:
        head = self._byte()
        count = self._varint() if head >> 4 == 0x0F else head >> 4  # noqa: PLR2004 - a longer one follows
        self._check_count(count, depth)
        return [self._value(head & 0x0F, depth + 1) for _ in range(count)]

    def _map(self, depth: int) -> dict[Any, Any]:
        count = self._varint()
        self._check_count(count, depth)
        kinds = self._byte() if count else 0
        found = {}
        for _ in range(count):
            key = self._value(kinds >> 4, depth + 1)
            value = self._value(kinds & 0x0F, depth + 1)
            found[key if isinstance(key, int | bytes) else repr(key)] = value
        return found

    def _check_count(self, count: int, depth: int) -> None:
        if depth > _MOST_DEPTH:
            raise DamagedError("it is nested too deeply")
        if count > min(_MOST_ITEMS, len(self.data) - self.place):  # each takes a byte or more
            raise DamagedError("a list in it is too long")
