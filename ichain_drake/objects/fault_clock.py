"""When slips and knocks of a thing that a hand moves are due; how many happened is counted in its own state."""

from __future__ import annotations

import numpy as np

from ichain_drake.objects.camera import CameraFrame
from ichain_drake.objects.vessels.cup_settings import CupFaults
from ichain_drake.state import BoolArray, FloatArray, StateSpace
from ichain_drake.timing import FRAME

COUNTED = ("age", "slips_done", "knocks_done")
"""Hidden variables that a thing with faults has: its age [s], and how many slips and knocks happened."""

_HALF = 0.5 * FRAME  # s; ages are sums of frames


class FaultClock:
    """Slips and knocks of one thing. States have their variables first here: shape (n_variables, ...).

    Args:
        faults: what is to go wrong, and when.
        space: of the thing; has the variables `COUNTED`.
    """

    def __init__(self, faults: CupFaults, space: StateSpace) -> None:
        self._age, self._slips_done, self._knocks_done = (space.index(n) for n in COUNTED)
        self._slips = np.array(sorted(faults.slips))
        self._knocks, self._away = sorted(faults.knocks), faults.away

    @property
    def knocks(self) -> bool:
        """Whether there are any."""
        return bool(self._knocks)

    def slips(self, s: FloatArray) -> BoolArray:
        """Whether a slip is due, shape (...)."""
        if not len(self._slips):
            return np.asarray(False)
        return np.asarray(self._due(s) > s[self._slips_done])

    def slipped(self, s: FloatArray, lost: BoolArray) -> None:
        """Count the slips that were due as done where a closed hand has lost the thing, shape (...)."""
        if len(self._slips):
            s[self._slips_done] = np.where(lost, self._due(s), s[self._slips_done])

    def _due(self, s: FloatArray) -> FloatArray:
        return np.asarray((self._slips <= s[self._age][..., None] + _HALF).sum(axis=-1), dtype=float)

    def knock(self, s: FloatArray, free: BoolArray, camera: CameraFrame, hand: FloatArray) -> BoolArray:
        """Displace the thing, whose place is the first three variables, by the next knock that is due.

        Args:
            s: changed in place.
            free: where it stands by itself, shape (...).
            camera: frame of its place.
            hand: where the hand is, in the robot's frame [m], shape (3, ...).

        Returns:
            Where it was displaced, shape (...).
        """
        done = s[self._knocks_done].copy()
        free = free & (np.linalg.norm(camera.to_robot(s[:3].T).T - hand, axis=0) >= self._away)
        for k, (time, dx, dy) in enumerate(self._knocks):
            now = free & (done == k) & (s[self._age] >= time - _HALF)
            shift = camera.from_robot(np.array([dx, dy, 0.0])) - camera.from_robot(np.zeros(3))
            s[:3] = np.where(now, (s[:3].T + shift).T, s[:3])
            s[self._knocks_done] = np.where(now, k + 1, s[self._knocks_done])
        return np.asarray(s[self._knocks_done] != done)
