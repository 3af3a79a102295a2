"""Kinematics of an arm: the hand's pose, and damped least squares towards a pose."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import JacobianWrtVariable, ModelInstanceIndex
from scipy.linalg.lapack import dposv

from ichain_drake.errors import InputError, UnreachableError
from ichain_drake.robot.pose import hand_pose, rotation_vector
from ichain_drake.robot.spec import RobotSpec
from ichain_drake.state import FloatArray

# Singular values below this are damped (Nakamura & Hanafusa 1986: damping that grows towards a singularity).
_SINGULAR, _DAMPING = 0.06, 0.03
# Joint steps [rad] below this need no second Newton step: it would move the hand by less than a micrometre.
_STRAIGHT = 1e-3
_POSITION_TOLERANCE, _ANGLE_TOLERANCE = 1e-4, 1e-3
_ORIGIN = np.zeros(3)
_IDENTITY = np.eye(6, order="F")


@dataclass(frozen=True)
class HandError:
    """How far a hand pose is missed: position [m], angle [rad]."""

    position: float
    angle: float


class ArmKinematics:
    """Inverse kinematics of an arm of any number of revolute or prismatic joints.

    The free motion of an arm with more than six joints (or near a joint limit) is drawn to a posture that depends on
    the hand's pitch and bearing.

    Args:
        plant: a finalized plant that holds the arm; it is used through a context of its own.
        spec: names, postures, speed limits.

    Raises:
        InputError: if a joint has more than one degree of freedom, or a list in the spec has another length than the
            arm.
    """

    def __init__(self, plant: MultibodyPlant, spec: RobotSpec) -> None:
        self._plant = plant
        self._instance: ModelInstanceIndex = plant.GetModelInstanceByName(spec.arm)
        self._context = plant.CreateDefaultContext()
        owner = plant.GetModelInstanceByName(spec.gripper) if spec.gripper else self._instance
        if not plant.HasFrameNamed(spec.hand_frame, owner):
            raise InputError(f"robot.hand_frame: {plant.GetModelInstanceName(owner)} has no frame {spec.hand_frame!r}")
        self._frame = plant.GetFrameByName(spec.hand_frame, owner)
        self._world = plant.world_frame()
        self.size = plant.num_positions(self._instance)
        if plant.num_velocities(self._instance) != self.size:
            raise InputError(f"robot.arm: {spec.arm} isn't welded to the world or has a ball or free joint")
        joints = [plant.get_joint(j) for j in plant.GetJointIndices(self._instance)]
        joints = [j for j in joints if j.num_velocities()]
        self._columns = np.array([j.velocity_start() for j in joints])
        self.lower = np.concatenate([j.position_lower_limits() for j in joints])
        self.upper = np.concatenate([j.position_upper_limits() for j in joints])
        self.speed = spec.speed_scale * np.concatenate([j.velocity_upper_limits() for j in joints])
        endless = ~np.isfinite(self.lower) & ~np.isfinite(self.upper)
        self._turn, self._per_turn = 2 * math.pi * endless, endless / (2 * math.pi)
        self.default = plant.GetPositions(self._context, self._instance)
        self._pull = spec.posture_gain * _per_joint(spec.posture_weights or [1.0], self.size, "posture_weights")
        postures = [(math.cos(p.pitch), _per_joint(p.joints, self.size, "postures")) for p in spec.postures]
        postures = sorted(postures or [(1.0, self.default.copy())], key=lambda p: p[0])
        self._posture_levels = np.array([level for level, _ in postures])
        self._postures = np.stack([joints for _, joints in postures])
        axis = self._first_axis(joints[0])
        self._bearing_sign = round(axis) if abs(axis) > 0.99 else 0  # vertical, but for rounding
        self._base = joints[0].frame_on_parent().CalcPoseInWorld(self._context).translation()

    def _first_axis(self, joint: Any) -> float:
        if not hasattr(joint, "revolute_axis"):
            return 0.0
        rotation = joint.frame_on_parent().CalcRotationMatrixInWorld(self._context).matrix()
        return float((rotation @ joint.revolute_axis())[2])

    def pose(self, joints: FloatArray) -> RigidTransform:
        """Pose of the hand in the robot (world) frame at joint positions of shape (n_joints,)."""
        self._plant.SetPositions(self._context, self._instance, joints)
        return self._frame.CalcPoseInWorld(self._context)

    def posture(self, pose: RigidTransform) -> FloatArray:
        """Joint positions that the free motion is drawn to at a hand pose, shape (n_joints,)."""
        return self._posture(pose.rotation().matrix(), pose.translation())

    def _posture(self, rotation: FloatArray, position: FloatArray) -> FloatArray:
        level = -rotation[2, 2]  # cos(pitch) at roll 0
        levels, postures = self._posture_levels, self._postures
        if len(levels) == 1 or level <= levels[0]:
            wanted = postures[0].copy()
        elif level >= levels[-1]:
            wanted = postures[-1].copy()
        else:
            i = int(np.searchsorted(levels, level))
            share = (level - levels[i - 1]) / (levels[i] - levels[i - 1])
            wanted = (1.0 - share) * postures[i - 1] + share * postures[i]
        if self._bearing_sign:
            wanted[0] += self._bearing_sign * math.atan2(position[1] - self._base[1], position[0] - self._base[0])
        return wanted

    def _error(self, joints: FloatArray, target: FloatArray, position: FloatArray) -> FloatArray:
        pose = self.pose(joints).GetAsMatrix34()
        error = np.empty(6)
        error[:3] = rotation_vector(target @ pose[:, :3].T)
        error[3:] = position - pose[:, 3]
        return error

    def step(self, joints: FloatArray, pose: RigidTransform, period: float) -> FloatArray:
        """Joint positions one period later on the way to a hand pose, within joint and speed limits.

        Args:
            joints: shape (n_joints,).
            pose: wanted hand pose at the end of the period.
            period: [s].
        """
        return self.follow(joints, [(pose.rotation().matrix(), pose.translation())], period)[0][0]

    def follow(
        self, joints: FloatArray, targets: Sequence[tuple[FloatArray, FloatArray]], period: float
    ) -> tuple[list[FloatArray], float]:
        """Joint positions at the ends of a few short periods, within joint and speed limits.

        Two Newton steps a period, all with the Jacobian of the start: the second removes what the curvature leaves of
        the first, so that the hand is at the pose to some micrometres where nothing limits it. The posture acts in the
        exact null space.

        Args:
            joints: at the start, shape (n_joints,).
            targets: wanted rotation (3, 3) and position (3,) [m] of the hand at the end of each period.
            period: [s].

        Returns:
            The joint positions, shape (n_joints,) each, and the speed of the free motion [rad/s or m/s].
        """
        self._plant.SetPositions(self._context, self._instance, joints)
        jacobian = self._plant.CalcJacobianSpatialVelocity(
            self._context, JacobianWrtVariable.kV, self._frame, _ORIGIN, self._world, self._world
        )[:, self._columns]
        inverse, span = _pseudoinverse(jacobian)
        wanted = self._posture(*targets[-1]) - joints
        wanted -= self._turn * np.rint(wanted * self._per_turn)
        wanted *= self._pull
        free = wanted - span @ wanted
        speed = max(map(abs, free.tolist()))
        free = free * period
        limit = (self.speed * period).tolist()

        path = []
        for target, position in targets:
            move = inverse @ self._error(joints, target, position)
            excess = _excess(move, limit)
            if excess > 1.0:
                move = move / excess
            else:
                both = move + free
                total = _excess(both, limit)
                if total > 1.0:
                    both = move + free * max(0.0, (1.0 - excess) / (total - excess + 1e-12))
                move = both
                if max(map(abs, move.tolist())) > _STRAIGHT:
                    move = move + inverse @ self._error(self._clip(joints + move), target, position)
                    if (excess := _excess(move, limit)) > 1.0:
                        move = move / excess
            joints = self._clip(joints + move)
            path.append(joints)
        return path, speed

    def _clip(self, joints: FloatArray) -> FloatArray:
        return np.minimum(np.maximum(joints, self.lower), self.upper)  # a third of the time of np.clip

    def miss(self, joints: FloatArray, pose: RigidTransform) -> HandError:
        """How far the hand at these joint positions is from a pose."""
        error = self._error(joints, pose.rotation().matrix(), pose.translation())
        return HandError(float(np.linalg.norm(error[3:])), float(np.linalg.norm(error[:3])))

    def solve(self, full: FloatArray, start: FloatArray | None = None) -> FloatArray:
        """Joint positions that bring the hand to a state.

        Args:
            full: hand state, shape (7,).
            start: joint positions to begin at, shape (n_joints,); default: the posture, then deterministic random ones.

        Raises:
            UnreachableError: if none is found; the message says how close it came.
        """
        pose = hand_pose(full)
        generator = np.random.default_rng(0)
        low = np.where(np.isfinite(self.lower), self.lower, -math.pi)
        high = np.where(np.isfinite(self.upper), self.upper, math.pi)
        best: HandError | None = None
        for attempt in range(12):
            joints = generator.uniform(low, high) if attempt else np.clip(self.posture(pose), self.lower, self.upper)
            if attempt == 0 and start is not None:
                joints = start
            for _ in range(200):
                following = self.step(joints, pose, 0.1)
                moved = float(np.abs(following - joints).max())
                joints = following
                if moved < 1e-7:
                    break
            error = self.miss(joints, pose)
            if error.position < _POSITION_TOLERANCE and error.angle < _ANGLE_TOLERANCE:
                return joints
            if best is None or error.position + 0.2 * error.angle < best.position + 0.2 * best.angle:
                best = error
        assert best is not None
        where = ", ".join(f"{v:.3f}" for v in full[:6])
        raise UnreachableError(
            f"the arm can't bring its hand to (x, y, z, yaw, pitch, roll) = ({where}): it comes within "
            f"{1000 * best.position:.0f} mm and {math.degrees(best.angle):.0f} deg; move the target or the arm's base"
        )


def _excess(move: FloatArray, limit: list[float]) -> float:
    """How many times the largest step its limit is; numpy takes several times as long for so few numbers."""
    return max([abs(m) / most for m, most in zip(move.tolist(), limit, strict=True)])


def _pseudoinverse(jacobian: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Damped pseudoinverse, shape (n, 6), and the projector on the row space, shape (n, n)."""
    if jacobian.shape[1] >= len(jacobian):
        # Far from singularities no damping is needed, and a Cholesky solution takes a tenth of the time of an SVD. The
        # norm of the inverse bounds the least singular value from below.
        square = jacobian @ jacobian.T
        square.flat[:: len(square) + 1] += 1e-12
        _, inner, failed = dposv(square, _IDENTITY)
        if not failed and math.sqrt(float(np.vdot(inner, inner))) < 1.0 / _SINGULAR**2:
            inverse = jacobian.T @ inner
            return inverse, inverse @ jacobian
    u, s, vt = np.linalg.svd(jacobian, full_matrices=False)
    damping = np.where(s < _SINGULAR, _DAMPING**2 * (1.0 - (s / _SINGULAR) ** 2), 0.0)
    return (vt.T * (s / (s * s + damping))) @ u.T, vt.T @ vt


def _per_joint(values: list[float], size: int, name: str) -> FloatArray:
    if len(values) == 1:
        return np.full(size, float(values[0]))
    if len(values) != size:
        raise InputError(f"robot.{name}: {len(values)} values given, the arm has {size} joints; give one or {size}")
    return np.array(values, dtype=float)
