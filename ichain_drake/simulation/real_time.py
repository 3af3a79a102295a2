"""Frames at the pace of the clock on the wall, and how well it was kept."""

from __future__ import annotations

import time
from collections import deque

import numpy as np

from ichain_drake.timing import FRAME

_LATE = 0.5  # frames behind that count as late
_RECENT = 5.0  # [s]
_STALL = 3.0  # frames behind after which nothing is caught up: a person can't drive in fast motion


class FrameClock:
    """Waits for each 1/30 s frame's due time.

    Due times are counted from the start, so that a frame that is a little late shortens the next wait and the mean
    period stays 1/30 s. After a longer stall the count starts anew.

    Args:
        pace: simulated seconds in a second.
    """

    def __init__(self, pace: float = 1.0) -> None:
        self._period = FRAME / pace
        self._due = time.monotonic()
        self._woken: list[float] = []
        self._late: deque[float] = deque(maxlen=100)
        self.late = 0

    def restart(self) -> None:
        """The next frame is due now; what was measured is forgotten."""
        self._due = time.monotonic()
        self._late.clear()
        self.measure()

    def measure(self) -> None:
        """Measure from here on; the frames go on as they were."""
        self._woken = []
        self.late = 0

    def wait(self) -> bool:
        """Sleep until the next frame is due.

        Returns:
            Whether it is late.
        """
        left = self._due - time.monotonic()
        if left > 0:
            time.sleep(left)
        now = time.monotonic()
        self._woken.append(now)
        behind = (now - self._due) / self._period
        self._due = now + self._period if behind > _STALL else self._due + self._period
        late = behind > _LATE
        if late:
            self.late += 1
            self._late.append(now)
        return late

    @property
    def recently_late(self) -> int:
        """Late frames of the last 5 s."""
        now = time.monotonic()
        return sum(now - then < _RECENT for then in self._late)

    def sampling(self) -> dict[str, float]:
        """How the frames came since `measure`: count, mean and 99th percentile of their periods [ms], late ones."""
        periods = 1000.0 * np.diff(self._woken)
        if not len(periods):
            return {"frames": len(self._woken), "late_frames": self.late}
        return {
            "frames": len(self._woken),
            "mean_period_ms": round(float(periods.mean()), 3),
            "p99_period_ms": round(float(np.percentile(periods, 99)), 3),
            "longest_period_ms": round(float(periods.max()), 3),
            "late_frames": self.late,
        }
