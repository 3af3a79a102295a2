"""Follows the hand's set-points with the arm's joints."""

from __future__ import annotations

import numpy as np
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.systems.framework import BasicVector, Context, DiscreteValues, LeafSystem

from ichain_drake.errors import InputError
from ichain_drake.robot.hand import GRIP, HAND
from ichain_drake.robot.kinematics import ArmKinematics
from ichain_drake.robot.motion import FRAME_RATE
from ichain_drake.robot.pose import hand_rotation
from ichain_drake.state import FloatArray, wrap_angle

_N = len(HAND)

# Weightless and perfectly still, an arm has no momentum against which the plant's solver (SAP) can measure convergence,
# and after some seconds it raises "failed to converge" on rounding errors. Desired positions alternate by this much
# [rad]: with a metre of arm that is 10 nm, and a hundred times what is needed.
_DITHER = 1e-8


class InverseKinematics(LeafSystem):
    """Desired joint state of arm and gripper, so that the hand is on the line between set-points at every time.

    At update k (at k / rate) the joints for the time of update k + 1 are found. In between, `desired` is linear.
    The plant's implicit controller acts on the error at the *end* of its step, so what it is given at t is the desired
    state at t + plant_step, with the velocity as feed-forward: there is no lag by design.

    Ports: input `segment` (14, from `HandMotion`); output `desired` ([q; v] of the arm, then [q; v] of the driven
    fingers; one port, since every call into Python costs the plant's step some microseconds).

    Args:
        kinematics: of the arm.
        joints: joint positions at start, shape (n_joints,).
        rate: updates in a second, 30 times a power of two.
        plant_step: [s].
        grip_positions: positions of the driven fingers when open and closed, shape (2, n_fingers).
    """

    def __init__(
        self,
        kinematics: ArmKinematics,
        joints: FloatArray,
        rate: int,
        plant_step: float,
        grip_positions: FloatArray,
    ) -> None:
        super().__init__()
        ratio = rate // FRAME_RATE
        if rate % FRAME_RATE or ratio & (ratio - 1):
            # Only then do both clocks agree bit by bit.
            raise InputError(f"robot.ik_rate: {rate} is not {FRAME_RATE} times a power of two (60 is usual)")
        self._kinematics = kinematics
        self._rate, self._per_frame = rate, ratio
        self._period, self._lead = 1.0 / rate, plant_step
        self._grip = np.concatenate([grip_positions, np.zeros_like(grip_positions)], axis=1)  # at rest: [q; 0]
        n = kinematics.size
        self._n = n
        self._before_index = self.DeclareDiscreteState(joints)  # at the last update's time
        self._after_index = self.DeclareDiscreteState(joints)  # one period later
        self._count_index = self.DeclareDiscreteState(1)
        self._segment = self.DeclareVectorInputPort("segment", 2 * _N)
        tickets = {self.xd_ticket(), self._segment.ticket()}
        self._next = self.DeclareVectorOutputPort("next", n, self._calc_next, tickets)
        self.DeclareVectorOutputPort(
            "desired", 2 * n + self._grip.shape[1], self._calc_desired, {self.time_ticket(), *tickets}
        )
        self.DeclarePeriodicDiscreteUpdateEvent(self._period, 0.0, self._update)

    def set_joints(self, context: Context, joints: FloatArray) -> None:
        """Start at rest at joint positions of shape (n_joints,); the counter follows the context's time."""
        context.SetDiscreteState(self._before_index, joints)
        context.SetDiscreteState(self._after_index, joints)
        context.SetDiscreteState(self._count_index, [np.ceil(context.get_time() * self._rate - 1e-6)])

    def _calc_next(self, context: Context, output: BasicVector) -> None:
        segment = self._segment.Eval(context)
        count = int(context.get_discrete_state(self._count_index).value()[0])
        share = (count % self._per_frame + 1) / self._per_frame
        start, end = segment[:_N], segment[_N:]
        full = end if share == 1.0 else start + share * (end - start)
        angles = full[3:6] if share == 1.0 else start[3:6] + share * wrap_angle(end[3:6] - start[3:6])
        pose = RigidTransform(RotationMatrix(hand_rotation(*angles)), full[:3])
        joints = context.get_discrete_state(self._after_index).value()
        output.SetFromVector(self._kinematics.step(joints, pose, self._period))

    def _calc_desired(self, context: Context, output: BasicVector) -> None:
        discrete = context.get_discrete_state()
        count = int(discrete.get_value(self._count_index)[0])
        begin = count * self._period
        after = discrete.get_value(self._after_index)
        time = context.get_time()
        if time >= begin - 1e-9:  # this instant's update is still to come: look ahead at its result
            before, after = after, self._next.Eval(context)
        else:
            before, begin = discrete.get_value(self._before_index), begin - self._period
        velocity = (after - before) * self._rate
        closed = self._segment.Eval(context)[_N + GRIP] > 0.5  # noqa: PLR2004
        position = before + (time + self._lead - begin) * velocity
        position += _DITHER if count % 2 else -_DITHER
        output.SetFromVector(np.concatenate([position, velocity, self._grip[int(closed)]]))

    def _update(self, context: Context, discrete: DiscreteValues) -> None:
        following = self._next.Eval(context)
        discrete.set_value(self._before_index, context.get_discrete_state(self._after_index).value().copy())
        discrete.set_value(self._after_index, following)
        discrete.set_value(self._count_index, [context.get_discrete_state(self._count_index).value()[0] + 1.0])
