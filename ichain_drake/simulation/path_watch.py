"""When a run along a path is over: it has arrived, is past the end, has left the path, or took too long."""

from __future__ import annotations

import numpy as np

from ichain_drake.control.settings import TRACKING
from ichain_drake.control.tracking.arrival import Arrival
from ichain_drake.control.tracking.path import TimedPath
from ichain_drake.state import FloatArray
from ichain_drake.timing import TICK


class PathWatch:
    """Judges a run along a path, tick by tick.

    Args:
        path: the timed path.

    Attributes:
        arrival: whether the path was followed to its end.
        progress: index of the path's point that has been reached.
        lost: whether it is too far from the path to find back.
        allowed: ticks that the run may take.
    """

    def __init__(self, path: TimedPath) -> None:
        self.arrival = Arrival(path)
        self.progress = 0
        self.lost = False
        self.allowed = int(np.ceil((1.6 * path.time[-1] + 5.0) / TICK))
        self._lost_at = TRACKING.lost * path.limits.speed * TICK

    def see(self, position: FloatArray, passed: FloatArray, path: TimedPath, last: int) -> bool:
        """Take note of one tick.

        Args:
            position: measured, at its end, shape (2,).
            passed: true positions in it, every frame, its start included, shape (n, 2).
            path: as it lies now; a person may have moved it.
            last: index of the path's point that had been reached before.

        Returns:
            Whether the run is over.
        """
        return self.see_at(path.advance(position, last, TRACKING.search * TICK), position, passed, path)

    def see_at(self, progress: int, position: FloatArray, passed: FloatArray, path: TimedPath) -> bool:
        """`see` of whoever knows already which point of the path has been reached, by its index."""
        self.progress = progress
        self.arrival.see(passed, path, self.progress)
        self.lost = bool(np.linalg.norm(path.points[self.progress] - position) > self._lost_at)
        return self.arrival.arrived or self.arrival.past or self.lost
