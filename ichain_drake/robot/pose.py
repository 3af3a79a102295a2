"""The hand's seven variables as a pose, and back.

The hand's orientation is `R = Rz(yaw) Rx(roll) Ry(-pitch) diag(1, -1, -1)`: with pitch 0 it approaches downwards, with
pitch pi/2 forwards (+x), and roll then turns it about the approach axis, which pours.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike
from pydrake.math import RigidTransform, RotationMatrix

from ichain_drake.state import FloatArray, wrap_angle

# Below this |cos(roll)|, yaw and pitch turn about nearly the same axis and are told apart by `near` alone.
_SINGULAR_COSINE = 0.1


def hand_rotation(yaw: float, pitch: float, roll: float) -> FloatArray:
    """Rotation of the hand in the robot frame, shape (3, 3); angles [rad]."""
    cy, sy = math.cos(yaw), math.sin(yaw)
    cp, sp = math.cos(pitch), -math.sin(pitch)
    cr, sr = math.cos(roll), math.sin(roll)
    return np.array(
        [
            [cy * cp - sy * sr * sp, sy * cr, -(cy * sp + sy * sr * cp)],
            [sy * cp + cy * sr * sp, -cy * cr, -(sy * sp - cy * sr * cp)],
            [-cr * sp, -sr, -cr * cp],
        ]
    )


def hand_pose(full: ArrayLike) -> RigidTransform:
    """Pose of the hand in the robot frame.

    Args:
        full: hand state, shape (7,): x, y, z [m], yaw, pitch, roll [rad], grip.
    """
    value = np.asarray(full, dtype=float)
    return RigidTransform(RotationMatrix(hand_rotation(value[3], value[4], value[5])), value[:3])


def rotation_vector(rotation: FloatArray) -> FloatArray:
    """Axis times angle of a rotation matrix, shape (3,) [rad]."""
    (m00, m01, m02), (m10, m11, m12), (m20, m21, m22) = rotation.tolist()
    x, y, z = m21 - m12, m02 - m20, m10 - m01
    sine = 0.5 * math.sqrt(x * x + y * y + z * z)
    cosine = 0.5 * (m00 + m11 + m22 - 1.0)
    angle = math.atan2(sine, cosine)
    if sine > 1e-7 or cosine > 0.0:  # below it the axis is rounding noise
        share = 0.5 * angle / sine if sine > 1e-7 else 0.5
        return np.array([x * share, y * share, z * share])
    # Half a turn: the axis is the largest column of (R + I) / 2.
    column = 0.5 * (rotation + np.eye(3))
    best = column[:, int(np.argmax(np.diag(column)))]
    return best * (angle / np.linalg.norm(best))


def hand_values(pose: RigidTransform, grip: float, near: ArrayLike | None = None) -> FloatArray:
    """The hand state of a pose: the inverse of `hand_pose`.

    Two triples of angles make every orientation, and where |roll| is pi/2 infinitely many do. The one nearest to `near`
    is taken; close to the singularity the angles move from `near` only as far as the orientation demands.

    Args:
        pose: pose of the hand in the robot frame.
        grip: 1 closed, 0 open.
        near: hand state to stay close to, shape (7,); all angles zero if not given.

    Returns:
        shape (7,), angles wrapped to [-pi, pi).
    """
    rotation = pose.rotation().matrix()
    m = rotation * (1.0, -1.0, -1.0)
    guess = np.zeros(3) if near is None else np.asarray(near, dtype=float)[3:6]
    cosine = math.hypot(m[0, 1], m[1, 1])
    if cosine > _SINGULAR_COSINE:
        yaw, roll, pitch = math.atan2(-m[0, 1], m[1, 1]), math.atan2(m[2, 1], cosine), math.atan2(m[2, 0], m[2, 2])
        first = np.array([yaw, pitch, roll])
        other = np.array([yaw + math.pi, pitch + math.pi, math.pi - roll])
        gaps = [np.abs(wrap_angle(a - guess)).sum() for a in (first, other)]
        angles = first if gaps[0] <= gaps[1] else other
    else:
        angles = _follow(rotation, guess)
    out = np.empty(7)
    out[:3] = pose.translation()
    out[3:6] = wrap_angle(angles)
    out[6] = grip
    return out


def _follow(rotation: FloatArray, guess: FloatArray) -> FloatArray:
    """Angles of a rotation near |roll| = pi/2 by damped Gauss-Newton from a guess, shape (3,)."""
    yaw, pitch, roll = guess
    # The hand's free variables may be far off at first use (another branch): then start at the singular roll itself.
    if abs(math.cos(roll)) > 0.5:
        roll = math.copysign(math.pi / 2, -rotation[2, 1])
    for _ in range(20):
        error = rotation_vector(rotation @ hand_rotation(yaw, pitch, roll).T)
        if np.abs(error).max() < 1e-12:
            break
        cy, sy, cr, sr = math.cos(yaw), math.sin(yaw), math.cos(roll), math.sin(roll)
        # Columns: axes that yaw, pitch and roll turn about (pitch about minus the rolled y axis).
        jacobian = np.array([[0.0, sy * cr, cy], [0.0, -cy * cr, sy], [1.0, -sr, 0.0]])
        step = np.linalg.solve(jacobian.T @ jacobian + 1e-6 * np.eye(3), jacobian.T @ error)
        yaw, pitch, roll = yaw + step[0], pitch + step[1], roll + step[2]
    return np.array([yaw, pitch, roll])
