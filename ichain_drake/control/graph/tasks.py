"""What an execution consists of, tick by tick: its tasks, what they see, and switching an interaction.

Each task keeps its own memory and answers each tick with a robot command, with `DONE`, or with why it failed.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import IntEnum

import numpy as np

from ichain_drake.control.graph.course import Course, Motion
from ichain_drake.control.graph.model import GraphModel
from ichain_drake.control.graph.skills import Skills
from ichain_drake.control.graph.travel import corners, jumping, step_towards
from ichain_drake.errors import UnreachableError
from ichain_drake.graph import Interaction
from ichain_drake.state import FloatArray

DONE = "done"
LOOK_TICKS = 4
"""Ticks of averaging before planning and after a step."""


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
        vias: robot states in which nothing is switched.
        readings: measured states of the last ticks, the newest last.
        command: the last command, shape (n_root,).
        monitors: whether to watch.
        attempts: for a switching.
        motion: lays out ways of the robot; straight lines without.
        left: robot state in which each object that it carried was let go of, shape (n_root,).
    """

    model: GraphModel
    skills: Skills
    vias: list[FloatArray]
    readings: list[dict[str, FloatArray]]
    command: FloatArray
    monitors: bool = True
    attempts: int = 4
    motion: Motion | None = None
    left: Mapping[str, FloatArray] = field(default_factory=dict)

    def averaged(self, ticks: int = 3) -> dict[str, FloatArray]:
        """Measured states averaged over the last ticks; whole numbers by their median, the robot's is its command."""
        last = self.readings[-ticks:]
        out = {}
        for name in self.model.graph.objects:
            space = self.model.graph.objects[name].observable
            values = np.array([r[name] for r in last])
            mean = values[-1] + np.mean([space.difference(v, values[-1]) for v in values], axis=0)
            mean = np.where(jumping(space), np.round(np.median(values, axis=0)), mean)
            out[name] = space.clip(np.where(space.angle_mask, (mean + np.pi) % (2 * np.pi) - np.pi, mean))
        out[self.model.graph.root] = self.command.copy()
        return out

    def is_active(self, edge: Interaction, ticks: int = 2) -> bool:
        """Whether the classifier says active, by the mean of its decisions on the last readings."""
        return self.decision(edge, ticks) >= 0.0

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
        return course.towards(space, self.command, goal, limit, self.motion, held, self.left)


@dataclass(eq=False)
class Task:
    """Base of tasks; `edge` is the interaction they are about."""

    edge: Interaction | None

    mode = Mode.LOOK

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


@dataclass(eq=False)
class Switch(Task):
    """Activate or deactivate an interaction of the robot by a skill; retried with other events."""

    activate: bool = True
    attempt: int = 0
    path: list[FloatArray] | None = None
    wait: int = 0
    retreating: bool = False
    forced: bool = False
    far: int = 0  # states of the path before the demonstrated ones
    course: Course = field(default_factory=Course)

    @property
    def mode(self) -> Mode:  # type: ignore[override]
        """See `Mode`."""
        return Mode.ACTIVATE if self.activate and not self.retreating else Mode.DEACTIVATE

    def act(self, view: View) -> Answer:  # noqa: PLR0911 - one return a phase
        """See `Task`."""
        assert self.edge is not None
        if self.path is None:
            if not self.forced and view.is_active(self.edge) == self.activate:
                return DONE
            self.path = self._lay(view, self.activate)
        if self.path:
            self.wait = 2
            if self._taken(view):
                return DONE
            return self._go(view)
        if self.wait:
            self.wait -= 1
            if not (self.wait == 0 and not self.retreating):
                return view.command.copy()
        if self.retreating:
            self.retreating, self.path = False, self._lay(view, self.activate)
            return view.command.copy()
        if view.is_active(self.edge) == self.activate or (self.forced and not view.monitors):
            return DONE
        self.attempt += 1
        if self.attempt >= (view.attempts if view.monitors else 1):
            if not view.monitors:
                return DONE
            what = "active" if self.activate else "inactive"
            value = view.decision(self.edge)
            return Failed(
                self.edge,
                "activation" if self.activate else "deactivation",
                f"{self.edge.name} did not become {what} in {self.attempt} attempts; decision value {value:.2f}",
            )
        self.retreating = self.activate
        self.path = self._lay(view, False) if self.activate else self._lay(view, self.activate)
        return view.command.copy()

    def _taken(self, view: View) -> bool:
        """What is taken goes along from here on: its ways are laid out with it, not as it was once demonstrated."""
        if view.motion is None or not self.activate or self.retreating or self.far or not self.path:
            return False
        jumps = jumping(view.model.graph.objects[view.model.graph.root].observable)
        done = all((row[jumps] == view.command[jumps]).all() for row in self.path)
        return done and view.is_active(self.edge)  # type: ignore[arg-type]

    def _go(self, view: View) -> FloatArray:
        assert self.path
        try:  # what was demonstrated is gone as it was
            command, there = view.travel(self.course, self.path[0]) if self.far else view.towards(self.path[0])
        except UnreachableError:
            if self.attempt + 1 >= view.attempts:
                raise
            # Another event may begin where the robot can get to.
            self.attempt, self.path = self.attempt + 1, self._lay(view, self.activate)
            return view.command.copy()
        if there:
            self.path.pop(0)
            self.far, self.course = max(self.far - 1, 0), Course()
        return command

    def _lay(self, view: View, activate: bool) -> list[FloatArray]:
        assert self.edge is not None
        states = view.averaged()
        path = view.skills.path(view.model, self.edge, activate, states, self.attempt)
        self.far, self.course = 0, Course()
        if not activate:
            return list(path)
        way = corners(view.model, states, path[0], view.vias)
        self.far = len(way)
        return [*way, *path[1:]]
