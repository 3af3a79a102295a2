"""A small MCAP file of JSON, written by its own library."""

import json
from pathlib import Path


def write_json(file: Path, messages: list[tuple[str, int, object]], encoding: str = "json", **options: object) -> Path:
    """Messages of topic, time [ns] and content, in order; bytes as they are."""
    from mcap.writer import Writer  # noqa: PLC0415

    with file.open("wb") as stream:
        writer = Writer(stream, **options)
        writer.start()
        topics = {t: writer.register_channel(t, encoding, 0) for t, _, _ in messages}
        for topic, time, content in messages:
            data = content if isinstance(content, bytes) else json.dumps(content).encode()
            writer.add_message(topics[topic], log_time=time, publish_time=time, data=data)
        writer.finish()
    return file
