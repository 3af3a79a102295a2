"""What an execution consists of, tick by tick: its tasks, and what they see.

Each task keeps its own memory and answers each tick with a robot command, with `DONE`, or with why it failed.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from ichain_drake.control.execution.course import Course, RobotMotion
from ichain_drake.control.planning.skills import Skills
from ichain_drake.control.planning.travel import jumping, step_towards
from ichain_drake.graph import Interaction
from ichain_drake.learning.model import InteractionModel
from ichain_drake.motion_query import MotionQuery
from ichain_drake.state import FloatArray

DONE = "done"


class Mode(IntEnum):
    """What the controller is at, as its port `mode` says it."""

    LOOK = 0
    DEACTIVATE = 1
    ACTIVATE = 2
    CARRY = 3
    DRIVE = 4
    REACHED = 5
    STOPPED = 6
    BLIND = 7


@dataclass(frozen=True)
class Failed:
    """Why a task can't go on.

    Attributes:
        edge: the interaction concerned.
        cause: one of a few words, for statistics.
        text: in words.
    """

    edge: Interaction
    cause: str
    text: str


Answer = FloatArray | Failed | str


@dataclass(eq=False)
class View:
    """What tasks see in a tick.

    Attributes:
        model: the learned graph.
        skills: of the robot's interactions.
        readings: measured states of the last ticks, the newest last.
        command: the last command, shape (n_root,).
        monitors: whether to watch.
        attempts: for a switching.
        motion: lays out ways of the robot; straight lines without.
        standing: makes the robot states in which each object that stands around was, or would be, let go of, shape
            (n_root,) each; asked when a way is laid out.
        follows: object that was seen to go along with the robot when that moved clearly last; empty if there is none.
        stopped: whether the robot was seen just now not to get on.
        news: how often it was, where it is; see `Course`.
        moved: how often something was seen elsewhere than before that the robot did not hold.
    """

    model: InteractionModel
    skills: Skills
    readings: list[dict[str, FloatArray]]
    command: FloatArray
    monitors: bool = True
    attempts: int = 4
    motion: RobotMotion | None = None
    standing: Callable[[], Mapping[str, FloatArray]] = dict
    follows: str = ""
    stopped: bool = False
    news: int = 0
    moved: int = 0

    def averaged(self, ticks: int = 3) -> dict[str, FloatArray]:
        """Measured states averaged over the last ticks; whole numbers by their median, the robot's is its command."""
        last = self.readings[-ticks:]
        out = {}
        for name in self.model.graph.objects:
            space = self.model.graph.objects[name].observable
            values = np.array([r[name] for r in last])
            mean = values[-1] + space.difference(values, values[-1]).sum(axis=0) / len(last)
            if (jumps := jumping(space)).any():
                mean[jumps] = np.round(np.median(values[:, jumps], axis=0))
            out[name] = space.clip(np.where(space.angle_mask, (mean + np.pi) % (2 * np.pi) - np.pi, mean))
        out[self.model.graph.root] = self.command.copy()
        return out

    def is_active(self, edge: Interaction, ticks: int = 2) -> bool:
        """Whether the classifier says active, by the mean of its decisions on the last readings."""
        return self.decision(edge, ticks) >= 0.0

    def holds(self, edge: Interaction) -> bool:
        """Whether an interaction is active by either witness: the classifier, or that the child goes along."""
        return self.is_active(edge) or (edge.parent == self.model.graph.root and edge.child == self.follows)

    def decision(self, edge: Interaction, ticks: int = 2) -> float:
        """Mean decision value of the last readings; each by itself, since the states may be moving."""
        last = self.readings[-ticks:]
        return float(np.mean(self.model.decide(edge, {n: np.array([r[n] for r in last]) for n in last[0]})))

    def towards(self, goal: FloatArray) -> tuple[FloatArray, bool]:
        """See `step_towards`."""
        root = self.model.graph.root
        return step_towards(self.model.graph.objects[root].observable, self.command, goal, self.model.step_limit[root])

    def travel(self, course: Course, goal: FloatArray, held: str | None = None) -> tuple[FloatArray, bool]:
        """See `Course.towards`."""
        root = self.model.graph.root
        space, limit = self.model.graph.objects[root].observable, self.model.step_limit[root]
        return course.towards(
            space, self.command, goal, limit, self.motion, held, self.standing, self.news + self.moved
        )

    def as_shown(self, rows: Sequence[FloatArray], taken: str | None) -> list[FloatArray]:
        """Commands that were shown, where they hit nothing; else another way to the last of them.

        Args:
            rows: shown from here on, shape (n_root,) each, n >= 1.
            taken: object that is taken in the last of them: it is where the robot will have it. None where they lead
                away from everything.

        Raises:
            UnreachableError: if there is no way.
        """
        space = self.model.graph.objects[self.model.graph.root].observable
        shown = np.array([space.clip(row) for row in rows])
        if self.motion is None:
            return list(shown)
        left = dict(self.standing()) | ({} if taken is None else {taken: shown[-1]})
        return list(self.motion.path(MotionQuery(self.command, shown[-1], None, left, shown, taken)))


@dataclass(eq=False)
class Task:
    """Base of tasks; `edge` is the interaction they are about.

    Attributes:
        followed: whether it saw the child go along with the parent, which was not known before.
        travels: whether the robot is on its way to somewhere, where nothing should stop it.
    """

    edge: Interaction | None

    mode = Mode.LOOK
    followed = False
    travels = False

    def act(self, view: View) -> Answer:
        """One tick."""
        raise NotImplementedError


@dataclass(eq=False)
class Look(Task):
    """Stay, so that readings can be averaged."""

    ticks: int = 3

    def act(self, view: View) -> Answer:
        """See `Task`."""
        if self.ticks <= 0:
            return DONE
        self.ticks -= 1
        return view.command.copy()
