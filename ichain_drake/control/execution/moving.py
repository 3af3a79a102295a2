"""Driving a variable by a motion of the robot, under feedback, until it is where it should be."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ichain_drake.control.execution.switching import Switch
from ichain_drake.control.execution.tasks import DONE, Answer, Failed, Mode, Task, View
from ichain_drake.control.planning.plan import PlanStep
from ichain_drake.control.planning.travel import jumping
from ichain_drake.control.settings import EXECUTION, PLANNING
from ichain_drake.control.tracking.offset import OffsetEstimate
from ichain_drake.learning.settings import LEARNING
from ichain_drake.state import FloatArray


@dataclass(eq=False)
class Moving(Task):
    """Follow a motion from wherever robot and object are, and let go and take the object anew where it says so.

    The last step is as long as the models say that the rest needs, with their lasting error (a gear's play, a rope's
    stretch) estimated on the way, as path control does it.
    """

    step: PlanStep | None = None
    retaking: list[Switch] = field(default_factory=list)
    inactive: list[bool] = field(default_factory=list)
    ticks: int = 0
    looks: int = 0
    foreseen: float | None = None  # value of the driven variable a tick later
    errors: FloatArray | None = None  # memory of the estimate of the models' error
    best: float = np.inf  # least that was left to do
    since: int = 0  # tick of that

    mode = Mode.DRIVE

    def act(self, view: View) -> Answer:  # noqa: PLR0911 - one return an outcome
        """See `Task`."""
        step, edge = self.step, self.edge
        assert step is not None
        assert step.until is not None
        assert step.motion is not None
        assert edge is not None
        while self.retaking:
            answer = self.retaking[0].act(view)
            if not isinstance(answer, str):
                return answer
            self.retaking.pop(0)
            self.foreseen, self.inactive = None, []
        target, name, direction, value = step.until
        space = view.model.graph.objects[target].observable
        i, self.ticks = space.index(name), self.ticks + 1
        noise = float(view.model.noise[target][i])
        width = float(view.model.high[target][i] - view.model.low[target][i])
        slack = max(EXECUTION.slack_noises * noise, EXECUTION.slack * width)
        self.inactive.append(not view.holds(edge))
        if view.monitors and sum(self.inactive[-(LEARNING.look + 1) :]) >= LEARNING.look:
            return Failed(edge, "lost", f"{edge.name} became inactive while it drove {target}.{name}")
        now = view.averaged(LEARNING.ticks if self.looks else 1)
        rest = direction * (value - float(now[target][i]))
        if rest <= slack:
            self.looks, self.foreseen = self.looks + 1, None
            return DONE if self.looks > LEARNING.ticks else view.command.copy()
        self.looks = 0
        if rest < self.best - slack:
            self.best, self.since = rest, self.ticks
        if self.ticks > 2 * (step.ticks + PLANNING.retake) or self.ticks - self.since > 2 * PLANNING.retake:
            return self._short(view, f"{target}.{name} is at {now[target][i]:.3g}, not yet at {value:.3g}")
        return self._move(view, now, rest)

    def _short(self, view: View, text: str) -> Answer:
        assert self.step is not None
        return Failed(self.step.chain[-1], "drive", text) if view.monitors else DONE

    def _move(self, view: View, now: dict[str, FloatArray], rest: float) -> Answer:
        """One tick along the motion, shorter where less is left."""
        step, model = self.step, view.model
        assert step is not None
        assert step.until is not None
        assert step.motion is not None
        motion, edge = step.motion, step.motion.edge
        target, name, direction, value = step.until
        i = model.graph.objects[target].observable.index(name)
        root, child = model.graph.objects[edge.parent].observable, now[edge.child][None]
        node = int(motion.at(view.command[None], child)[0])
        if motion.again[node]:
            self.retaking = [Switch(edge, activate=False, motion=motion), Switch(edge, activate=True, motion=motion)]
            return view.command.copy()
        ahead = int(motion.onward[node])
        if ahead == node:
            return self._short(view, f"{target}.{name} is at {now[target][i]:.3g}; no motion brings it to {value:.3g}")
        way = np.where(jumping(root), 0.0, root.difference(motion.robot[ahead], view.command))
        after, _ = model.step(now, view.command + way, strict=False)
        change = direction * float(after[target][i] - now[target][i]) + self._error(view, direction, i)
        share = 1.0 if change <= rest else rest / change
        self.foreseen = float(now[target][i]) + direction * share * (change - self._error_now(direction))
        return np.asarray(view.command + share * way)

    def _error(self, view: View, direction: int, i: int) -> float:
        """What the driven variable changes more than the models say, in the drive's direction."""
        assert self.step is not None
        assert self.step.until is not None
        estimate = OffsetEstimate(1)
        if self.errors is None:
            self.errors = np.zeros((1, estimate.memory_size))
        if self.foreseen is not None:
            seen = float(view.readings[-1][self.step.until[0]][i])
            self.errors = estimate.update(self.errors, np.array([[seen - self.foreseen]]))
        return self._error_now(direction)

    def _error_now(self, direction: int) -> float:
        assert self.errors is not None
        return direction * float(OffsetEstimate(1).offsets(self.errors, 1)[0, 0, 0])
