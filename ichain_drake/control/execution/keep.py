"""Keeping hold of an object: the robot goes to where it holds it, and stays there while another one acts."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ichain_drake.control.execution.course import Course
from ichain_drake.control.execution.tasks import DONE, Answer, Failed, Mode, Task, View
from ichain_drake.learning.settings import LEARNING
from ichain_drake.state import FloatArray


@dataclass(eq=False)
class Keep(Task):
    """Bring the robot, with what it has taken, to the state in which it keeps hold of it.

    Attributes:
        goal: of the robot, shape (n_root,).
    """

    goal: FloatArray = field(default_factory=lambda: np.zeros(0))
    course: Course = field(default_factory=Course)
    there: bool = False
    looks: int = 0

    mode = Mode.CARRY

    def act(self, view: View) -> Answer:
        """See `Task`."""
        assert self.edge is not None
        if not self.there:
            command, self.there = view.travel(self.course, self.goal, self.edge.child)
            return command
        self.looks += 1
        if self.looks <= LEARNING.ticks:
            return view.command.copy()
        if view.monitors and not view.is_active(self.edge, LEARNING.ticks):
            return Failed(self.edge, "lost", f"{self.edge.name} became inactive before {self.edge.child} was in place")
        return DONE
