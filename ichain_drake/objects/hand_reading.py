"""What objects read off a hand: its position, orientation and grip, found by their roles."""

from __future__ import annotations

import math

import numpy as np

from ichain_drake.errors import InputError
from ichain_drake.objects.parents import position_indices
from ichain_drake.state import BoolArray, FloatArray, StateSpace

_AXES = ("x", "y", "z")
_LEAN = 0.8  # rad; how far from straight a hand may approach


class HandReading:
    """Reads the state of a parent that is a hand; an angle that it does not have is taken as 0.

    The orientation is that of `ichain_drake.robot.pose`: Rz(yaw) Rx(roll) Ry(-pitch) diag(1, -1, -1).

    Args:
        space: state space of the hand.
        where: the object that reads, for errors.
        grips: whether the hand must have a grip, a binary variable.

    Raises:
        InputError: if the hand has no position along x, y or z, or no grip where it must.
    """

    def __init__(self, space: StateSpace, where: str, *, grips: bool = False) -> None:
        self._place = position_indices(space, _AXES, where)
        turn, grip = {}, None
        for i, variable in enumerate(space.variables):
            if variable.role is not None and variable.role.kind == "orientation":
                turn[variable.role.axis] = i
            elif variable.kind == "binary":
                grip = i
        if grips and grip is None:
            raise InputError(f"{where}: its parent {space.type} has no grip, a binary variable")
        self._roll, self._pitch, self._yaw = (turn.get(a) for a in _AXES)
        self.grip_index = grip

    def position(self, hand: FloatArray) -> FloatArray:
        """Position [m], shape (..., n) -> (3, ...)."""
        return hand.T[self._place]

    def points_down(self, hand: FloatArray) -> BoolArray | bool:
        """Whether a hand, shape (..., n), approaches downwards; a hand without pitch always does."""
        return self._pitch is None or abs(hand.T[self._pitch]) < _LEAN

    def points_level(self, hand: FloatArray) -> BoolArray | bool:
        """Whether a hand, shape (..., n), approaches along the table; a hand without pitch always does."""
        return self._pitch is None or abs(abs(hand.T[self._pitch]) - math.pi / 2) < _LEAN

    def rotate(self, hand: FloatArray, vector: FloatArray) -> FloatArray:
        """A vector of the hand's frame in the robot's, shapes (..., n) and (3, ...) -> (3, ...)."""
        h = hand.T
        x, y, z = vector[0], -vector[1], -vector[2]
        if self._pitch is not None:
            c, s = np.cos(h[self._pitch]), np.sin(h[self._pitch])
            x, z = c * x - s * z, s * x + c * z
        if self._roll is not None:
            c, s = np.cos(h[self._roll]), np.sin(h[self._roll])
            y, z = c * y - s * z, s * y + c * z
        if self._yaw is not None:
            c, s = np.cos(h[self._yaw]), np.sin(h[self._yaw])
            x, y = c * x - s * y, s * x + c * y
        return np.array([x, y, z])

    def rotate_back(self, hand: FloatArray, vector: FloatArray) -> FloatArray:
        """A vector of the robot's frame in the hand's, shapes as in `rotate`."""
        h = hand.T
        x, y, z = vector
        if self._yaw is not None:
            c, s = np.cos(h[self._yaw]), np.sin(h[self._yaw])
            x, y = c * x + s * y, c * y - s * x
        if self._roll is not None:
            c, s = np.cos(h[self._roll]), np.sin(h[self._roll])
            y, z = c * y + s * z, c * z - s * y
        if self._pitch is not None:
            c, s = np.cos(h[self._pitch]), np.sin(h[self._pitch])
            x, z = c * x + s * z, c * z - s * x
        return np.array([x, -y, -z])
