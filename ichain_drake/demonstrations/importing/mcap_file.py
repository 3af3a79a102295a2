"""MCAP files, of ROS 2 or with messages of JSON, and folders of them as ROS 2 records bags."""

from __future__ import annotations

import io
import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from ichain_drake.demonstrations.importing.extra import require
from ichain_drake.demonstrations.importing.log_map import LogMap
from ichain_drake.demonstrations.importing.messages import Message, MessageTable
from ichain_drake.demonstrations.table import Demonstration
from ichain_drake.errors import InputError
from ichain_drake.files import is_file, is_folder, printable

_MOST_RECORD = 2**28
"""A record, or a chunk of them, packed or not, is this long at most [bytes]; writers begin a new chunk after 1 to 4 MB,
and a message is a picture at most."""

_NEEDS = "reading MCAP"


def read_mcap(source: Path, mapping: LogMap) -> list[Demonstration]:
    """Every file as a piece. Columns have rates of their own, with empty cells in between.

    Args:
        source: a `.mcap` file, or a folder of them.
        mapping: sources are `/topic:field`, `/topic:field.part` or `/topic:field[0]`.

    Raises:
        InputError: if it is no MCAP, a topic or field is missing, or messages are neither JSON nor of ROS 2.
    """
    files = sorted(source.glob("*.mcap")) if is_folder(source) else [source]
    if not files:
        raise InputError(f"{source}: there is no .mcap file in it")
    return [_read(file, mapping) for file in files]


def _read(file: Path, mapping: LogMap) -> Demonstration:
    records = require("mcap.records", _NEEDS)
    if not is_file(file):
        raise InputError(f"{file}: there is no such file of MCAP")
    table = MessageTable(mapping, str(file))
    schemas: dict[int, Any] = {}
    channels: dict[int, Any] = {}
    decoders: dict[int, Callable[[bytes], Any]] = {}
    try:
        with file.open("rb") as stream:
            for record in _records(stream):
                if isinstance(record, records.Schema):
                    schemas[record.id] = record
                elif isinstance(record, records.Channel):
                    channels[record.id] = record
                    table.note(record.topic)
                elif isinstance(record, records.Message):
                    channel = channels[record.channel_id]
                    if channel.topic not in table.wanted:
                        continue
                    if channel.id not in decoders:
                        decoders[channel.id] = decoder(
                            channel.message_encoding, schemas.get(channel.schema_id), f"{file}: {channel.topic}"
                        )
                    table.add(Message(channel.topic, record.log_time, decoders[channel.id](record.data)))
    except InputError:
        raise
    except (Exception, MemoryError) as error:  # whatever the readers make of damage
        line = printable((str(error).splitlines() or [""])[0][:200])
        raise InputError(f"{file}: can't read it as MCAP: {type(error).__name__} {line}") from None
    return table.piece(file.stem)


def decoder(encoding: str, schema: Any, where: str) -> Callable[[bytes], Any]:
    """What turns a channel's bytes into messages.

    Args:
        encoding: of its messages.
        schema: the record that describes them, or None.
        where: what to call the channel in errors.

    Raises:
        InputError: if they are neither JSON nor of ROS 2, described by a message definition.
    """
    if encoding == "json":
        return json.loads
    if encoding == "cdr":
        made = require("mcap_ros2.decoder", _NEEDS).DecoderFactory().decoder_for(encoding, schema)
        if made is not None:
            return made  # type: ignore[no-any-return]
    about = getattr(schema, "encoding", "nothing")
    raise InputError(
        f"{printable(where)}: messages in {printable(encoding)!r:.40} described by {printable(about)!r:.40} can't be "
        "read; JSON and ROS 2 (cdr with ros2msg) can"
    )


def _records(stream: Any) -> Iterator[Any]:
    """Records in order, those in chunks too. The library's own reader would unpack a chunk to any size."""
    reader = require("mcap.stream_reader", _NEEDS)
    chunk_type = require("mcap.records", _NEEDS).Chunk
    for record in reader.StreamReader(stream, emit_chunks=True, record_size_limit=_MOST_RECORD).records:
        if not isinstance(record, chunk_type):
            yield record
            continue
        record.data, record.compression = _unpacked(record), ""
        yield from reader.breakup_chunk(record)


def _unpacked(chunk: Any) -> bytes:
    """The bytes of a chunk.

    Raises:
        InputError: if there are too many, whatever it claims.
    """
    if chunk.compression == "zstd":
        stream = require("zstandard", _NEEDS).ZstdDecompressor().stream_reader(io.BytesIO(chunk.data))
        data = stream.read(_MOST_RECORD + 1)
    elif chunk.compression == "lz4":
        data = require("lz4.frame", _NEEDS).LZ4FrameDecompressor().decompress(chunk.data, max_length=_MOST_RECORD + 1)
    elif chunk.compression:
        raise InputError(f"a chunk is packed by {printable(chunk.compression)!r:.40}; zstd and lz4 are read")
    else:
        data = chunk.data
    if len(data) > _MOST_RECORD:
        raise InputError(f"a chunk unpacks to over {_MOST_RECORD / 1e6:.0f} MB; nothing of it is read")
    return bytes(data)
