"""Kinematics of an arm: the hand's pose, and damped least squares towards a pose."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import JacobianWrtVariable, ModelInstanceIndex

from ichain_drake.errors import InputError, UnreachableError
from ichain_drake.robot.pose import hand_pose, rotation_vector
from ichain_drake.robot.spec import RobotSpec
from ichain_drake.state import FloatArray, wrap_angle

# Singular values below this are damped (Nakamura & Hanafusa 1986: damping that grows towards a singularity).
_SINGULAR, _DAMPING = 0.06, 0.03
# Joint steps [rad] below this need no second Newton step: it would move the hand by less than a micrometre.
_STRAIGHT = 1e-3
_POSITION_TOLERANCE, _ANGLE_TOLERANCE = 1e-4, 1e-3


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
        self._endless = ~np.isfinite(self.lower) & ~np.isfinite(self.upper)
        self._gain = spec.posture_gain
        self.default = plant.GetPositions(self._context, self._instance)
        self._weights = _per_joint(spec.posture_weights or [1.0], self.size, "posture_weights")
        postures = [(math.cos(p.pitch), _per_joint(p.joints, self.size, "postures")) for p in spec.postures]
        postures = sorted(postures or [(1.0, self.default.copy())], key=lambda p: p[0])
        self._posture_levels = np.array([level for level, _ in postures])
        self._postures = np.stack([joints for _, joints in postures])
        axis = self._first_axis(joints[0])
        self._bearing_sign = round(axis) if abs(axis) > 0.99 else 0  # noqa: PLR2004 -- vertical, but for rounding
        self._base = joints[0].frame_on_parent().CalcPoseInWorld(self._context).translation()

    def _first_axis(self, joint: object) -> float:
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
        level = -pose.rotation().matrix()[2, 2]  # cos(pitch) at roll 0
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
            p = pose.translation() - self._base
            wanted[0] += self._bearing_sign * math.atan2(p[1], p[0])
        return wanted

    def _error(self, joints: FloatArray, target: FloatArray, position: FloatArray) -> FloatArray:
        pose = self.pose(joints)
        error = np.empty(6)
        error[:3] = rotation_vector(target @ pose.rotation().matrix().T)
        error[3:] = position - pose.translation()
        return error

    def step(self, joints: FloatArray, pose: RigidTransform, period: float) -> FloatArray:
        """Joint positions one period later on the way to a hand pose, within joint and speed limits.

        Two Newton steps with one Jacobian: the second removes the curvature of the first, so that the hand is at the
        pose to some micrometres where nothing limits it. The posture acts in the exact null space.

        Args:
            joints: shape (n_joints,).
            pose: wanted hand pose at the end of the period.
            period: [s].
        """
        target, position = pose.rotation().matrix(), pose.translation()
        error = self._error(joints, target, position)
        jacobian = self._plant.CalcJacobianSpatialVelocity(
            self._context, JacobianWrtVariable.kV, self._frame, (0.0, 0.0, 0.0), self._world, self._world
        )[:, self._columns]
        inverse, projector = _pseudoinverse(jacobian)
        limit = self.speed * period

        move = inverse @ error
        excess = float((np.abs(move) / limit).max())
        if excess > 1.0:
            move = move / excess
        else:
            wanted = self.posture(pose) - joints
            wanted[self._endless] = wrap_angle(wanted[self._endless])
            free = projector @ ((self._gain * period) * self._weights * wanted)
            total = float((np.abs(move + free) / limit).max())
            move = move + (free if total <= 1.0 else free * max(0.0, (1.0 - excess) / (total - excess + 1e-12)))
            if float(np.abs(move).max()) > _STRAIGHT:
                move = move + inverse @ self._error(self._clip(joints + move), target, position)
                move = move / max(1.0, float((np.abs(move) / limit).max()))
        return self._clip(joints + move)

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
                if moved < 1e-7:  # noqa: PLR2004
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


def _pseudoinverse(jacobian: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Damped pseudoinverse, shape (n, 6), and the projector on the exact null space, shape (n, n)."""
    n = jacobian.shape[1]
    if n >= len(jacobian):
        # Far from singularities no damping is needed, and a 6 x 6 inverse takes a third of the time of an SVD. The norm
        # of the inverse bounds the least singular value from below; it is infinite or NaN where there is none.
        square = jacobian @ jacobian.T
        square.flat[:: len(square) + 1] += 1e-12
        inner = np.linalg.inv(square)
        if math.sqrt((inner * inner).sum()) < 1.0 / _SINGULAR**2:
            inverse = jacobian.T @ inner
            projector = -inverse @ jacobian
            projector.flat[:: n + 1] += 1.0
            return inverse, projector
    u, s, vt = np.linalg.svd(jacobian, full_matrices=False)
    damping = np.where(s < _SINGULAR, _DAMPING**2 * (1.0 - (s / _SINGULAR) ** 2), 0.0)
    return (vt.T * (s / (s * s + damping))) @ u.T, np.eye(n) - vt.T @ vt


def _per_joint(values: list[float], size: int, name: str) -> FloatArray:
    if len(values) == 1:
        return np.full(size, float(values[0]))
    if len(values) != size:
        raise InputError(f"robot.{name}: {len(values)} values given, the arm has {size} joints; give one or {size}")
    return np.array(values, dtype=float)
