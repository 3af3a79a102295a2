"""Pieces as MCAP: a topic an object, messages of JSON, for Foxglove, PlotJuggler and the like."""

from __future__ import annotations

import io
import json
from collections.abc import Sequence
from pathlib import Path

from ichain_drake.demonstrations.columns import TIME
from ichain_drake.demonstrations.exporting.columns import Columns, map_text
from ichain_drake.demonstrations.importing.extra import require
from ichain_drake.demonstrations.table import Demonstration

_FLAGS = "graph/active"


def mcap_files(pieces: Sequence[Demonstration], columns: Columns) -> dict[str, bytes]:
    """A file a piece, by name, and the map that reads them back to the last bit.

    Args:
        pieces: all with these columns.
        columns: theirs.

    Raises:
        InputError: if the extra is not installed.
    """
    topics: dict[str, dict[str, str]] = {}
    for name in (*columns.states, *columns.commands):
        topic, _, variable = name.partition(".")
        topics.setdefault(topic, {})[variable] = name
    if columns.flags:
        topics[_FLAGS] = {name: name for name in columns.flags}
    files = {f"{Path(p.name).stem}.mcap": _file(p, topics) for p in pieces}
    sources = {f"/{topic}:{field}": name for topic, fields in topics.items() for field, name in fields.items()}
    return {**files, "map.yaml": map_text(sources, pieces[0].units, TIME)}


def _file(piece: Demonstration, topics: dict[str, dict[str, str]]) -> bytes:
    stream = io.BytesIO()
    writer = require("mcap.writer", "writing MCAP").Writer(stream)
    writer.start(profile="", library="ichain_drake")
    channels = {}
    for topic, fields in topics.items():
        properties = {TIME: {"type": "number", "description": "s"}}
        for field, name in fields.items():
            properties[field] = {"type": "number", "description": piece.units.get(name, "1")}
        form = json.dumps({"type": "object", "properties": properties}).encode()
        schema = writer.register_schema(name=f"ichain.{topic}", encoding="jsonschema", data=form)
        channels[topic] = writer.register_channel(topic=f"/{topic}", message_encoding="json", schema_id=schema)
    columns = {name: piece.table[name].tolist() for fields in topics.values() for name in fields.values()}
    for row, time in enumerate(piece.table[TIME].tolist()):
        stamp = max(round(time * 1e9), 0)
        for topic, fields in topics.items():
            message = {TIME: time, **{field: columns[name][row] for field, name in fields.items()}}
            data = json.dumps(message).encode()
            writer.add_message(channel_id=channels[topic], log_time=stamp, publish_time=stamp, data=data)
    writer.finish()
    return stream.getvalue()
