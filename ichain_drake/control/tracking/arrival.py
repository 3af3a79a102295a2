"""Whether something that follows a path has been all along it and has come to its end."""

from __future__ import annotations

import math

import numpy as np

from ichain_drake.control.tracking.path import TimedPath
from ichain_drake.state import FloatArray


class Arrival:
    """Watches a run along a path, in truth.

    A run has arrived if it has passed every point of the path within `PathLimits.corridor`, and then the end within
    `PathLimits.tolerance`. Being at the path's last point, counted along it, is not enough: who cuts a corner or drives
    past beside the end gets there too.

    Args:
        path: the timed path.
    """

    def __init__(self, path: TimedPath) -> None:
        self._limits = path.limits
        self._farthest = np.full(len(path.points), math.inf)
        self._end = self._last = math.inf
        self._near_end = False
        self._progress = self._before = 0

    def see(self, positions: FloatArray, path: TimedPath, progress: int) -> None:
        """Take note of where it was since the last call.

        Args:
            positions: true ones, in order, shape (n, 2); every frame, for between two ticks it may pass the end.
            path: as it lies now; a person may have moved it.
            progress: index of the path's point that has been reached.
        """
        # From the tick before on: where a path crosses itself, a later branch must not stand in for an earlier one.
        passed = slice(self._before, progress + 1)
        # All with all: they are few, and a tree of them would take longer to make.
        away = path.points[passed][:, None] - positions
        distance = np.sqrt((away**2).sum(axis=-1).min(axis=1))
        self._farthest[passed] = np.minimum(self._farthest[passed], distance)
        self._before, self._progress = self._progress, progress
        self._near_end = path.near_end(progress)
        if self._near_end:
            to_end = np.linalg.norm(positions - path.points[-1], axis=1)
            self._last = float(to_end[-1])
            self._end = min(self._end, float(to_end.min()))

    @property
    def arrived(self) -> bool:
        """Whether it has been all along the path and within the tolerance of its end."""
        return self._near_end and self._end <= self._limits.tolerance and self._missed <= self._limits.corridor

    @property
    def past(self) -> bool:
        """Whether the end lies behind: it has been nearer than it is now, and is at the path's last point."""
        return self._near_end and self._last > self._end

    @property
    def _missed(self) -> float:
        """How far off the path's worst point was passed, of those that it has come to [unit]."""
        return float(self._farthest[: self._progress + 1].max())

    def reason(self, unit: str, seconds: float) -> str:
        """Why it has not arrived, in words; empty if it has.

        Args:
            unit: of the path.
            seconds: how long the run took [s].
        """
        if self.arrived:
            return ""
        if not self._near_end:
            return f"left the path or stood still after {seconds:.1f} s"
        if self._end > self._limits.tolerance:
            return f"came no nearer to the end than {self._end:.3g} {unit}; {self._limits.tolerance:g} {unit} count"
        return f"left the path by {self._missed:.3g} {unit} on its way; {self._limits.corridor:g} {unit} count"
