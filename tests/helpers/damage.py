"""Files that are almost right, drawn at random: tables, damaged bytes, whatever JSON can hold."""

from __future__ import annotations

import io
import json
import math
import random
from functools import cache
from typing import Any

import numpy as np
import pytest

# What CSV readers stumble over, in pieces that join to tables that are almost right.
CELLS = (
    "", "0", "1", "0.3333", "-1e3", "1e300", "1e-400", "9" * 400, "nan", "inf", "0,5", "1_0", "\u0663", "=1+1",
    "__import__('os')", '"', '"a\n', "#", "\0", "\ufeff", "true", "2026-01-02T03:04:05", "9999-99-99T99:99:99",
    "x" * 200,
)  # fmt: skip
NAMES = (
    "time", "time [ms]", "time [9**9**9]", "arm.x", "arm.x [mm]", "arm.grip", "kart.place [px]", "kart.h [deg]",
    "arm->kart", "command.x", "", "index", "kart.place", "kart.h", "->", ".", "[", "a [b] [c]", "timestamp",
)  # fmt: skip


def letters(rng: random.Random, most: int) -> str:
    """Text of characters from anywhere."""
    ranges = ((32, 126), (0, 31), (128, 0x2FF), (0x2000, 0x206F), (0x1F300, 0x1F64F))
    return "".join(chr(rng.randint(*rng.choices(ranges, (6, 1, 1, 1, 1))[0])) for _ in range(rng.randint(0, most)))


def table(rng: random.Random) -> bytes:
    """Text that is almost a table."""
    separator, end = rng.choice([",", ";", "\t", "|", " ", ", "]), rng.choice(["\n", "\r\n", "\r"])
    width = rng.randint(0, 6)
    rows = [rng.choices(NAMES, k=width)]
    for _ in range(rng.randint(0, 5)):
        rows.append(rng.choices(CELLS, k=width if rng.randint(0, 9) else rng.randint(0, 8)))
    text = rng.choice(["", "# log\n", "sep=;\n", "\n\n"]) + end.join(separator.join(r) for r in rows)
    return text.encode(rng.choice(["utf-8", "utf-16", "utf-16-le", "utf-8-sig"]))


def damaged(rng: random.Random, good: bytes) -> bytes:
    """A good file with bytes changed, cut out, doubled or put in."""
    data = bytearray(good)
    for _ in range(rng.randint(1, 8)):
        at = rng.randint(0, max(0, len(data) - 1))
        what = rng.choice(["set", "flip", "cut", "end", "put", "double", "set", "flip"])
        if what == "set" and data:
            data[at] = rng.choice([0, 1, 127, 128, 255, rng.randint(0, 255)])
        elif what == "flip" and data:
            data[at] ^= 1 << rng.randint(0, 7)
        elif what == "cut":
            del data[at : at + rng.randint(1, 16)]
        elif what == "end" and not rng.randint(0, 3):
            del data[at:]
        elif what == "put":
            data[at:at] = rng.randbytes(rng.randint(0, 12))
        elif what == "double":
            data[at:at] = data[at : at + rng.randint(1, 32)]
    return bytes(data)


def json_of(rng: random.Random, *names: str, depth: int = 0) -> object:
    """Whatever JSON can hold, with names that a reader asks for."""
    kind = rng.randint(0, 9 if depth < 4 else 6)
    if kind == 7:
        return [json_of(rng, *names, depth=depth + 1) for _ in range(rng.randint(0, 3))]
    if kind > 7:
        return {rng.choice(names): json_of(rng, *names, depth=depth + 1) for _ in range(rng.randint(0, 4))}
    plain = (None, rng.random() < 0.5, rng.randint(-2, 9), 10**20, rng.choice([0.5, math.nan, math.inf, -1e308]))
    return (*plain, letters(rng, 5), rng.choice(names))[kind]


def altered(rng: random.Random, tree: Any, *names: str) -> None:
    """Puts other things into some places of what JSON held."""
    for _ in range(rng.randint(1, 3)):
        node = tree
        while isinstance(node, dict | list) and node and rng.random() < 0.8:
            key: Any = rng.choice(list(node)) if isinstance(node, dict) else rng.randrange(len(node))
            if rng.random() < 0.4 or not isinstance(node[key], dict | list):
                node[key] = json_of(rng, *names)
                break
            node = node[key]


def text_of(rng: random.Random, *names: str) -> bytes:
    text = json.dumps(json_of(rng, *names))
    cut = rng.randint(0, 40)
    return text[: len(text) - cut if cut < 10 else None].encode()


@cache
def hdf5_bytes() -> bytes:
    h5py = pytest.importorskip("h5py", reason="h5py is missing: pip install 'ichain_drake[logs]'")
    stream = io.BytesIO()
    with h5py.File(stream, "w") as file:
        demo = file.create_group("data/demo_0")
        demo.create_dataset("actions", data=np.arange(12.0).reshape(6, 2), compression="gzip")
        demo.create_dataset("obs/x", data=np.arange(6.0)[:, None])
    return stream.getvalue()


@cache
def minari_bytes() -> bytes:
    """As Minari lays it out; by its own hand in `test_minari.py`."""
    h5py = pytest.importorskip("h5py", reason="h5py is missing: pip install 'ichain_drake[logs]'")
    stream = io.BytesIO()
    with h5py.File(stream, "w", track_order=True) as file:
        episode = file.create_group("episode_0")
        episode.create_dataset("observations/x", data=np.arange(7.0)[:, None], chunks=True, maxshape=(None, 1))
        episode.create_dataset("actions", data=np.arange(12.0).reshape(6, 2), chunks=True, maxshape=(None, 2))
    return stream.getvalue()


@cache
def mcap_bytes() -> bytes:
    writer = pytest.importorskip("mcap.writer", reason="mcap is missing: pip install 'ichain_drake[logs]'")
    stream = io.BytesIO()
    log = writer.Writer(stream, compression=writer.CompressionType.NONE)
    log.start()
    channels = [log.register_channel(t, "json", 0) for t in ("/arm", "/kart")]
    for i in range(3):
        for channel, content in zip(channels, ({"x": i / 10}, {"list": [i]}), strict=True):
            log.add_message(channel, log_time=i, publish_time=i, data=json.dumps(content).encode())
    log.finish()
    return stream.getvalue()
