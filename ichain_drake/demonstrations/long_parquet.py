"""A Parquet file of any length, read some thousand rows at a time: what is in memory does not depend on its length."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq

from ichain_drake.demonstrations.parquet import nothing, seconds, units_of, values_of
from ichain_drake.demonstrations.parquet_claims import read_claims
from ichain_drake.demonstrations.thrift import DamagedError
from ichain_drake.errors import InputError
from ichain_drake.files import FileBytes, opened, printable

_ROWS = 2**14  # of one batch
_BUFFER = 2**16  # bytes of a column that are read ahead


class LongParquet:
    """An open file; see `opened_parquet`. Texts are not read: a column of them is one of nothing.

    Attributes:
        names: of its columns.
        units: in its metadata, by column.
        rows: how many it has.

    Args:
        stream: the file.
        file, what: for errors.
    """

    def __init__(self, stream: BinaryIO, file: Path, what: str) -> None:
        claims = read_claims(FileBytes(stream), by_parts=True)
        # An open file: of a name, pyarrow would read folders as columns (`run=1/log.parquet`).
        self._stored = pq.ParquetFile(
            pa.PythonFile(stream, mode="r"), pre_buffer=False, buffer_size=_BUFFER, arrow_extensions_enabled=False
        )
        self._leaves = [None if c.text else c.leaf for c in claims.columns]
        self.names = [printable(c.name) for c in claims.columns]
        self.units = units_of(self._stored.metadata.metadata or {}, file, what)
        self.rows = claims.rows

    def parts(self, wanted: Collection[str]) -> Iterator[pd.DataFrame]:
        """All rows of some columns, a batch at a time; columns that are not there are left out."""
        chosen = [k for k, name in enumerate(self.names) if name in wanted]
        for _, batch in self._batches([leaf for k in chosen if (leaf := self._leaves[k]) is not None], 0, self.rows):
            yield self._frame(chosen, [batch])

    def stretches(self, ranges: Sequence[tuple[int, int]]) -> Iterator[pd.DataFrame]:
        """Some ranges of rows with all columns.

        Args:
            ranges: first rows and rows after the last, ascending.
        """
        leaves = [leaf for leaf in self._leaves if leaf is not None]
        left, kept = list(ranges), list[pa.RecordBatch]()
        if not left:
            return
        for place, batch in self._batches(leaves, left[0][0], left[-1][1]):
            while left and left[0][0] < place + batch.num_rows:
                first, end = left[0]
                start = max(first - place, 0)
                kept.append(_copied(batch.slice(start, min(end - place, batch.num_rows) - start)))
                if end > place + batch.num_rows:
                    break
                yield self._frame(range(len(self.names)), kept)
                left, kept = left[1:], []
        if left:
            raise DamagedError("it has fewer rows than it claims")

    def _batches(self, leaves: Sequence[int], first: int, end: int) -> Iterator[tuple[int, pa.RecordBatch]]:
        """Batches of the row groups that have any of some rows, and the first row of each."""
        at = 0
        for k in range(self._stored.num_row_groups):
            place, at = at, at + self._stored.metadata.row_group(k).num_rows
            if place >= end or at <= first:
                continue
            if not leaves:
                for start in range(place, at, _ROWS):
                    yield start, pa.RecordBatch.from_arrays([pa.nulls(min(_ROWS, at - start))], ["nothing"])
                continue
            for batch in self._stored.reader.iter_batches(
                _ROWS, row_groups=[k], column_indices=list(leaves), use_threads=False
            ):
                yield place, batch
                place += batch.num_rows

    def _frame(self, chosen: Sequence[int], batches: Sequence[pa.RecordBatch]) -> pd.DataFrame:
        rows = sum(batch.num_rows for batch in batches)
        read = iter(pa.Table.from_batches(batches).columns)
        columns: dict[int, Any] = {
            k: nothing(rows) if self._leaves[i] is None else values_of(next(read)) for k, i in enumerate(chosen)
        }
        table = pd.DataFrame(columns, index=pd.RangeIndex(rows))
        table.columns = pd.Index([self.names[i] for i in chosen])
        return seconds(table)


def _copied(part: pa.RecordBatch) -> pa.RecordBatch:
    """The same rows without the batch around them, which would stay in memory."""
    return part.take(pa.array(np.arange(part.num_rows)))


@contextmanager
def opened_parquet(file: Path, what: str) -> Iterator[LongParquet]:
    """A file for as long as it is read.

    Args:
        file: which.
        what: it should be, for errors: `the demonstration`.

    Raises:
        InputError: if it is no Parquet, damaged, or one of its row groups is too large.
    """
    with opened(file, what) as stream:
        try:
            yield LongParquet(stream, file, what)
        except InputError:
            raise
        except (Exception, MemoryError) as error:  # whatever pyarrow makes of damage
            line = printable((str(error).splitlines() or [""])[0][:200])
            raise InputError(f"{file}: can't read {what}: {line or type(error).__name__}") from None
