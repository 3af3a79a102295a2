"""Bringing an object that follows the robot somewhere, by the learned inverse model under feedback (`move_to`)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ichain_drake.control.execution.course import Course
from ichain_drake.control.execution.following import goes_along
from ichain_drake.control.execution.tasks import DONE, Answer, Failed, Mode, Task, View
from ichain_drake.control.planning.plan import States
from ichain_drake.control.planning.slope import led
from ichain_drake.control.settings import EXECUTION, PLANNING
from ichain_drake.learning.settings import LEARNING
from ichain_drake.state import FloatArray


@dataclass(eq=False)
class CarryTask(Task):
    """Bring variables of an object that follows the robot to values, by the learned inverse model under feedback."""

    target: Mapping[int, float] = field(default_factory=dict)
    ticks: int = 0
    still: int = 0
    lost: int = 0
    stays: int = 0
    best: float = np.inf
    since: int = 0
    looked: bool = False
    ahead: FloatArray | None = None
    whole: bool = True  # whether `ahead` is the end of the way
    course: Course = field(default_factory=Course)

    mode = Mode.CARRY
    travels = True

    def act(self, view: View) -> Answer:
        """See `Task`."""
        assert self.edge is not None
        model, child = view.model, self.edge.child
        space = model.graph.objects[child].observable
        index = np.array(sorted(self.target), dtype=np.intp)
        goal = np.array([self.target[int(i)] for i in index])
        limit = np.maximum(model.step_limit[child][index], 1e-9)
        tolerance = np.maximum(LEARNING.clear * model.noise[child][index], PLANNING.same * limit)
        self.ticks += 1
        if view.monitors:
            lost = self._lost(view)
            if lost:
                return Failed(self.edge, "lost", f"{self.edge.name} {lost}")
        if self.still:  # near: look for some ticks before correcting
            self.still -= 1
            if self.still:
                return view.command.copy()
            now = view.averaged(3)
        else:
            now = view.averaged(1)
        error = self._error(space, goal, now[child], index)
        size = float(np.max(np.abs(error) / tolerance))
        if size < self.best - PLANNING.hardly or view.stopped:  # what is in the way is found out bit by bit
            self.best, self.since = size, self.ticks
        averaged = self.still == 0 and self.looked
        if size <= 1.0 and averaged:
            return DONE
        if self.ticks - self.since > PLANNING.retake:
            if size <= LEARNING.clear or not view.monitors:
                return DONE
            worst = int(index[np.argmax(np.abs(error) / tolerance)])
            return Failed(
                self.edge, "carry",
                f"{self.edge.name}: {child}.{space.names[worst]} stayed {np.abs(error).max():.3g} "
                f"{space.variables[worst].unit} off",
            )  # fmt: skip
        return self._onward(view, now, index, error, tolerance)

    def _onward(
        self, view: View, now: States, index: NDArray[np.intp], error: FloatArray, tolerance: FloatArray
    ) -> FloatArray:
        """A tick of the way, which is solved for as far as it is straight; what is seen corrects it now and then."""
        assert self.edge is not None
        root, child = self.edge.parent, self.edge.child
        if self.ahead is None or self.looked or self.ticks % EXECUTION.corrected == 0:
            wanted, slack = np.full((2, len(now[child])), np.nan)
            wanted[index], slack[index] = error, tolerance
            self.ahead, self.whole = led(view.model, self.edge, {**now, root: view.command}, wanted, slack)
        command, near = view.travel(self.course, self.ahead, child)
        if near and not self.whole:
            self.ahead = None
            return command
        self.looked = near
        self.still = 3 if near else 0
        return command

    def _lost(self, view: View) -> str:
        """What tells that the child no longer goes along, in words; empty if nothing does."""
        assert self.edge is not None
        self.lost = 0 if view.is_active(self.edge) else self.lost + 1
        along = goes_along(view.model, self.edge, view.readings, self.ticks - 1)
        self.stays = self.stays + 1 if along is False else 0
        if self.lost > LEARNING.ticks and not view.holds(self.edge):
            return f"became inactive while {self.edge.child} was carried"
        if self.stays > LEARNING.ticks:
            return f"was taken for active, but {self.edge.child} did not go along"
        return ""

    def _error(self, space: object, goal: FloatArray, state: FloatArray, index: np.ndarray) -> FloatArray:
        full = np.array(state, dtype=float)
        full[index] = goal
        return space.difference(full, state)[index]  # type: ignore[attr-defined]


@dataclass(eq=False)
class CarryPartTask(CarryTask):
    """Carry some variables while the others stay as they are when it begins."""

    every: tuple[int, ...] = ()

    def act(self, view: View) -> FloatArray | Failed | str:
        """See `Task`."""
        assert self.edge is not None
        if self.every:
            now = view.averaged()[self.edge.child]
            self.target = {i: self.target.get(i, float(now[i])) for i in self.every}
            self.every = ()
        return super().act(view)
