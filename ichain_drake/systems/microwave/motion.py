"""Ways of the hand around the microwave oven, whose door is an obstacle where the hand left it."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from pydrake.math import RigidTransform

from ichain_drake.motion_query import MotionQuery
from ichain_drake.robot import BodySpec, MotionPlanner, RobotSpec
from ichain_drake.state import FloatArray
from ichain_drake.systems.microwave.layout import LAYOUT

_ROUNDED = 0.01  # m; a planner for each so rounded place of the door
_Y = 1

Bodies = Callable[[float], Mapping[str, BodySpec]]


class OvenMotion:
    """Plans ways with the door where the robot knows it: as given at the start, then where it was let go of.

    A part that is held goes along with the hand and is no obstacle to it.

    Args:
        spec: the robot and its scenery.
        bodies: of the oven's parts and the food, by the door's coordinate [m].
        door: name of the door.
        start: the door's coordinate at the start [m].
        in_hand: pose of the food in the hand's frame while it is held, by its name.
    """

    def __init__(
        self, spec: RobotSpec, bodies: Bodies, door: str, start: float, in_hand: Mapping[str, RigidTransform]
    ) -> None:
        self._spec, self._bodies, self._door, self._start, self._in_hand = spec, bodies, door, start, dict(in_hand)
        self._planners: dict[tuple[float, str], MotionPlanner] = {}

    def path(self, query: MotionQuery) -> FloatArray:
        """See `MotionPlanner.path`."""
        at = self._start
        if self._door in query.left and self._door != query.held:
            at = float(self._spec.hand.full(query.left[self._door])[_Y]) - LAYOUT.door.point[_Y]
        at = min(max(round(at / _ROUNDED) * _ROUNDED, 0.0), LAYOUT.door.travel)
        part = "" if query.held is None or query.held in self._in_hand else query.held
        if (at, part) not in self._planners:
            bodies = {n: b for n, b in self._bodies(at).items() if n != part}
            self._planners[at, part] = MotionPlanner(self._spec, bodies, self._in_hand)
        return self._planners[at, part].path(query)
