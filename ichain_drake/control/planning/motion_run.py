"""Prediction of many drives by motion at once: the robot goes where the motion says from what is predicted."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ichain_drake.control.planning.drive_option import DriveOption
from ichain_drake.control.planning.drive_run import Run
from ichain_drake.control.planning.holding import taken_as
from ichain_drake.control.planning.model import Batch
from ichain_drake.control.planning.plan import States
from ichain_drake.control.settings import PLANNING
from ichain_drake.graph import Interaction
from ichain_drake.learning.model import InteractionModel
from ichain_drake.state import BoolArray, FloatArray, IntArray


class MotionRun(Run):
    """One batch of drives by motion; arguments as of `Run`."""

    window = 2 * PLANNING.retake

    def __init__(self, model: InteractionModel, rows: Sequence[tuple[States, DriveOption]], parked: FloatArray) -> None:
        super().__init__(model, rows, parked)
        self.motions = [d.motion for d in self.drives if d.motion is not None]
        self.ends = [self.start[m.edge.child][r : r + 1] for r, m in enumerate(self.motions)]
        self.away = np.zeros(self.n, dtype=bool)
        self.paused = np.zeros(self.n, dtype=np.intp)
        for r, m in enumerate(self.motions):
            node, reachable = m.grasp(self.ends[r])
            self.first[r] = taken_as(model, m, int(node[0]), self.ends[r][0])
            if not reachable[0]:
                self.lost[r] = m.edge
        self.hold, self.ramp = self.first.copy(), np.zeros(self.n, dtype=int)
        self.now[self.root] = self.first.copy()

    def robot(self, step: int) -> FloatArray:
        """Along the motion; away for a step where the object is taken anew."""
        out = np.empty_like(self.first)
        self.paused = np.where(self.away, PLANNING.retake, 0)
        for r, m in enumerate(self.motions):
            child = self.now[m.edge.child][r : r + 1]
            if self.away[r]:  # it comes back with its hand open: nothing goes along on that way
                self.now[self.root][r] = taken_as(self.model, m, int(m.grasp(child)[0][0]), child[0])
            node = m.at(self.now[self.root][r : r + 1], child)
            self.away[r] = not self.away[r] and m.again[node[0]]
            out[r] = self.parked if self.away[r] else m.robot[m.onward[node[0]]]
        return out

    def rechecks(self, step: int) -> bool:
        """In every step: what the robot moves may be lost in each."""
        return True

    def pauses(self) -> IntArray | int:
        """See `Run`."""
        return self.paused

    def leap(self, before: Batch, after: Batch) -> IntArray:
        """One tick a step: the robot is somewhere else in each."""
        return np.ones(len(before[self.root]), dtype=np.intp)

    def check(self, status: dict[Interaction, BoolArray], step: int, begin: int) -> BoolArray:
        """Rows that go on: those whose object goes along; further interactions may begin on the way."""
        out = np.ones(self.n, dtype=bool)
        for r, m in enumerate(self.motions):
            if self.lost[r] is not None or not (status[m.edge][r] or self.away[r]):
                out[r] = False
                if step == begin - 1 and self.last[r] == step + 1:
                    self.lost[r] = m.edge
        return out
