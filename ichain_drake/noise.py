"""Reproducible noise: a value is a function of (seed, object id, purpose, variable id, frame), never of an order."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import Literal

import numpy as np

from ichain_drake.state import BoolArray, FloatArray

Purpose = Literal["process", "measurement"]
_PURPOSES: dict[str, int] = {"process": 0, "measurement": 1}
_BLOCK = 512


@lru_cache(maxsize=256)
def _block(seed: int, object_id: int, purpose: int, ids: tuple[int, ...], block: int) -> FloatArray:
    streams = [
        np.random.Generator(np.random.Philox(np.random.SeedSequence([seed, object_id, purpose, i, block]))) for i in ids
    ]
    values = np.stack([s.standard_normal(_BLOCK) for s in streams], axis=1)
    values.setflags(write=False)  # cached and shared: nobody may change it
    return values


class NoiseStream:
    """Standard normal noise of one object, one stream a variable.

    Because a value depends on nothing but its key and the frame, a cloned context replays, worker processes agree,
    and renaming or reordering objects changes nothing.

    Args:
        seed: seed of the run, >= 0.
        object_id: the object's id as declared in its scenario.
        purpose: what the noise is for; the two never share a stream.
        ids: the variables' ids.
    """

    def __init__(self, seed: int, object_id: int, purpose: Purpose, ids: tuple[int, ...]) -> None:
        self.key = (int(seed), int(object_id), _PURPOSES[purpose], tuple(int(i) for i in ids))

    def __len__(self) -> int:
        return len(self.key[3])

    def at(self, frame: int) -> FloatArray:
        """Noise of one 30 Hz frame, shape (n_streams,), mean 0 and variance 1."""
        if not self.key[3]:
            return np.zeros(0)
        return _block(*self.key, frame // _BLOCK)[frame % _BLOCK]

    def rows(self, frames: Sequence[int]) -> FloatArray:
        """Noise of several frames, shape (n, n_streams)."""
        numbers, places = np.divmod(np.asarray(frames, dtype=np.intp), _BLOCK)
        out = np.zeros((len(numbers), len(self)))
        for number in np.unique(numbers) if len(self) else ():
            mine = numbers == number
            out[mine] = _block(*self.key, int(number))[places[mine]]
        return out


class NoiseRows:
    """The same stream of several runs, a row each: to the bit what each `NoiseStream` gives.

    Args:
        streams: of one length.
    """

    def __init__(self, streams: Sequence[NoiseStream]) -> None:
        self._streams = list(streams)
        self._number, self._values = -1, np.zeros((len(self._streams), _BLOCK, len(self._streams[0])))

    def at(self, frame: int) -> FloatArray:
        """Noise of one 30 Hz frame, shape (n_runs, n_streams)."""
        number, place = divmod(frame, _BLOCK)
        if number != self._number and self._values.size:
            self._number = number
            for row, stream in zip(self._values, self._streams, strict=True):
                row[:] = _block.__wrapped__(*stream.key, number)  # many runs would push each other out of the cache
        return self._values[:, place]

    def keep(self, rows: BoolArray) -> None:
        """Go on with some of the runs; shape (n_runs,)."""
        self._streams = [s for s, kept in zip(self._streams, rows, strict=True) if kept]
        self._values = self._values[rows]
