"""Before the robot lets go of what it seems to have lost: whether it comes along on the way back.

What is held may be kept from following for a while, caught on something, or slide in the grasp. Let go of in the air it
would fall.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from ichain_drake.control.execution.following import goes_along
from ichain_drake.control.execution.tasks import DONE, Answer, Mode, Task, View
from ichain_drake.errors import UnreachableError


@dataclass(eq=False)
class TakeBack(Task):
    """Go back to where the child was taken, unless it clearly stays behind."""

    steps: list[Task] = field(default_factory=list)
    ticks: int = 0

    mode = Mode.CARRY

    def act(self, view: View) -> Answer:
        """See `Task`."""
        assert self.edge is not None
        along = goes_along(view.model, self.edge, view.readings, self.ticks)
        if along is False:
            return DONE
        self.followed, self.ticks = self.followed or along is True, self.ticks + 1
        unwatched = replace(view, monitors=False)
        while self.steps:
            try:
                answer = self.steps[0].act(unwatched)
            except UnreachableError:
                return DONE
            if isinstance(answer, np.ndarray):
                return answer
            if answer != DONE:
                return DONE
            self.steps.pop(0)
        return DONE
