"""ROS 2 bags: folders of MCAP or of SQLite files, read without ROS.

The bag's own message definitions are interpreted; no code is generated from them.
"""

from __future__ import annotations

import sqlite3
from contextlib import closing
from pathlib import Path
from types import SimpleNamespace
from urllib.parse import quote

from ichain_drake.demonstrations.importing.log_map import LogMap
from ichain_drake.demonstrations.importing.mcap_file import decoder, read_mcap
from ichain_drake.demonstrations.importing.messages import Message, MessageTable
from ichain_drake.demonstrations.table import Demonstration
from ichain_drake.errors import InputError
from ichain_drake.files import is_file, is_folder, printable

_TABLES = ("topics", "message_definitions", "messages")


def read_ros2(source: Path, mapping: LogMap) -> list[Demonstration]:
    """Every file of a bag as a piece.

    Args:
        source: the bag's folder, or one of its files (`.mcap`, `.db3`).
        mapping: as for `read_mcap`.

    Raises:
        InputError: if it is no bag, holds no message definitions, or as `read_mcap`.
    """
    files = sorted([*source.glob("*.mcap"), *source.glob("*.db3")]) if is_folder(source) else [source]
    if not files:
        raise InputError(f"{source}: there is no .mcap and no .db3 file in it; name the folder of a ROS 2 bag")
    pieces = []
    for file in files:
        pieces += [_read_sqlite(file, mapping)] if file.suffix == ".db3" else read_mcap(file, mapping)
    return pieces


def _read_sqlite(file: Path, mapping: LogMap) -> Demonstration:
    if not is_file(file):
        raise InputError(f"{file}: there is no such file of a bag")
    table = MessageTable(mapping, str(file))
    try:
        with closing(sqlite3.connect(f"file:{quote(str(file.resolve()))}?mode=ro&immutable=1", uri=True)) as bag:
            # A view or trigger of the file's own must not run anything.
            bag.execute("PRAGMA trusted_schema=OFF")
            kinds = dict(
                bag.execute("SELECT name, type FROM sqlite_master WHERE name IN (?, ?, ?)", _TABLES).fetchall()
            )
            if any(kinds.get(name) != "table" for name in _TABLES):
                raise InputError(
                    f"{file}: it holds no message definitions (bags before ROS 2 Iron don't); convert it with "
                    "`ros2 bag convert` to mcap"
                )
            definitions = {
                name: (encoding, text)
                for name, encoding, text in bag.execute(
                    "SELECT topic_type, encoding, encoded_message_definition FROM message_definitions"
                )
            }
            for number, topic, kind, form in bag.execute(
                "SELECT id, name, type, serialization_format FROM topics ORDER BY id"
            ).fetchall():
                table.note(topic)
                if topic not in table.wanted:
                    continue
                encoding, text = definitions.get(kind, ("", ""))
                schema = SimpleNamespace(id=1, name=kind, encoding=encoding, data=text.encode())
                decode = decoder(form, schema, f"{file}: {topic}")
                for stamp, data in bag.execute(
                    "SELECT timestamp, data FROM messages WHERE topic_id = ? ORDER BY timestamp", (number,)
                ):
                    table.add(Message(topic, int(stamp), decode(data)))
    except InputError:
        raise
    except (Exception, MemoryError) as error:  # whatever damage leads to
        line = printable((str(error).splitlines() or [""])[0][:200])
        raise InputError(f"{file}: can't read it as a bag: {type(error).__name__} {line}") from None
    return table.piece(file.stem)
