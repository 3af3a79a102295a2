"""Tables as Parquet: read without trusting their metadata, written with units in it."""

from __future__ import annotations

import io
import json
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq

from ichain_drake.errors import InputError
from ichain_drake.files import printable, read_whole

_METADATA_KEY = b"ichain_drake"
_MOST_CELLS = 5 * 10**7  # 400 MB as numbers
_ROWS = 2**14  # of one batch
_MOST_PARTS = 10**4  # of a list in the file's own description: columns, row groups
_MOST_TEXT = 10**7  # bytes of a text in it


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
        # From memory: of a name, pyarrow would read folders as columns (`run=1/log.parquet`).
        with pq.ParquetFile(
            pa.BufferReader(data),
            thrift_container_size_limit=_MOST_PARTS,
            thrift_string_size_limit=_MOST_TEXT,
        ) as stored:
            # Not by what it says of its columns: pyarrow ends the whole process over some that are damaged.
            cells = stored.metadata.num_rows * stored.metadata.num_columns
            if cells > _MOST_CELLS:
                raise InputError(
                    f"{file}: can't read {what}: it claims {cells} values, and {_MOST_CELLS} are read at most; split it"
                )
            table = _read(stored, file, what, only)
        units = _units(table.schema.metadata or {}, file, what)
        return _seconds(table.replace_schema_metadata(None).to_pandas()), units
    except InputError:
        raise
    except (Exception, MemoryError) as error:  # whatever pyarrow makes of damage
        line = printable((str(error).splitlines() or [""])[0][:200])
        raise InputError(f"{file}: can't read {what}: {line or type(error).__name__}") from None


def _read(stored: pq.ParquetFile, file: Path, what: str, only: Collection[str] | None) -> pa.Table:
    """All rows, bit by bit: lists in cells, and parts that hold more rows than claimed, would take any memory."""
    batches, total, schema = [], 0, stored.schema_arrow
    if only is not None:
        schema = pa.schema([f for f in schema if f.name in only], schema.metadata)
    columns = None if only is None else schema.names
    for batch in stored.iter_batches(_ROWS, columns=columns, use_threads=False):
        total += batch.nbytes
        if total > 8 * _MOST_CELLS:
            raise InputError(f"{file}: can't read {what}: it holds more than {8 * _MOST_CELLS / 1e6:.0f} MB; split it")
        # Pyarrow takes a name for the beginning of others, too.
        batches.append(batch if only is None else batch.select(schema.names))
    return pa.Table.from_batches(batches, schema)


def _units(metadata: Mapping[bytes, bytes], file: Path, what: str) -> dict[str, str]:
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


def _seconds(table: pd.DataFrame) -> pd.DataFrame:
    """The table with moments and spans of time as seconds, moments since the first."""
    table.columns = pd.Index([printable(str(c)) for c in table.columns])
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
