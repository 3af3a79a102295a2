"""An option that drives a variable through a chain of interactions, and where it can be done now."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from ichain_drake.control.planning.carries import CarryOption
from ichain_drake.control.planning.frames import Frames
from ichain_drake.control.planning.model import Batch, row
from ichain_drake.control.planning.motion import Motion
from ichain_drake.control.planning.plan import States
from ichain_drake.graph import Interaction
from ichain_drake.state import FloatArray


@dataclass(frozen=True, eq=False)
class DriveOption:
    """A chain of interactions through which a variable of its last object is driven.

    Attributes:
        chain: from the robot to the object.
        variable: index of the driven variable.
        direction: +1 or -1.
        rate: fastest change in a tick that is predicted for a sample, in the variable's unit.
        carry: how the first object is carried, where it follows the robot; else None.
        hold: sample of all states while the variable is driven.
        before: sample of all states with the chain active, but the variable quiet; equals `hold` where none is needed.
        motion: of the robot, by which the variable is driven; None where it holds still.
        anchor: object that the samples are relative to; None where they hold as they are.
        others: further samples of all states that drive it as well, the surest first, shape (n, n_variables) each.
    """

    chain: tuple[Interaction, ...]
    variable: int
    direction: int
    rate: float
    carry: CarryOption | None
    hold: Batch
    before: Batch
    motion: Motion | None = None
    anchor: str | None = None
    others: Batch = field(default_factory=dict)

    def placed(self, frames: Frames, states: States) -> DriveOption | None:
        """The same where the object is now that its samples are relative to: the surest that is within reach there.

        Args:
            frames: of the learned graph.
            states: now, shape (n_variables,) each.

        Returns:
            None if none of its samples is.
        """
        if self.anchor is None:
            return self
        first = self.chain[0].child if self.carry is not None else None
        hold, before, others = (
            beside(frames, sample, self.chain[0].parent, first, self.anchor, states[self.anchor])
            for sample in (self.hold, self.before, self.others)
        )
        every = {n: np.concatenate([hold[n][None], v]) for n, v in others.items()}
        robot = self.chain[0].parent
        usable = frames.in_reach(robot, every[robot])
        if first is not None:
            there, shown = frames.in_reach(first, every[first]), frames.is_shown(first, every[first])
            usable &= there
            if not usable.any():  # how it will be held is not known to the millimetre
                usable = there & frames.in_reach(robot, every[robot], nearly=True)
            if (usable & shown).any():
                usable &= shown
        if not usable.any():
            return None
        best = int(np.argmax(usable))
        return replace(self, hold=row(every, best), before=before if best == 0 else row(every, best))


def beside(frames: Frames, sample: Batch, root: str, carried: str | None, anchor: str, now: FloatArray) -> Batch:
    """A sample of all states with the robot, and what it carries, where they are relative to something now.

    Args:
        frames: of the learned graph.
        sample: shape (..., n_variables) each.
        root: the robot.
        carried: what goes along with it, if anything does.
        anchor: what they are relative to.
        now: its state now, shape (..., n_anchor).
    """
    out, by, then = dict(sample), anchor, sample[anchor]
    out[anchor] = np.broadcast_to(now, then.shape).copy()
    if carried is not None:
        out[carried] = frames.along(carried, sample[carried], anchor, then, now)
        by, then, now = carried, sample[carried], out[carried]
    out[root] = frames.along(root, sample[root], by, then, now)
    return out
