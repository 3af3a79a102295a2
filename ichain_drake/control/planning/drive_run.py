"""Prediction of many drives at once, the robot held still: one row costs as much as a hundred."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ichain_drake.control.planning.drive_option import DriveOption
from ichain_drake.control.planning.model import Batch, keeps, span, stack, take
from ichain_drake.control.planning.plan import States
from ichain_drake.control.planning.stops import Stop
from ichain_drake.control.settings import PLANNING
from ichain_drake.graph import Interaction
from ichain_drake.learning.model import InteractionModel
from ichain_drake.state import BoolArray, FloatArray, IntArray


class Run:
    """One batch of drives with the robot held still.

    Args:
        model: the learned graph.
        rows: start states with the robot away, and the drive.
        parked: state of the robot in which it acts on nothing, shape (n_root,).
    """

    window = PLANNING.window

    def __init__(self, model: InteractionModel, rows: Sequence[tuple[States, DriveOption]], parked: FloatArray) -> None:
        self.model, self.rows, self.parked = model, rows, parked
        self.drives = [d for _, d in rows]
        self.root = model.graph.root
        self.n = len(rows)
        self.hold = np.array([d.hold[self.root] for d in self.drives])
        self.first = np.array([d.before[self.root] for d in self.drives])
        limit = np.maximum(model.step_limit[self.root], 1e-9)
        self.ramp = np.ceil(np.max(np.abs(self.hold - self.first) / limit, axis=1) - 1e-6).astype(int)
        self.start = stack([s for s, _ in rows])
        self.now = self._placed()
        self.history: list[Batch] = [self.now]
        self.ticks_at: list[IntArray] = [np.zeros(self.n, dtype=np.intp)]
        self.last = np.zeros(self.n, dtype=np.intp)  # step at which each row ended
        self.lost: list[Interaction | None] = [None] * self.n
        self.fixed = {n: ~keeps(model, n) for n in model.passive}
        self.rate = np.array([d.rate for d in self.drives])
        self.direction = np.array([d.direction for d in self.drives])

    def _placed(self) -> Batch:
        """Carried objects where the drive begins, the robot as in the sample."""
        now = {n: v.copy() for n, v in self.start.items()}
        now[self.root] = self.first.copy()
        for r, d in enumerate(self.drives):
            if d.carry is not None:
                obj, part = d.carry.edge.child, d.carry.follow
                now[obj][r, part] = d.before[obj][part]
        return now

    def value(self, batch: Batch) -> FloatArray:
        """The driven variables, shape (n,)."""
        return np.array([batch[d.chain[-1].child][r, d.variable] for r, d in enumerate(self.drives)])

    def drive(self) -> None:
        """Ramp the robot to the driving sample, then hold until nothing changes any more."""
        going = np.ones(self.n, dtype=bool)
        status: dict[Interaction, BoolArray] = {}
        values = [self.value(self.now)]
        begin = int(self.ramp.max()) + max(len(d.chain) for d in self.drives)
        for step in range(PLANNING.steps):
            hot = np.flatnonzero(going)
            root = self.robot(step)
            classify = step < begin or self.rechecks(step)
            forced = None if classify else {e: a[hot] for e, a in status.items()}
            ahead, found = self.model.step(take(self.now, hot), root[hot], forced, strict=False)
            if classify:
                status = {e: np.zeros(self.n, dtype=bool) for e in found}
                for e, a in found.items():
                    status[e][hot] = a
            leap = np.ones(self.n, dtype=np.intp)
            if step >= begin:
                leap[hot] = self.leap(take(self.now, hot), ahead)
            after = {n: v.copy() for n, v in self.now.items()}
            for n, v in ahead.items():
                after[n][hot] = v
                if n in self.fixed:
                    part = ~self.fixed[n]
                    delta = v[:, part] - self.now[n][hot][:, part]
                    after[n][np.ix_(hot, part)] = self.now[n][hot][:, part] + leap[hot, None] * delta
            self.now = after
            self.history.append(after)
            ticks = self.ticks_at[-1] + np.where(going, leap + self.pauses(), 0)
            self.ticks_at.append(ticks)
            values.append(self.value(after))
            self.last[going] = step + 1
            if step >= begin - 1 and classify:
                going &= self.check(status, step, begin)
            if step >= begin + 2:
                going &= self._moving(values, ticks, begin)
            if not going.any():
                break

    def robot(self, step: int) -> FloatArray:
        """State of the robot at the end of a step, shape (n, n_root)."""
        share = np.clip((step + 1) / np.maximum(self.ramp, 1), 0.0, 1.0)[:, None]
        return self.first + share * (self.hold - self.first)

    def rechecks(self, step: int) -> bool:
        """Whether interactions are classified anew in a step."""
        return step % PLANNING.probe == 0

    def pauses(self) -> IntArray | int:
        """Ticks that the robot needed in the last step beside the step's own, shape (n,)."""
        return 0

    def leap(self, before: Batch, after: Batch) -> IntArray:
        """How many ticks each row may take at once: while changes are small and no bound is near."""
        most = np.full(len(before[self.root]), float(2 * PLANNING.probe))
        for n in self.model.passive:
            part = np.flatnonzero(~self.fixed[n])
            delta = (after[n] - before[n])[:, part]
            size = np.maximum(np.abs(delta), 1e-12)
            most = np.minimum(most, (PLANNING.same * span(self.model, n)[part] / size).min(axis=1, initial=np.inf))
            space = self.model.graph.objects[n].observable
            room = np.where(delta > 0, space.upper[part] - before[n][:, part], before[n][:, part] - space.lower[part])
            moving = size > 1e-9
            most = np.minimum(most, np.where(moving, room / size, np.inf).min(axis=1, initial=np.inf))
        return np.maximum(most, 1.0).astype(np.intp)

    def check(self, status: dict[Interaction, BoolArray], step: int, begin: int) -> BoolArray:
        """Rows whose whole chain is active; the first inactive edge of the others is noted if they never drove."""
        out = np.ones(self.n, dtype=bool)
        for r, d in enumerate(self.drives):
            off = [e for e in d.chain if not status[e][r]]
            if off:
                out[r] = False
                if step == begin - 1 and self.lost[r] is None and self.last[r] == step + 1:
                    self.lost[r] = off[0]
        return out

    def _moving(self, values: list[FloatArray], ticks: IntArray, begin: int) -> BoolArray:
        """Rows whose driven variable still changes."""
        enough = np.array(self.ticks_at) <= ticks - self.window
        back = np.maximum(begin, enough.sum(axis=0) - 1)  # the last step that long ago, for ticks never run back
        each = np.arange(self.n)
        passed = ticks - np.array(self.ticks_at)[back, each]
        change = self.direction * (values[-1] - np.array(values)[back, each])
        return (passed < self.window) | (change > PLANNING.least * self.rate * passed)

    def undo(self, ends: Batch, stops: Sequence[Stop]) -> Batch:
        """Robot and carried objects back to where the drive began, then these to where they were before.

        Args:
            ends: states at the stops, shape (n_stops, n_variables) each: a drive that stops on the robot's way turns
                back from there.
            stops: where and when each drive stops.
        """
        pick = np.array([s.row for s in stops], dtype=np.intp)
        out = {n: v.copy() for n, v in ends.items()}
        away = np.minimum([s.step for s in stops], self.ramp[pick])
        for step in range(int(away.max(initial=0))):
            on = np.flatnonzero(away > step)
            share = ((step + 1) / away[on])[:, None]
            back = ends[self.root][on] + share * (self.first[pick[on]] - ends[self.root][on])
            now, _ = self.model.step(take(out, on), back, strict=False)
            for n, v in now.items():
                out[n][on] = v
        for k, r in enumerate(pick):
            carry = self.drives[r].carry
            if carry is not None:
                out[carry.edge.child][k, carry.follow] = self.start[carry.edge.child][r, carry.follow]
        return out
