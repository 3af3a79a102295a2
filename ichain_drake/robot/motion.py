"""The hand's motion within a tick: from a command at 3 Hz to set-points at 30 Hz."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike
from pydrake.systems.framework import BasicVector, Context, DiscreteValues, LeafSystem

from ichain_drake.robot.hand import GRIP, HAND, HandSpec
from ichain_drake.state import FloatArray, IntArray, wrap_angle
from ichain_drake.timing import FRAME, FRAMES_PER_TICK

FRAME_RATE = 30
MOVE_FRAMES = 4
LINEAR_SPEED = 0.4
ANGULAR_SPEED = 2.0
_IN_TIME = 1.0 + 1e-9

_N = len(HAND)


class HandMotion(LeafSystem):
    """Plans the set-point of each 1/30 s frame.

    At every tenth frame, counted by an integer, the command is read and a straight line in the exposed variables is
    laid from the present set-point to it: over 4 frames, or over the least number that keeps to the speed limits. A
    line that takes longer than the tick is laid anew at the next one. Grip and everything that is held change with the
    first frame.

    Ports: input `hand_command` (n_exposed); outputs `setpoint` (7; the state, no feedthrough) and `plan`: the set-point
    at the end of each of the tick's ten frames (10 x 7). At the instant of a tick, before its update, `plan` is already
    that of the tick that begins, so whoever follows it has no lag; it is therefore a direct function of `hand_command`.

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
        self._linear_speed, self._angular_speed = linear_speed, angular_speed
        home = np.asarray(home, dtype=float)
        # Groups: set-point of frame k; k; set-points at the ends of the frames of the tick that k is in.
        self._setpoint_index = self.DeclareDiscreteState(home)
        self._frame_index = self.DeclareDiscreteState(1)
        self._tick_index = self.DeclareDiscreteState(_held(home))
        self._command = self.DeclareVectorInputPort("hand_command", len(spec.space))
        self.DeclareStateOutputPort("setpoint", self._setpoint_index)
        tickets = {self.xd_ticket(), self._command.ticket()}
        self._plan = self.DeclareVectorOutputPort("plan", FRAMES_PER_TICK * _N, self._calc_points, tickets)
        self.DeclarePeriodicDiscreteUpdateEvent(FRAME, 0.0, self._update)

    def set_hand(self, context: Context, full: ArrayLike) -> None:
        """Put the set-point at a full hand state, shape (7,), at rest; the frame counter follows the context's time."""
        value = np.asarray(full, dtype=float)
        context.SetDiscreteState(self._setpoint_index, value)
        context.SetDiscreteState(self._frame_index, [math.ceil(context.get_time() * FRAME_RATE - 1e-6)])
        context.SetDiscreteState(self._tick_index, _held(value))

    def frame(self, context: Context) -> int:
        """The number of frames that have begun."""
        return int(context.get_discrete_state(self._frame_index).value()[0])

    def plan_frames(self, start: FloatArray, target: FloatArray) -> IntArray:
        """Least number of frames, at least 4, within the speed limits.

        Args:
            start, target: exposed variables, shape (..., n_exposed).

        Returns:
            shape (...).
        """
        difference = self.spec.space.difference(target, start)
        count = np.full(start.shape[:-1], MOVE_FRAMES)
        for place in np.argwhere(self._excess(start, difference, MOVE_FRAMES) > _IN_TIME):
            row = tuple(place)
            count[row] = self._longer(start[row], difference[row])
        return count

    def _longer(self, start: FloatArray, difference: FloatArray) -> int:
        """`plan_frames` of one way that 4 frames are too few for."""
        count = MOVE_FRAMES
        for _ in range(20):  # on a curved surface the steps are uneven: lengthen until the largest is small enough
            excess = float(self._excess(start, difference, count))
            if excess <= _IN_TIME:
                break
            count = max(count + 1, math.ceil(count * excess - 1e-9))
        return count

    def _excess(self, start: FloatArray, difference: FloatArray, count: int) -> FloatArray:
        """How many times the speed limits the fastest of so many frames needs, shape (...)."""
        part = np.arange(count + 1).reshape(-1, *[1] * start.ndim) / count
        steps = np.diff(self.spec.full(start + part * difference), axis=0)
        length = np.sqrt((steps[..., :3] ** 2).sum(axis=-1).max(axis=0))
        turn = np.sqrt((wrap_angle(steps[..., 3:6]) ** 2).sum(axis=-1).max(axis=0))
        return FRAME_RATE * np.maximum(length / self._linear_speed, turn / self._angular_speed)

    def _calc_points(self, context: Context, output: BasicVector) -> None:
        if self.frame(context) % FRAMES_PER_TICK:
            output.SetFromVector(context.get_discrete_state(self._tick_index).value())
        else:
            now = context.get_discrete_state(self._setpoint_index).value()
            output.SetFromVector(self.lay(now, self._command.Eval(context)).ravel())

    def lay(self, now: FloatArray, command: FloatArray) -> FloatArray:
        """Set-points at the ends of the frames of a tick, shape (10, ..., 7).

        Args:
            now: set-points as the tick begins, shape (..., 7).
            command: hand commands, shape (..., n_exposed).

        Raises:
            InputError: on a command that is not finite.
        """
        spec = self.spec
        target = spec.space.clip(spec.space.check(command, "hand command"))
        start = spec.reduce(now)
        count = self.plan_frames(start, target)[..., None]
        done = np.minimum(np.arange(1, FRAMES_PER_TICK + 1).reshape(-1, *[1] * start.ndim), count)
        exposed = np.where(done == count, target, start + done / count * spec.space.difference(target, start))
        points = spec.full(exposed)
        points[..., 3:6] = wrap_angle(points[..., 3:6])
        points[..., GRIP] = np.rint(spec.full(target)[..., GRIP])
        return points

    def _update(self, context: Context, discrete: DiscreteValues) -> None:
        frame = discrete.get_mutable_value(self._frame_index)
        place = int(frame[0]) % FRAMES_PER_TICK
        if place:
            points = discrete.value(self._tick_index)
        else:
            points = self._plan.Eval(context)
            discrete.set_value(self._tick_index, points)
        discrete.set_value(self._setpoint_index, points[_N * place : _N * (place + 1)])
        frame[0] += 1.0


def _held(full: FloatArray) -> FloatArray:
    """The set-points of a tick in which the hand stays."""
    return np.tile(full, FRAMES_PER_TICK)
