"""How the arm follows a line of hand states: joints, tracking errors and clearances, tick by tick."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ichain_drake.robot.collision import CollisionScene
from ichain_drake.robot.kinematics import ArmKinematics
from ichain_drake.robot.motion import FRAME_RATE, MOVE_FRAMES
from ichain_drake.robot.pose import hand_pose, hand_rotation
from ichain_drake.state import FloatArray, wrap_angle
from ichain_drake.timing import FRAMES_PER_TICK

# Periods of a tick: the hand's motion in two parts, each as long, and the rest of the tick, in which it holds.
_PARTS = (0.5, 1.0)
_PERIOD = MOVE_FRAMES / FRAME_RATE / len(_PARTS)
_REST = (FRAMES_PER_TICK - MOVE_FRAMES) / FRAME_RATE

# The hand may lag behind a command on its way, as it does where a joint is at its speed limit, but not at rest.
_LAG, _TURN_LAG = 0.03, 0.5
_MISS, _TURN_MISS = 0.006, 0.12


@dataclass(frozen=True)
class Stretch:
    """One tick of an arm that follows its hand.

    Attributes:
        joints: at the end, shape (n_joints,).
        clearance: least on the way [m].
        follows: whether the hand keeps up with its command.
        full: hand state in which the clearance was least, shape (7,).
        at: joints there, shape (n_joints,).
    """

    joints: FloatArray
    clearance: float
    follows: bool
    full: FloatArray
    at: FloatArray


class ArmRollout:
    """Predicts the arm with the same kinematics that drives it, at a coarser step.

    Args:
        kinematics: of the arm.
        scene: what it can touch.
        margin: larger clearances count as this [m].
    """

    def __init__(self, kinematics: ArmKinematics, scene: CollisionScene, margin: float) -> None:
        self._kinematics, self.scene, self.margin = kinematics, scene, margin

    def tick(self, joints: FloatArray, start: FloatArray, end: FloatArray) -> Stretch:
        """One tick from one full hand state to another, shape (7,) each; joints at the start, shape (n_joints,)."""
        kinematics, way = self._kinematics, end - start
        way[3:6] = wrap_angle(way[3:6])
        lowest, worst, follows = math.inf, end, True
        at = joints
        for part in _PARTS:
            full = start + part * way
            full[6] = start[6]
            target = (hand_rotation(*full[3:6].tolist()), full[:3])
            joints = kinematics.follow(joints, [target], _PERIOD)[0][0]
            clearance = self.scene.clearance(joints, full, self.margin)
            if clearance < lowest:
                lowest, worst, at = clearance, full, joints
            miss = kinematics.miss(joints, hand_pose(full))
            follows = follows and miss.position < _LAG and miss.angle < _TURN_LAG
        joints = kinematics.follow(joints, [target], _REST)[0][0]
        miss = kinematics.miss(joints, hand_pose(full))
        follows = follows and miss.position < _MISS and miss.angle < _TURN_MISS
        return Stretch(joints, lowest, follows, np.array(worst), at)
