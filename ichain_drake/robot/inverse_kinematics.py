"""Follows the hand's set-points with the arm's joints: one plan a tick, played frame by frame."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from pydrake.common.value import AbstractValue
from pydrake.systems.framework import BasicVector, Context, DiscreteValues

from ichain_drake.errors import InputError
from ichain_drake.robot.hand import GRIP, HAND, HandSpec
from ichain_drake.robot.kinematics import ArmKinematics
from ichain_drake.robot.motion import FRAME_RATE, HandMotion
from ichain_drake.robot.pose import hand_rotation
from ichain_drake.state import FloatArray, wrap_angle
from ichain_drake.timing import FRAME, FRAMES_PER_TICK

_N = len(HAND)

FRAME_MARK = AbstractValue.Make("")
"""What the hold that tells of frames holds; only that it is written matters."""

# Weightless and perfectly still, an arm has no momentum against which the plant's solver (SAP) can measure convergence,
# and after some seconds it raises "failed to converge" on rounding errors. Desired positions alternate by this much
# [rad]: with a metre of arm that is 10 nm, and a hundred times what is needed.
_DITHER = 1e-8

# A frame and a time are compared to this part of a frame.
_ROUNDING = 1e-6

# Free motion slower than this [rad/s] rests while the hand's set-point does.
_IDLE = 0.02


class InverseKinematics(HandMotion):
    """A hand's motion, and desired positions of the arm and fingers that follow it: on the line between set-points.

    Joints are found for the ends of each frame's 1 / rate periods; in between, positions are linear. The plant's
    implicit controller acts on the error at the *end* of its step, so what it is given at t is the desired position at
    t + plant_step: there is no lag by design. `Playout` (C++) hands a frame's plan to the plant step by step. All
    frames of a tick are planned when it begins, since nothing that happens in it changes them: in one go Python takes
    half the time that it takes frame by frame, with caches that the plant's step has filled.

    A frame's plan is due from the instant at which it begins until the discrete update of that instant; then
    `joint_plan` is zero. In between the plant reads it, and at a tick it is calculated with the command of the instant.
    What tells Drake's cache that a frame begins is the input `frame`, from an unrestricted update in C++, which comes
    before any discrete update of the same instant.

    At rest (the set-point has not moved for two frames, and the posture hardly pulls) the joints stay.

    It is one system with `HandMotion`, whose set-points it reads, because each one that runs in Python costs something
    on every step of the plant.

    Ports: those of `HandMotion`; an input `frame` of any value, that of a hold of one frame; and the outputs
    `joint_plan`: what each row of `Playout` changes by, (steps + 1) x (joints, fingers); and `tick_plan`: where the
    tick ends (joints; the last row of the playout; the speed of the free motion; whether the set-point stood still),
    then `joint_plan` of each of its frames.

    Args:
        spec, home, linear_speed, angular_speed: see `HandMotion`.
        kinematics: of the arm.
        joints: joint positions at start, shape (n_joints,).
        rate: updates in a second, 30 times a power of two.
        plant_step: [s].
        grip_positions: positions of the driven fingers when open and closed, shape (2, n_fingers).
        grip_speed: of each finger's desired position as the grip closes [m/s]: at once it would strike what it takes.
        closed: whether the gripper is closed at start.
    """

    def __init__(
        self,
        spec: HandSpec,
        home: ArrayLike,
        linear_speed: float,
        angular_speed: float,
        kinematics: ArmKinematics,
        joints: FloatArray,
        rate: int,
        plant_step: float,
        grip_positions: FloatArray,
        grip_speed: float,
        *,
        closed: bool,
    ) -> None:
        super().__init__(spec, home, linear_speed, angular_speed)
        ratio = rate // FRAME_RATE
        if rate % FRAME_RATE or ratio & (ratio - 1):
            raise InputError(f"robot.ik_rate: {rate} is not {FRAME_RATE} times a power of two (60 is usual)")
        self._kinematics = kinematics
        self._shares = [(i + 1) / ratio for i in range(ratio)]
        self._period = FRAME / ratio
        self.steps = round(FRAME / plant_step)
        self._grip = grip_positions
        # The last row is one step beyond the frame, and so the first of the next one.
        self._grip_reach = grip_speed * FRAME * np.arange(self.steps + 1)[:, None] / self.steps
        n = kinematics.size
        self._n, self.width = n, n + grip_positions.shape[1]
        self._weights = _interpolation(ratio, self.steps)
        dither = _alternation(self.steps)
        self._dithers = (-dither, dither)  # of even and odd frames
        self.rows = (self.steps + 1) * self.width

        # Frames begun (their parity counts); frames of the tick that are still to be played.
        self._mode = self.DeclareDiscreteState(2)
        self._end = self.DeclareDiscreteState(self._at_rest(joints, self._row(joints, closed)))  # of the planned frames
        self._frames = self.DeclareDiscreteState(FRAMES_PER_TICK * self.rows)
        tickets = {self.xd_ticket(), self._command.ticket()}
        size = n + self.width + 2 + FRAMES_PER_TICK * self.rows
        self._tick = self.DeclareVectorOutputPort("tick_plan", size, self._calc_tick, tickets)
        begins = self.DeclareAbstractInputPort("frame", FRAME_MARK).ticket()
        self.DeclareVectorOutputPort("joint_plan", self.rows, self._calc_plan, {*tickets, begins})

    def set_joints(self, context: Context, joints: FloatArray, *, closed: bool) -> FloatArray:
        """Start at rest at joint positions of shape (n_joints,).

        Returns:
            What every row of the playout must hold, shape (width,).
        """
        row = self._row(joints, closed)
        context.SetDiscreteState(self._mode, [0.0, 0.0])
        context.SetDiscreteState(self._end, self._at_rest(joints, row))
        return row

    def _row(self, joints: FloatArray, closed: bool) -> FloatArray:
        return np.concatenate([joints, self._grip[int(closed)]])

    def _at_rest(self, joints: FloatArray, row: FloatArray) -> FloatArray:
        return np.concatenate([joints, row, [0.0, 0.0]])

    def _calc_plan(self, context: Context, output: BasicVector) -> None:
        left = context.get_discrete_state(self._mode).value()[1]
        if self.frame(context) > context.get_time() * FRAME_RATE + _ROUNDING:  # it has begun, and its plan was read
            output.SetZero()
        elif left:
            frames = context.get_discrete_state(self._frames).value()
            output.SetFromVector(frames[len(frames) - int(left) * self.rows :][: self.rows])
        else:
            over = self.frame(context) % FRAMES_PER_TICK
            tick = self._tick.Eval(context)
            output.SetFromVector(tick[len(tick) - (FRAMES_PER_TICK - over) * self.rows :][: self.rows])

    def _calc_tick(self, context: Context, output: BasicVector) -> None:
        discrete = context.get_discrete_state()
        end = discrete.value(self._end)
        n, size = self._n, len(end)
        joints, held, (speed, rested) = end[:n], end[n:-2], end[-2:].tolist()
        parity = int(discrete.value(self._mode)[0])
        setpoint, points = discrete.value(self._setpoint_index), self._plan.Eval(context).reshape(-1, _N)
        over = self.frame(context) % FRAMES_PER_TICK
        tick = np.zeros(size + FRAMES_PER_TICK * self.rows)
        frames = tick[size:].reshape(FRAMES_PER_TICK, self.steps + 1, self.width)
        for place in range(over, FRAMES_PER_TICK):
            still = setpoint[:6].tolist() == points[place, :6].tolist()
            rows = frames[place]
            if still and rested and speed < _IDLE:
                rows[:, :n] = joints
            else:
                path, speed = self._kinematics.follow(joints, self._targets(setpoint, points[place]), self._period)
                rows[:, :n] = self._weights @ np.array([joints, *path])
                joints = path[-1]
            if points[place, GRIP] > 0.5:
                fingers, reach = held[n:], self._grip_reach
                rows[:, n:] = fingers + np.minimum(np.maximum(self._grip[1] - fingers, -reach), reach)
            else:  # it strikes nothing
                rows[:, n:] = self._grip[0]
            rows[:, :n] += self._dithers[(parity + place - over) % 2]
            rows -= held
            held = held + rows[-1]  # the sum that the playout makes, so that both agree to the last bit
            setpoint, rested = points[place], float(still)
        tick[:size] = np.concatenate([joints, held, [speed, rested]])
        output.SetFromVector(tick)

    def _targets(self, start: FloatArray, end: FloatArray) -> list[tuple[FloatArray, FloatArray]]:
        """Rotation and position of the hand at the end of each period."""
        way = end - start
        turn = way[3:6]
        if not turn.any():
            rotation = hand_rotation(*end[3:6].tolist())
            return [(rotation, end[:3] if share == 1.0 else start[:3] + share * way[:3]) for share in self._shares]
        angles = [(start[3:6] + share * wrap_angle(turn)).tolist() for share in self._shares]
        return [(hand_rotation(*a), start[:3] + share * way[:3]) for a, share in zip(angles, self._shares, strict=True)]

    def _update(self, context: Context, discrete: DiscreteValues) -> None:
        super()._update(context, discrete)
        mode = discrete.get_mutable_value(self._mode)
        left = mode[1]
        if not left:
            tick = self._tick.Eval(context)
            size = len(tick) - FRAMES_PER_TICK * self.rows
            discrete.set_value(self._end, tick[:size])
            discrete.set_value(self._frames, tick[size:])
            left = FRAMES_PER_TICK - self.frame(context) % FRAMES_PER_TICK
        mode[0] += 1.0
        mode[1] = left - 1.0


def _interpolation(periods: int, steps: int) -> FloatArray:
    """Weights of joints at the ends of the periods (and the start) in the rows of a frame, (steps + 1, periods + 1).

    The last row goes on at the last period's velocity: what the plant sees at the frame's end until the next plan.
    """
    grid = np.arange(periods + 1) / periods
    times = np.arange(1, steps + 1) / steps
    weights = np.stack([np.interp(times, grid, column) for column in np.eye(periods + 1)], axis=1)
    beyond = np.zeros(periods + 1)
    beyond[-2:] = [-periods / steps, 1.0 + periods / steps]
    return np.vstack([weights, beyond])


def _alternation(steps: int) -> FloatArray:
    """Offsets of a frame's rows that alternate within the frame, or from frame to frame if it has one step only."""
    sign = np.ones(steps + 1)
    sign[steps // 2 : steps] = -1.0 if steps > 1 else 1.0
    return _DITHER * sign[:, None]
