"""Tables as Parquet: read without trusting their metadata, written with units in it."""

from __future__ import annotations

import io
import json
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from ichain_drake.demonstrations.parquet_claims import Claims, TooMuchError, read_claims
from ichain_drake.errors import InputError
from ichain_drake.files import printable, read_whole

_METADATA_KEY = b"ichain_drake"
_MOST_BYTES = 2 * 10**8  # of all values together, as Arrow holds them
_ROWS = 2**14  # of one batch


def read_parquet(file: Path, what: str, only: Collection[str] | None = None) -> tuple[pd.DataFrame, dict[str, str]]:
    """Read a table and the units in its metadata. What pandas says about its index there is not needed.

    Args:
        file: which.
        what: it should be, for errors: `the demonstration`.
        only: names of the columns to read, as far as they are there; all of them by default.

    Raises:
        InputError: if it is no Parquet, damaged, or too large.
    """
    data = read_whole(file, what)
    if not data.startswith(b"PAR1"):
        raise InputError(f"{file}: can't read {what}: it is no Parquet; write it anew, or as .csv")
    try:
        claims = read_claims(data)
        # From memory: of a name, pyarrow would read folders as columns (`run=1/log.parquet`).
        with pq.ParquetFile(
            pa.BufferReader(data),
            # Written out, one long text in many rows would take any memory.
            read_dictionary=[c.name for c in claims.columns if c.text and c.leaf is not None],
            pre_buffer=False,
            arrow_extensions_enabled=False,
        ) as stored:
            units = units_of(stored.metadata.metadata or {}, file, what)
            table = _frame(stored, claims) if only is None else _chosen(stored, only)
            return seconds(table), units
    except InputError:
        raise
    except (Exception, MemoryError) as error:  # whatever pyarrow makes of damage
        line = printable((str(error).splitlines() or [""])[0][:200])
        raise InputError(f"{file}: can't read {what}: {line or type(error).__name__}") from None


def _frame(stored: pq.ParquetFile, claims: Claims) -> pd.DataFrame:
    """All rows, bit by bit. What holds lists, or no numbers, texts or times, is a column of nothing."""
    leaves = [c.leaf for c in claims.columns if c.leaf is not None]
    batches, total = [], 0
    # By number: names may be doubled, and a dot in one would stand for a part of a column.
    for batch in stored.reader.iter_batches(
        _ROWS, row_groups=range(stored.num_row_groups), column_indices=leaves, use_threads=False
    ):
        total += batch.nbytes
        if total > _MOST_BYTES:
            raise TooMuchError(f"it holds more than {_MOST_BYTES / 1e6:.0f} MB; split it")
        batches.append(batch)
    read = iter(pa.Table.from_batches(batches).columns if batches else [pa.array([])] * len(leaves))
    columns = {
        i: values_of(next(read)) if column.leaf is not None else nothing(claims.rows)
        for i, column in enumerate(claims.columns)
    }
    table = pd.DataFrame(columns, index=pd.RangeIndex(claims.rows))
    table.columns = pd.Index([printable(column.name) for column in claims.columns])
    return table


def values_of(column: pa.ChunkedArray | pa.Array) -> pd.Series | NDArray[Any]:
    """A column as pandas takes it, without writing texts of a dictionary out; see `nothing`."""
    kind = column.type
    if pa.types.is_decimal(kind):
        column = column.cast(pa.float64())
    elif pa.types.is_dictionary(kind) and (pa.types.is_string(kind.value_type) or pa.types.is_binary(kind.value_type)):
        # Left to itself, pandas would write each text out again.
        return pd.Series(column.to_pandas().astype(object), dtype=object)
    elif not (pa.types.is_primitive(kind) or pa.types.is_null(kind)) or pa.types.is_time(kind):
        return nothing(len(column))
    return np.asarray(column.to_pandas(date_as_object=False))


def nothing(rows: int) -> NDArray[Any]:
    """A column of nothing, shape (rows,), in place of one that holds no numbers, texts or times."""
    return np.full(rows, None)


def _chosen(stored: pq.ParquetFile, only: Collection[str]) -> pd.DataFrame:
    """All rows of some columns, bit by bit; lists as they are."""
    schema = pa.schema([f for f in stored.schema_arrow if f.name in only])
    batches, total = [], 0
    for batch in stored.iter_batches(_ROWS, columns=schema.names, use_threads=False):
        total += batch.nbytes
        if total > _MOST_BYTES:
            raise TooMuchError(f"it holds more than {_MOST_BYTES / 1e6:.0f} MB; split it")
        # Pyarrow takes a name for the beginning of others, too.
        batches.append(batch.select(schema.names))
    table: pd.DataFrame = (pa.Table.from_batches(batches) if batches else schema.empty_table()).to_pandas()
    return table


def units_of(metadata: Mapping[bytes, bytes], file: Path, what: str) -> dict[str, str]:
    """Units by column, as `parquet_bytes` writes them into a file's metadata.

    Raises:
        InputError: if there is something else.
    """
    if _METADATA_KEY not in metadata:
        return {}
    try:
        about: Any = json.loads(metadata[_METADATA_KEY])
    except (ValueError, RecursionError):
        about = None
    units = about.get("units", {}) if isinstance(about, dict) else None
    if not isinstance(units, dict) or not all(isinstance(u, str) for u in units.values()):
        raise InputError(
            f"{file}: can't read {what}: its metadata is {printable(str(about)[:40])}, not "
            '{"units": {column: unit}}; write it anew'
        )
    return {printable(str(c)): printable(u) for c, u in units.items()}


def seconds(table: pd.DataFrame) -> pd.DataFrame:
    """The table with moments and spans of time as seconds, moments since the first."""
    for i, kind in enumerate(table.dtypes):
        if pd.api.types.is_datetime64_any_dtype(kind):
            values = table.iloc[:, i]
            table.isetitem(i, (values - values.min()).dt.total_seconds())
        elif pd.api.types.is_timedelta64_dtype(kind):
            table.isetitem(i, table.iloc[:, i].dt.total_seconds())
    return table


def parquet_bytes(table: pd.DataFrame, units: Mapping[str, str]) -> bytes:
    """A table as the bytes of a Parquet file, with units in its metadata."""
    stored = pa.Table.from_pandas(table, preserve_index=False)
    metadata = {**(stored.schema.metadata or {}), _METADATA_KEY: json.dumps({"units": dict(units)}).encode()}
    stream = io.BytesIO()
    pq.write_table(stored.replace_schema_metadata(metadata), stream)
    return stream.getvalue()
