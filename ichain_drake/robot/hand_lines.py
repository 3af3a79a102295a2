"""Straight lines of the hand that the arm can follow without touching anything: what a search for a way is made of."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from ichain_drake.robot.arm_rollout import ArmRollout, Stretch
from ichain_drake.robot.hand import GRIP, HandSpec
from ichain_drake.state import FloatArray

STRIDE, TURN = 0.04, 0.2
"""Of the hand in a tick [m, rad]: what it can go within the part of a tick in which it moves."""

MARGIN = 0.01
"""Clearance on the way [m]."""

_SLOPE = 0.5  # m of clearance a metre of hand motion away from an end that is nearer to something than the margin
_SLACK = 0.001  # m that the clearance at an end may be undercut


@dataclass(eq=False)
class TreeNode:
    """A hand state on a way.

    Attributes:
        hand: exposed variables, shape (n_exposed,).
        joints: by which the arm comes to it, shape (n_joints,).
        parent: from where.
    """

    hand: FloatArray
    joints: FloatArray
    parent: TreeNode | None = None


class HandLines:
    """Lines between hand states for one way from a start to a goal.

    Args:
        spec: of the hand.
        rollout: how the arm moves, and what it can touch.
        ends: exposed hand state and joints at both ends of the way.

    Attributes:
        steps: ticks that were tried so far.
    """

    def __init__(self, spec: HandSpec, rollout: ArmRollout, ends: tuple[TreeNode, TreeNode]) -> None:
        self.spec, self.space, self.ends = spec, spec.space, ends
        self._rollout = rollout
        self.steps = 0
        self.place = np.flatnonzero(spec.indices < 3)  # noqa: PLR2004 - x, y, z
        self._angles = np.flatnonzero((spec.indices >= 3) & (spec.indices < GRIP))  # noqa: PLR2004
        self.grip = np.flatnonzero(spec.indices == GRIP)
        self.clearances = [rollout.scene.clearance(n.joints, spec.full(n.hand), MARGIN) for n in ends]

    def distance(self, a: FloatArray, b: FloatArray) -> float:
        """Length of the line from one hand state to another [m]; a turn counts as the way that takes as long."""
        way = self.space.difference(b, a)
        length, turn = np.linalg.norm(way[self.place]), np.linalg.norm(way[self._angles])
        return float(max(length, turn * STRIDE / TURN))

    def ticks(self, a: FloatArray, b: FloatArray) -> int:
        """Ticks of the line, at least 1."""
        return max(1, math.ceil(self.distance(a, b) / STRIDE - 1e-6))

    def points(self, a: FloatArray, b: FloatArray) -> list[FloatArray]:
        """Hand state after each tick of the line, the last is `b`."""
        count, way = self.ticks(a, b), self.space.difference(b, a)
        return [a + k / count * way for k in range(1, count)] + [b]

    def step(self, node: TreeNode, hand: FloatArray, *, shown: bool = False) -> tuple[TreeNode | None, Stretch]:
        """One tick to a hand state; None where the arm can't follow or comes too close to something."""
        self.steps += 1
        stretch = self._rollout.tick(node.joints, self.spec.full(node.hand), self.spec.full(hand))
        return (TreeNode(hand, stretch.joints, node) if self._allowed(stretch, shown=shown) else None), stretch

    def line(self, node: TreeNode, hand: FloatArray) -> tuple[TreeNode | None, Stretch | None]:
        """A line to a hand state: where it ends, or None and the tick that can't be gone."""
        for point in self.points(node.hand, hand):
            following, stretch = self.step(node, point)
            if following is None:
                return None, stretch
            node = following
        return node, None

    def follow(self, node: TreeNode, rows: Iterable[FloatArray], *, shown: bool = False) -> list[TreeNode] | None:
        """Ticks from a node to one hand state after the other, as they were shown or not; None if one can't be gone."""
        out: list[TreeNode] = []
        for hand in rows:
            following, _ = self.step(out[-1] if out else node, hand, shown=shown)
            if following is None:
                return None
            out.append(following)
        return out

    def _allowed(self, stretch: Stretch, *, shown: bool) -> bool:
        """Near an end that is close to something the way may be as close; the farther from it the less.

        Turned in place, as at a knob, the hand is still there. What was shown needs no margin, and slides along what is
        between the fingers at its start: how it lies there is not known to the millimetre.
        """
        margin = 0.0 if shown else MARGIN
        if not stretch.follows or stretch.clearance >= margin:
            return stretch.follows
        place = self.spec.reduce(stretch.full)[self.place]
        least = min(
            near - _SLACK + slope * float(np.linalg.norm(place - end.hand[self.place]))
            for end, near, slope in zip(self.ends, self.clearances, (0.0 if shown else _SLOPE, _SLOPE), strict=True)
        )
        return stretch.clearance >= min(least, margin)
