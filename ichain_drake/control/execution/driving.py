"""Driving a variable through a chain of interactions until it is where it should be."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from ichain_drake.control.execution.course import Course
from ichain_drake.control.execution.tasks import DONE, Answer, Failed, Mode, Task, View
from ichain_drake.control.planning.frames import Frames
from ichain_drake.control.planning.plan import PlanStep
from ichain_drake.control.planning.travel import jumping
from ichain_drake.control.settings import EXECUTION, PLANNING
from ichain_drake.learning.model import InteractionModel
from ichain_drake.learning.settings import LEARNING
from ichain_drake.rules import enabled
from ichain_drake.state import BoolArray, FloatArray


@dataclass(eq=False)
class Approach(Task):
    """Bring what is carried to where it drives a variable; cut short where that is done on the way."""

    carry: Task | None = None
    drive: DriveTask | None = None

    mode = Mode.CARRY
    travels = True

    def act(self, view: View) -> Answer:
        """See `Task`."""
        assert self.carry is not None
        assert self.drive is not None
        if self.drive.finished or self.drive.over_on_the_way(view):
            return DONE
        return self.carry.act(view)


@dataclass(eq=False)
class DriveTask(Task):
    """Hold the robot, and what it carries, while a chain of interactions drives a variable, until that is done."""

    step: PlanStep | None = None
    goal: FloatArray | None = None
    history: FloatArray | None = None
    inactive: BoolArray | None = None
    arrived: bool = False
    pushed: bool = False
    course: Course = field(default_factory=Course)
    begun: FloatArray | None = None
    finished: bool = False

    mode = Mode.DRIVE

    def act(self, view: View) -> Answer:  # noqa: PLR0911, PLR0912 - one return a phase
        """See `Task`."""
        step = self.step
        assert step is not None
        assert step.until is not None
        if self.finished:
            return DONE
        if not self.arrived and self.goal is not None:
            command, self.arrived = view.travel(self.course, self.goal)
            return command
        model, chain = view.model, step.chain
        target, name, direction, value = step.until
        space = model.graph.objects[target].observable
        i = space.index(name)
        self.history = _with(self.history, view.readings[-1][target])
        now = view.averaged(2)
        self.inactive = _with(self.inactive, np.array([not view.holds(e) for e in chain]))
        if view.monitors:
            recent = self.inactive[-EXECUTION.corrected :].mean(axis=0)
            if len(self.inactive) >= EXECUTION.corrected and recent[0] >= LEARNING.kept:
                return Failed(chain[0], "lost", f"{chain[0].name} became inactive while it drove {target}.{name}")
            if len(self.inactive) in (PLANNING.probe, PLANNING.probe + 1) and (recent >= LEARNING.kept).any():
                edge = chain[int(np.argmax(recent))]
                if not self._moves(model, i, direction):
                    if self._further(view):
                        return view.command.copy()
                    return Failed(edge, "chain", f"{edge.name} is not active, so that {target}.{name} is not driven")
        if self._over(view, i, direction, value):
            return DONE
        if len(self.history) > 2 * (step.ticks + PLANNING.retake):
            if not view.monitors:
                return DONE
            return Failed(chain[-1], "drive", f"{target}.{name} is at {now[target][i]:.3g}, not yet at {value:.3g}")
        return view.command.copy()

    def _further(self, view: View) -> bool:
        """Where the first object does not follow as demonstrated, go to where it followed most; whether there is more.

        It is looked for among the demonstrated states in which the second interaction was active: a button that needs
        more force, say, is pressed as far as a person ever pressed it.
        """
        step, model = self.step, view.model
        assert step is not None
        if not enabled("push_further") or self.pushed or self.goal is None or len(step.chain) == 1:
            return False
        edge, samples = step.chain[0], model.edges[step.chain[1]].examples.active
        on = model.decide(edge, samples) >= 0.0
        driven = sorted({f.variable for f in model.edges[edge].effects})
        if not on.any() or not driven:
            return False
        values = samples[edge.child][on][:, driven]
        toward = np.sign(np.median(values, axis=0) - view.averaged()[edge.child][driven])
        width = np.maximum(model.high[edge.child] - model.low[edge.child], 1e-9)[driven]
        score = (toward * values / width).sum(axis=1)
        space = model.graph.objects[edge.parent].observable
        most_of, frames = np.flatnonzero(on)[score >= score.max() - PLANNING.same], Frames(model)
        root = samples[edge.parent][most_of]
        if frames.is_relative(edge):
            then, child = samples[edge.child][most_of], view.averaged()[edge.child]
            root = frames.along(edge.parent, root, edge.child, then, child)
        most = self.goal + np.mean(space.difference(root, self.goal), axis=0)
        self.goal = np.where(jumping(space), self.goal, most)
        self.pushed, self.arrived, self.history, self.inactive = True, False, None, None
        return True

    def _moves(self, model: InteractionModel, i: int, direction: int) -> bool:
        assert self.step is not None
        assert self.history is not None
        noise = model.noise[self.step.chain[-1].child][i]
        values = self.history[:, i]
        half = len(values) // 2
        return bool(direction * (values[half:].mean() - values[:half].mean()) > LEARNING.sure * noise)

    def _over(self, view: View, i: int, direction: int, value: float) -> bool:
        """All variables that the drive should change are where they should be, or have stopped changing."""
        step, model = self.step, view.model
        assert step is not None
        assert self.history is not None
        target = step.chain[-1].child
        noise = model.noise[target]
        seen, few = self.history, LEARNING.ticks
        start, now = seen[:2].mean(axis=0), seen[-few:].mean(axis=0)
        if len(seen) < LEARNING.look:
            return False
        if len(seen) >= 2 * few:  # a mean is as old as its middle; what is decided now begins to act in a tick
            rate = (now[i] - seen[-2 * few : -few, i].mean()) / few
            now[i] += (0.5 * (few - 1) + 1.0) * direction * max(0.0, direction * rate)
        beyond = direction * (now[i] - value)
        if beyond > max(LEARNING.clear * noise[i], EXECUTION.ahead * abs(value - start[i])):
            return True  # whatever the others do
        missing = self._missing(model, start, now)
        return all(self._stalled(seen[:, k], float(noise[k]), sign, change) for k, sign, change in missing)

    def _missing(self, model: InteractionModel, start: FloatArray, now: FloatArray) -> list[tuple[int, float, float]]:
        """Variables that are not yet where the drive should bring them: index, direction, and the whole way."""
        assert self.step is not None
        assert self.step.until is not None
        target, name, direction, value = self.step.until
        i = model.graph.objects[target].observable.index(name)
        noise, width = model.noise[target], model.high[target] - model.low[target]
        wanted = self.step.predicted[target].copy()
        wanted[i] = value
        kinds = model.passive[target].variables
        out = []
        for k in range(len(wanted)):
            change = float(wanted[k] - start[k])
            least = max(PLANNING.noises * noise[k], LEARNING.near * width[k])
            if k != i and (kinds[k].kind != "hold" or abs(change) < least):
                continue
            sign = float(direction if k == i else np.sign(change))
            there = max(EXECUTION.slack_noises * noise[k], EXECUTION.slack * width[k])
            slack = there if k == i else EXECUTION.value * abs(change)
            if sign * (now[k] - wanted[k]) < -slack:
                out.append((k, sign, abs(change)))
        return out

    def over_on_the_way(self, view: View) -> bool:
        """Whether all is where it should be before what is carried has been brought to where it drives: a fast pour."""
        if not enabled("over_on_the_way"):
            return False
        assert self.step is not None
        assert self.step.until is not None
        target = self.step.until[0]
        if self.begun is None:
            self.begun = view.averaged()[target]
        # What flows fast goes on while it is stopped: a tick ahead, where the change is more than noise.
        space, last = view.model.graph.objects[target].observable, view.readings[-1][target]
        rate = space.difference(last, view.readings[-2][target]) if len(view.readings) > 1 else np.zeros(len(space))
        fast = np.abs(rate) > LEARNING.clear * view.model.noise[target]
        ahead = np.where(fast, last + rate, view.averaged(2)[target])
        self.finished = not self._missing(view.model, self.begun, ahead)
        return self.finished

    def _stalled(self, values: FloatArray, noise: float, sign: float, change: float) -> bool:
        """Whether a variable has stopped: over windows so long that what it should do would be seen surely."""
        if not enabled("stalled"):
            return False
        assert self.step is not None
        rate = max(change / max(self.step.ticks, 1), 1e-9)
        # Means of two windows of w readings differ by chance by noise * sqrt(2 / w), by the rate by rate * w.
        enough = np.ceil((LEARNING.surely * np.sqrt(2.0) * noise / rate) ** (2.0 / 3.0))
        w = int(np.clip(enough, PLANNING.probe, 2 * PLANNING.retake))
        if len(values) < 2 * w + 2:
            return False
        return bool(sign * (values[-w:].mean() - values[-2 * w : -w].mean()) < LEARNING.slight * rate * w)


RowT = TypeVar("RowT", bound=np.generic)


def _with(rows: NDArray[RowT] | None, row: NDArray[RowT]) -> NDArray[RowT]:
    """Rows and one more, in an array of their own."""
    return row[None].copy() if rows is None else np.concatenate([rows, row[None]])
