"""A bad network, on purpose: messages that are lost or late."""

from __future__ import annotations

from collections import deque
from typing import Generic, TypeVar

import numpy as np

from ichain_drake.errors import InputError

ItemT = TypeVar("ItemT")


class Lossy(Generic[ItemT]):
    """Passes on what is put in, some of it never, the rest after a while.

    Args:
        lost: share of messages that never arrive, from 0 to 1.
        late: how long the others take, in frames.
        seed: of which are lost.

    Raises:
        InputError: on a share that is none, or a negative time.
    """

    def __init__(self, lost: float = 0.0, late: int = 0, seed: int = 0) -> None:
        if not 0.0 <= lost < 1.0:
            raise InputError(f"--lost {lost:g}: a share of messages is at least 0 and below 1")
        if late < 0:
            raise InputError(f"--late {late}: no message arrives before it was sent")
        self._lost, self._late = lost, late
        self._random = np.random.default_rng([seed, 0x10C])
        self._waiting: deque[tuple[int, ItemT]] = deque()

    def put(self, frame: int, item: ItemT) -> None:
        """Send something in a frame."""
        if self._random.random() >= self._lost:
            self._waiting.append((frame + self._late, item))

    def get(self, frame: int) -> list[ItemT]:
        """What has arrived by a frame and was not taken yet, oldest first."""
        out = []
        while self._waiting and self._waiting[0][0] <= frame:
            out.append(self._waiting.popleft()[1])
        return out
