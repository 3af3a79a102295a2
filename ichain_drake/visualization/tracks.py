"""Keyframe tracks and their msgpack form, the animation that Meshcat's page replays.

Drake's own `MeshcatAnimation` keeps every frame as 64 bit numbers: 19 MB for five minutes of an arm with its objects.
Here frames that linear interpolation gives back are dropped, and the rest is rounded to binary fractions in 32 bits,
which compress well.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import umsgpack
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

GRID = 2.0**-17
"""Values are rounded to this (7.6 um as a length); the low bits of all numbers are zero then, and pack to nothing."""


@dataclass(frozen=True)
class TrackKind:
    """How three.js replays a property.

    Attributes:
        name: property path that three.js binds, such as `.position`.
        type: three.js track type; `boolean` holds its value, the others interpolate (quaternions along the arc).
        size: numbers in a value.
        tolerance: largest error that dropping a keyframe may cause, in the value's unit.
    """

    name: str
    type: str
    size: int
    tolerance: float


@dataclass
class Track:
    """Keyframes of one property of one object: frame numbers and values, in time order."""

    kind: TrackKind
    frames: list[int] = field(default_factory=list)
    values: list[tuple[float, ...]] = field(default_factory=list)

    def put(self, frame: int, value: tuple[float, ...]) -> None:
        """Append a keyframe; a second one at the same frame replaces the first.

        Raises:
            ValueError: if the frame lies before the last one.
        """
        if self.frames and frame <= self.frames[-1]:
            if frame < self.frames[-1]:
                raise ValueError(f"{self.kind.name}: frame {frame} comes after frame {self.frames[-1]}")
            self.frames.pop()
            self.values.pop()
        if len(self.values) > 1 and self.values[-1] == value == self.values[-2]:
            self.frames.pop()  # the middle one of three equal keyframes says nothing
            self.values.pop()
        self.frames.append(frame)
        self.values.append(value)

    def thinned(self) -> tuple[NDArray[np.int64], FloatArray]:
        """Keyframes without those that the others give back within the tolerance.

        Returns:
            frame numbers, shape (k,), and values, shape (k, size).
        """
        frames = np.array(self.frames, dtype=np.int64)
        values = np.array(self.values, dtype=float).reshape(len(frames), self.kind.size)
        if self.kind.type == "boolean":
            keep = np.ones(len(frames), dtype=bool)
            keep[1:] = values[1:, 0] != values[:-1, 0]
        else:
            if self.kind.type == "quaternion":  # q and -q are the same rotation; take the one near the last
                flips = np.sum(values[1:] * values[:-1], axis=1) < 0
                values[1:][np.cumsum(flips) % 2 == 1] *= -1
            keep = needed_keyframes(frames, values, self.kind.tolerance)
        return frames[keep], values[keep]


def needed_keyframes(frames: NDArray[np.int64], values: FloatArray, tolerance: float) -> NDArray[np.bool_]:
    """Which keyframes to keep so that linear interpolation gives back all others (Douglas-Peucker over time).

    Args:
        frames: increasing, shape (n,).
        values: shape (n, size).
        tolerance: largest error of a dropped value, as the Euclidean norm over the components.

    Returns:
        shape (n,); the first and the last of a track that changes are kept, of a constant one the first alone.
    """
    keep = np.zeros(len(frames), dtype=bool)
    keep[0] = True
    if np.all(np.linalg.norm(values - values[0], axis=1) <= tolerance):
        return keep
    keep[-1] = True
    spans = [(0, len(frames) - 1)]
    while spans:
        a, b = spans.pop()
        if b - a < 2:  # nothing in between
            continue
        share = (frames[a + 1 : b] - frames[a]) / (frames[b] - frames[a])
        guess = values[a] + share[:, None] * (values[b] - values[a])
        error = np.sum((values[a + 1 : b] - guess) ** 2, axis=1)
        worst = int(np.argmax(error))
        if error[worst] > tolerance**2:
            middle = a + 1 + worst
            keep[middle] = True
            spans += [(a, middle), (middle, b)]
    return keep


def pack_animation(tracks: Mapping[str, Sequence[Track]], rate: float, last_frame: int) -> bytes:
    """The `set_animation` command for Meshcat's page.

    Args:
        tracks: tracks of each object, by its full path in Meshcat's scene tree.
        rate: frames a second [Hz].
        last_frame: where the playback ends; every object's clip lasts until then, so that all of them end together
            (the page stops to move an object whose own clip has ended, also after seeking back).

    Returns:
        the msgpack bytes.
    """
    animations = [
        _map(
            ("path", umsgpack.packb(path)),
            (
                "clip",
                _map(
                    ("fps", umsgpack.packb(float(rate))),
                    ("name", umsgpack.packb("default")),
                    ("duration", umsgpack.packb(last_frame / rate)),
                    ("tracks", _list([_pack_track(t) for t in items])),
                ),
            ),
        )
        for path, items in tracks.items()
    ]
    # 2200: three.js LoopOnce.
    options = {"play": False, "loopMode": 2200, "repetitions": 1, "autoplay": False, "clampWhenFinished": True}
    return _map(
        ("type", umsgpack.packb("set_animation")),
        ("animations", _list(animations)),
        ("options", umsgpack.packb(options)),
    )


def _pack_track(track: Track) -> bytes:
    """One track; its keyframes all have the same layout, so numpy lays them out at once, a row of bytes each."""
    frames, values = track.thinned()
    n = len(frames)

    def same(text: bytes) -> NDArray[np.uint8]:
        return np.tile(np.frombuffer(text, dtype=np.uint8), (n, 1))

    def numbers(column: NDArray[Any]) -> NDArray[np.uint8]:
        return np.ascontiguousarray(column).view(np.uint8).reshape(n, -1)

    parts = [
        same(b"\x82" + umsgpack.packb("time") + b"\xce"),
        numbers(frames.astype(">u4")),
        same(umsgpack.packb("value")),
    ]
    if track.kind.type == "boolean":
        parts.append((0xC2 + values).astype(np.uint8))
    else:
        if track.kind.size > 1:
            parts.append(same(bytes([0x90 | track.kind.size])))
        for column in (np.round(values / GRID) * GRID).T:
            parts += [same(b"\xca"), numbers(column.astype(">f4"))]
    return _map(
        ("name", umsgpack.packb(track.kind.name)),
        ("type", umsgpack.packb(track.kind.type)),
        ("keys", struct.pack(">BI", 0xDD, n) + np.hstack(parts).tobytes()),
    )


def _map(*items: tuple[str, bytes]) -> bytes:
    """A msgpack map of already packed values."""
    return bytes([0x80 | len(items)]) + b"".join(umsgpack.packb(k) + v for k, v in items)


def _list(items: Iterable[bytes]) -> bytes:
    """A msgpack array of already packed values."""
    parts = list(items)
    return struct.pack(">BI", 0xDD, len(parts)) + b"".join(parts)
