"""Collision-free motion of the hand to a wanted state, for any arm and scene.

The straight line where the arm can follow it, else a searched way. What is checked is the arm as it will move: its own
inverse kinematics, rolled out; joint limits, joint speeds and singularities show as a hand that doesn't follow.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from pydrake.math import RigidTransform

from ichain_drake.errors import InputError, UnreachableError
from ichain_drake.motion_query import MotionQuery
from ichain_drake.robot.arm_rollout import ArmRollout, Stretch
from ichain_drake.robot.collision import CollisionScene
from ichain_drake.robot.hand import GRIP
from ichain_drake.robot.hand_lines import MARGIN, HandLines, TreeNode
from ichain_drake.robot.kinematics import ArmKinematics
from ichain_drake.robot.path_search import find_way
from ichain_drake.robot.plant import control_plant
from ichain_drake.robot.spec import BodySpec, RobotSpec
from ichain_drake.state import FloatArray

_TRIES = 2
# What may overlap at the goal [m]: where a button is pressed to, and a body in the hand, are known no better.
_PRESSED, _PUT_DOWN = 0.015, 0.025


class MotionPlanner:
    """Finds hand states that bring the hand somewhere without touching anything.

    It remembers nothing but the models it built: a path is a function of the arguments.

    Args:
        spec: the robot and its scenery.
        bodies: declared bodies, by object name: fixed ones are obstacles where they stand, free ones while they are
            held and where they were put down.
        in_hand: pose of a body in the hand's frame while it is held, by object name; of a fixed one the pose of the
            link that its one joint moves (of a door the place of the grasp is what counts).

    Raises:
        InputError: if models or names don't fit, or what is held can't be moved.
    """

    def __init__(
        self,
        spec: RobotSpec,
        bodies: Mapping[str, BodySpec] | None = None,
        in_hand: Mapping[str, RigidTransform] | None = None,
    ) -> None:
        self.spec = spec
        self._bodies, self._in_hand = dict(bodies or {}), dict(in_hand or {})
        for name in self._in_hand:
            if name not in self._bodies:
                raise InputError(f"in_hand: there is no body {name!r}; declare it in bodies")
        self.kinematics = ArmKinematics(control_plant(spec), spec)
        self._scenes: dict[str | None, CollisionScene] = {None: CollisionScene(spec, self._bodies, self._in_hand)}

    def path(self, query: MotionQuery) -> FloatArray:
        """Hand commands to a goal, one a tick.

        Variables of the hand that are the same at both ends stay as they are on the way (but its place); the grip
        changes last. Only where opening fingers would strike something at the goal, and nothing where the hand is now,
        they open first.

        Args:
            query: hand states in exposed variables. What is held without a declared body is taken for small. What was
                shown is gone as it is if nothing is touched, however near it is, else as any other way; of what is not
                fixed, nothing but what it leads to is touched on the way and at the goal.

        Returns:
            shape (n, n_exposed), n >= 1; the last row is the goal.

        Raises:
            InputError: on a wrong shape or a value that is not finite.
            UnreachableError: if there is no way; names what collides.
        """
        hand = self.spec.hand
        start, end = (np.array(hand.space.check(v, "hand state")) for v in (query.now, query.goal))
        wanted = end.copy()
        grip = [i for i, v in enumerate(hand.space.variables) if v.kind == "binary"]
        end[grip] = start[grip]
        scene = self._scene(query.held)
        scene.place({n: hand.full(v) for n, v in query.left.items()}, hand.full(start))
        if query.shown is None and self._opens_first(scene, start, wanted):
            start[grip] = end[grip] = wanted[grip]
        first, last = (TreeNode(v, self.kinematics.solve(hand.full(v))) for v in (start, end))
        lines = HandLines(hand, ArmRollout(self.kinematics, scene, MARGIN), (first, last))
        leaves = query.shown is not None and query.touched is None
        overlap = 0.0 if leaves else _PRESSED if scene.held is None else _PUT_DOWN
        if lines.clearances[1] < min(-overlap, lines.clearances[0]):
            raise UnreachableError(self._blocked(lines, scene))
        if query.shown is not None:
            rows = [np.array(hand.space.check(v, "hand state")) for v in np.asarray(query.shown, dtype=float)]
            for row in rows:
                row[grip] = start[grip]
            others = scene.free - {query.touched}

            def apart(node: TreeNode) -> float:
                return scene.clearance(node.joints, hand.full(node.hand), 0.0, others)

            least = min(0.0, apart(first))
            if apart(last) < least:
                raise UnreachableError(self._blocked(lines, scene))
            nodes = lines.follow(first, rows, shown=True)
            if nodes is not None and all(apart(node) >= least for node in nodes):
                return np.array([*rows[:-1], wanted])
        reached, stopped = lines.line(first, end)
        if reached is not None:
            rows = lines.points(start, end)
        else:
            ways = [find_way(lines, np.random.default_rng(k)) for k in range(_TRIES)]
            found = [w for w in ways if w is not None]
            if not found:
                raise UnreachableError(self._blocked(lines, scene, stopped))
            rows = min(found, key=len)
        out = np.array(rows)
        out[-1] = wanted
        return out

    def _opens_first(self, scene: CollisionScene, start: FloatArray, end: FloatArray) -> bool:
        """Whether the hand is to open before it goes; of two hand states, the second one open."""
        hand = self.spec.hand
        both = [hand.full(v) for v in (start, end)]
        if scene.held is not None or not both[0][GRIP] > both[1][GRIP]:
            return False
        here, there = (scene.opening_clearance(self.kinematics.solve(full), full) for full in both)
        return there < 0.0 <= here

    def _scene(self, held: str | None) -> CollisionScene:
        key = held if held in self._in_hand else None
        if key not in self._scenes:
            self._scenes[key] = CollisionScene(self.spec, self._bodies, self._in_hand, key)
        return self._scenes[key]

    def _blocked(self, lines: HandLines, scene: CollisionScene, stopped: Stretch | None = None) -> str:
        goal = lines.ends[1]
        where = ", ".join(f"{n} {v:.3f}" for n, v in zip(lines.space.names, goal.hand, strict=True))
        if stopped is None:
            pairs = scene.touching(goal.joints, self.spec.hand.full(goal.hand))
            return f"the hand can't be at {where}: {', '.join(pairs)} collide there; choose another state"
        pairs = scene.touching(stopped.at, stopped.full, MARGIN)
        if not pairs:
            return f"no way for the hand to {where}: the arm can't follow it; move the goal or the arm's base"
        return f"no way for the hand to {where}: {', '.join(pairs)} are in the way; clear it or choose another state"
