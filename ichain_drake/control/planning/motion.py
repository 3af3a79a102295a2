"""A way of moving an object that keeps changing a variable: what changes only while the robot moves is driven by it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ichain_drake.control.settings import PLANNING
from ichain_drake.graph import Interaction
from ichain_drake.state import BoolArray, FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class Motion:
    """A way of moving an object, by demonstrated states of the robot and of it.

    Attributes:
        edge: from the robot.
        robot: demonstrated states, shape (n, n_root).
        child: of the object in the same instants, shape (n, n_child).
        onward: index of the state to go on to from each, shape (n,); a state leads to itself where nothing is gained.
        again: whether that is reached by letting go and taking the object anew, shape (n,).
        value: of being in each state, discounted changes of the driven variable, shape (n,).
        reach: of a tick, per variable: robot's and object's, shape (n_root,) and (n_child,); infinite for variables
            that don't tell states apart.
        wraps: which variables of the object are angles, shape (n_child,).
    """

    edge: Interaction
    robot: FloatArray
    child: FloatArray
    onward: IntArray
    again: BoolArray
    value: FloatArray
    reach: tuple[FloatArray, FloatArray]
    wraps: BoolArray

    def __deepcopy__(self, memo: dict[int, object]) -> Motion:
        return self  # never changed, so that memories of an execution may share it

    def grasp(self, child: FloatArray) -> tuple[IntArray, BoolArray]:
        """The state in which to take an object so that it is driven fastest.

        Args:
            child: where the object is, shape (m, n_child).

        Returns:
            Its index, and whether the object was ever taken there, shape (m,) each.
        """
        off = self.away(child)
        near = off <= off.min(axis=1, keepdims=True) + PLANNING.alike
        return np.argmax(np.where(near, self.value, -np.inf), axis=1), off.min(axis=1) <= 1.0

    def at(self, robot: FloatArray, child: FloatArray) -> IntArray:
        """Index of the state that is nearest to a state of robot and object, shape (m,)."""
        off = np.abs(robot[:, None] - self.robot[None]) / self.reach[0]
        return np.argmin(np.maximum(off.max(axis=2), self.away(child)), axis=1)

    def away(self, child: FloatArray) -> FloatArray:
        """How far each of m states of the object is from each of the n, in ticks, shape (m, n)."""
        off = np.abs(child[:, None] - self.child[None])
        off = np.where(self.wraps, np.minimum(off, np.abs(2.0 * np.pi - off)), off)
        return np.asarray((off / self.reach[1]).max(axis=2))
