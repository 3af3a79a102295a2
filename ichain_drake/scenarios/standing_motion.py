"""Ways of the hand around things that it has not touched yet: they stand where a scenario says that they do."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ichain_drake.motion_query import MotionQuery
from ichain_drake.robot import MotionPlanner
from ichain_drake.state import FloatArray


class StandingMotion:
    """A motion planner that also knows where free bodies stand until the hand brings them elsewhere.

    It remembers nothing: a body that is neither held nor was put down is taken to stand where it did at first.

    Args:
        planner: lays out the ways.
        standing: hand state, shape (n_exposed,), in which a hand would let go of each body where it stands at first, by
            object name.
    """

    def __init__(self, planner: MotionPlanner, standing: Mapping[str, FloatArray]) -> None:
        self.planner = planner
        self._standing = {n: np.array(v, dtype=float) for n, v in standing.items()}

    def path(self, query: MotionQuery) -> FloatArray:
        """See `MotionPlanner.path`."""
        standing = {n: v for n, v in self._standing.items() if n != query.held}
        return self.planner.path(replace(query, left={**standing, **query.left}))
