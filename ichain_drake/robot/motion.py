"""The hand's motion within a tick: from a command at 3 Hz to set-points at 30 Hz."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike
from pydrake.systems.framework import BasicVector, Context, DiscreteValues, LeafSystem

from ichain_drake.robot.hand import GRIP, HAND, HandSpec
from ichain_drake.state import FloatArray, wrap_angle
from ichain_drake.timing import FRAME, FRAMES_PER_TICK

FRAME_RATE = 30
MOVE_FRAMES = 4
LINEAR_SPEED = 0.4
ANGULAR_SPEED = 2.0

_N = len(HAND)


class HandMotion(LeafSystem):
    """Plans the set-point of each 1/30 s frame.

    At every tenth frame, counted by an integer, the command is read and a straight line in the exposed variables is
    laid from the present set-point to it: over 4 frames, or over the least number that keeps to the speed limits. A
    line that takes longer than the tick is laid anew at the next one. Grip and everything that is held change with the
    first frame.

    Ports: input `hand_command` (n_exposed); outputs `setpoint` (7; the state, no feedthrough) and `plan`: the set-point
    at the end of the frame that begins (7), then the rest of the state that the frame's update will store. At the
    instant of a frame, before its update, `plan` is already that of the frame that begins, so whoever follows it has no
    lag; it is therefore a direct function of `hand_command`.

    Args:
        spec: which variables are commanded.
        home: full hand state at start, shape (7,).
        linear_speed: [m/s].
        angular_speed: of the vector of the three angles [rad/s].
    """

    def __init__(
        self,
        spec: HandSpec,
        home: ArrayLike,
        linear_speed: float = LINEAR_SPEED,
        angular_speed: float = ANGULAR_SPEED,
    ) -> None:
        super().__init__()
        self.spec = spec
        n = len(spec.space)
        self._n = n
        self._linear_speed, self._angular_speed = linear_speed, angular_speed
        home = np.asarray(home, dtype=float)
        # Groups: set-point of frame k; [k, frames done, frames of the line, start, target].
        self._setpoint_index = self.DeclareDiscreteState(home)
        exposed = spec.reduce(home)
        self._plan_index = self.DeclareDiscreteState(np.concatenate([[0.0, 0.0, 1.0], exposed, exposed]))
        self._command = self.DeclareVectorInputPort("hand_command", n)
        self.DeclareStateOutputPort("setpoint", self._setpoint_index)
        tickets = {self.xd_ticket(), self._command.ticket()}
        self._plan = self.DeclareVectorOutputPort("plan", _N + 3 + 2 * n, self._calc_plan, tickets)
        self.DeclarePeriodicDiscreteUpdateEvent(FRAME, 0.0, self._update)

    def set_hand(self, context: Context, full: ArrayLike) -> None:
        """Put the set-point at a full hand state, shape (7,), at rest; the frame counter follows the context's time."""
        value = np.asarray(full, dtype=float)
        exposed = self.spec.reduce(value)
        frame = math.ceil(context.get_time() * FRAME_RATE - 1e-6)
        context.SetDiscreteState(self._setpoint_index, value)
        context.SetDiscreteState(self._plan_index, np.concatenate([[frame, 0.0, 1.0], exposed, exposed]))

    def frame(self, context: Context) -> int:
        """The number of frames that have begun."""
        return int(context.get_discrete_state(self._plan_index).value()[0])

    def plan_frames(self, start: FloatArray, target: FloatArray) -> int:
        """Least number of frames, at least 4, from start to target (n_exposed,) within the speed limits."""
        count = MOVE_FRAMES
        difference = self.spec.space.difference(target, start)
        for _ in range(20):  # on a curved surface the steps are uneven: lengthen until the largest is small enough
            points = self.spec.full(start + np.arange(count + 1)[:, None] / count * difference)
            steps = np.diff(points, axis=0)
            length = math.sqrt((steps[:, :3] ** 2).sum(axis=1).max())
            turn = math.sqrt((wrap_angle(steps[:, 3:6]) ** 2).sum(axis=1).max())
            excess = FRAME_RATE * max(length / self._linear_speed, turn / self._angular_speed)
            if excess <= 1.0 + 1e-9:
                break
            count = max(count + 1, math.ceil(count * excess - 1e-9))
        return count

    def _calc_plan(self, context: Context, output: BasicVector) -> None:
        n, spec = self._n, self.spec
        discrete = context.get_discrete_state()
        plan = discrete.value(self._plan_index)
        frame, done, count = (int(v) for v in plan[:3].tolist())
        start, target = plan[3 : 3 + n], plan[3 + n :]
        following = np.empty(_N + 3 + 2 * n)
        if frame % FRAMES_PER_TICK == 0:
            command = spec.space.clip(spec.space.check(self._command.Eval(context), "hand command"))
            start, target, done = spec.reduce(discrete.value(self._setpoint_index)), command, 0
            count = self.plan_frames(start, target)
        if done < count:
            done += 1
            exposed = target if done == count else start + done / count * spec.space.difference(target, start)
            setpoint = spec.full(exposed)
            setpoint[3:6] = wrap_angle(setpoint[3:6])
            setpoint[GRIP] = round(spec.full(target)[GRIP])
            following[:_N] = setpoint
        else:  # it holds
            following[:_N] = discrete.value(self._setpoint_index)
        following[_N : _N + 3] = frame + 1, done, count
        following[_N + 3 : _N + 3 + n] = start
        following[_N + 3 + n :] = target
        output.SetFromVector(following)

    def _update(self, context: Context, discrete: DiscreteValues) -> None:
        following = self._plan.Eval(context)
        discrete.set_value(self._setpoint_index, following[:_N])
        discrete.set_value(self._plan_index, following[_N:])
