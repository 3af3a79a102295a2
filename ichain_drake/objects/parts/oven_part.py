"""Parts of an appliance that a hand grasps and moves along their one degree of freedom: a sliding part and a dial.

A sliding door, a button that is pushed in and pulled out, and a knob are such parts. They stay where they are let go
(a latch or friction holds them), and a hand that goes on beyond an end slips along them.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import ClassVar, Unpack

import numpy as np

from ichain_drake.errors import InputError
from ichain_drake.objects.base import ObjectArguments, ParentStates, WorldObject
from ichain_drake.objects.hand_reading import HandReading
from ichain_drake.objects.region import GATE, Region
from ichain_drake.state import FloatArray, Role, StateSpace, Variable

POSITION_NOISE = 0.0005
"""Standard deviation of a reading of a position [m]."""

ANGLE_NOISE = 0.01
"""Standard deviation of a reading of an angle [rad]."""

_ROBOT = "robot"  # frame in the roles of a hand
_CUT = 0.5
_TOUCH_ON, _TOUCH_OFF = 1.0, 0.2  # N
_AXES = ("x", "y", "z")
_HIDDEN = tuple(Variable(n, hidden=True) for n in ("held", "offset", "grip"))


@dataclass(frozen=True)
class PartMount:
    """Where a part is and how far it goes: geometry that a scenario gives.

    Attributes:
        point: where a hand grasps it while its coordinate is 0, in the robot's frame [m].
        travel: its coordinate goes from 0 to this [m or rad].
        axis: direction of a sliding part.
        reach: half-widths of the box around the grasping point in which a closing hand takes hold of it [m].
        stiff: how far a hand goes for one unit of the way of the part; the fingers slip on one that is stiff.
    """

    point: tuple[float, float, float]
    travel: float
    axis: str = "x"
    reach: tuple[float, float, float] = field(default=(0.015, 0.015, 0.02), metadata={GATE: True})
    stiff: float = 1.0


class OvenPart(WorldObject):
    """A part with one coordinate that follows the hand while the hand holds it. Its one parent is a hand.

    Args:
        name, parents, initial, settings: see `WorldObject`.
        mount: where it is.

    Raises:
        InputError: if the parent is no hand with a position and a grip, or the mount can't be.
    """

    def __init__(
        self, name: str, parents: Mapping[str, StateSpace], mount: PartMount, **given: Unpack[ObjectArguments]
    ) -> None:
        if not (mount.travel > 0 and mount.axis in _AXES and min(mount.reach) > 0 and mount.stiff > 0):
            raise InputError(
                f"{name}: travel, reach and stiff of a part are above 0, its axis is x, y or z; got {mount}"
            )
        if len(parents) != 1:
            raise InputError(f"{name}: a part has one parent, the hand; {len(parents)} given")
        self.mount = mount
        self.state_space = self.make_space(mount)  # type: ignore[misc]
        super().__init__(name, parents, **given)
        ((self._hand, space),) = parents.items()
        self._read = HandReading(space, name, grips=True)
        self._holding, self._offset, self._grip = (self.state_space.index(v.name) for v in _HIDDEN)
        self._axis = _AXES.index(mount.axis)

    @staticmethod
    @abstractmethod
    def make_space(mount: PartMount) -> StateSpace:
        """The state space of a part with this mount."""

    @abstractmethod
    def coordinate_of_hand(self, hand: FloatArray) -> FloatArray:
        """What of a hand moves the part, shape (..., n) -> (...)."""

    @property
    @abstractmethod
    def coordinate_index(self) -> int:
        """Index of the coordinate in the state."""

    def state_at(self, coordinate: float) -> FloatArray:
        """The part at a coordinate [m or rad], not held, shape (n_variables,).

        Raises:
            InputError: if it does not go so far.
        """
        if not 0.0 <= coordinate <= self.mount.travel:
            raise InputError(f"{self.get_name()}: {coordinate} is not within 0..{self.mount.travel}")
        state = np.zeros(len(self.state_space))
        state[self.coordinate_index] = coordinate
        return state

    def grasp_point(self, coordinate: float) -> tuple[float, float, float]:
        """Where a hand grasps it, in the robot's frame [m]."""
        return self.mount.point

    def step(
        self, state: FloatArray, parents: ParentStates, active: Mapping[str, FloatArray], noise: FloatArray, dt: float
    ) -> FloatArray:
        """It has no motion of its own; whether the hand is closed is kept, since only a closing hand takes hold."""
        new = np.array(state, dtype=float)
        new[..., self._grip] = parents[self._hand][..., self._read.grip_index] > _CUT
        return new

    def settle(self, state: FloatArray, parents: ParentStates, active: Mapping[str, bool]) -> FloatArray:
        """While held, the coordinate follows the hand; beyond an end, and where it is stiff, the hand slips along."""
        held, was = np.asarray(active[self._hand]) > _CUT, state[..., self._holding] > _CUT
        if self.settings.body_size or not np.count_nonzero(held | was):
            return state
        s = np.array(state, dtype=float).T
        hand, k = self.coordinate_of_hand(parents[self._hand]), self.coordinate_index
        s[self._offset] = np.where(held.T & ~was.T, s[k] - hand, s[self._offset])
        pushed = _turned(hand + s[self._offset] - s[k]) / self.mount.stiff
        end = np.clip(s[k] + pushed, 0.0, self.mount.travel)
        s[k] = np.where(held.T, end, s[k])
        s[self._offset] = np.where(held.T, s[k] - hand, s[self._offset])
        s[self._holding] = held.T
        return s.T

    def decide_active(
        self, state: FloatArray, parents: ParentStates, active: Mapping[str, bool], touch: float | None
    ) -> Mapping[str, bool]:
        """From when a hand closes around the grasping point until it opens; with a body, while the fingers touch it."""
        hand, was = parents[self._hand], active[self._hand]
        if not hand[self._read.grip_index] > _CUT:
            return {self._hand: False}
        if touch is not None:
            return {self._hand: touch > (_TOUCH_OFF if was else _TOUCH_ON)}
        if was:
            return {self._hand: True}
        point = self.grasp_point(float(state[self.coordinate_index]))
        near = Region(point, self.mount.reach).holds(self._read.position(hand).tolist())
        return {self._hand: near and bool(state[self._grip] < _CUT)}

    def sample_body(self, body: FloatArray) -> FloatArray:
        """Its coordinate, from the one joint of its model."""
        values = np.zeros((*body.shape[:-1], len(self.state_space.plant_indices)))
        values[..., list(self.state_space.plant_indices).index(self.coordinate_index)] = body[..., 0]
        return values

    def measure(self, state: FloatArray, noise: FloatArray) -> FloatArray:
        """Position with noise, within its bounds."""
        return self.state_space.observable.clip(state[..., self._observable] + POSITION_NOISE * noise)


class SlidingPart(OvenPart):
    """A part that slides along one axis: a sliding door, or a button that is pushed in and pulled out.

    Its state is the position of its handle relative to where it is at coordinate 0, in the appliance's frame, whose
    axes are the robot's: components across the axis are 0.
    """

    state_space: ClassVar[StateSpace]

    @staticmethod
    def make_space(mount: PartMount) -> StateSpace:
        """Position x, y, z; the frame of each part is its own, so that none is taken for another's."""
        frame = f"part along {mount.axis}"
        place = [
            Variable(a, "m", 0.0 if a == mount.axis else -0.01, mount.travel if a == mount.axis else 0.01,
                     role=Role("position", frame, a), measured_in="plant" if a == mount.axis else "")
            for a in _AXES
        ]  # fmt: skip
        return StateSpace("sliding_part", (*place, *_HIDDEN))

    @property
    def coordinate_index(self) -> int:
        """The position along the axis."""
        return self._axis

    def grasp_point(self, coordinate: float) -> tuple[float, float, float]:
        """The grasping point moves with the part."""
        point = list(self.mount.point)
        point[self._axis] += coordinate
        return point[0], point[1], point[2]

    def coordinate_of_hand(self, hand: FloatArray) -> FloatArray:
        """Position along the axis [m]."""
        return np.asarray(self._read.position(hand)[self._axis])


class Dial(OvenPart):
    """A knob that turns about the robot's x axis with a hand that points along it; its angle grows as roll falls.

    Its place, which is measured too, stays.

    Raises:
        InputError: if the hand has no roll.
    """

    state_space: ClassVar[StateSpace]

    def __init__(
        self, name: str, parents: Mapping[str, StateSpace], mount: PartMount, **given: Unpack[ObjectArguments]
    ) -> None:
        super().__init__(name, parents, mount, **given)
        variables = parents[self._hand].variables
        rolls = [i for i, v in enumerate(variables) if v.role and (v.role.kind, v.role.axis) == ("orientation", "x")]
        if not rolls:
            raise InputError(f"{name}: its parent {self._hand} has no orientation about x to turn a dial by")
        self._roll = rolls[0]

    @staticmethod
    def make_space(mount: PartMount) -> StateSpace:
        """Where it is, and an angle that does not wrap: it has ends."""
        place = [Variable(a, "m", role=Role("position", _ROBOT, a)) for a in _AXES]
        angle = Variable("angle", "rad", 0.0, mount.travel, role=Role("level"), measured_in="plant")
        return StateSpace("dial", (*place, angle, *_HIDDEN))

    @property
    def coordinate_index(self) -> int:
        """The angle, after the place."""
        return len(_AXES)

    def state_at(self, coordinate: float) -> FloatArray:
        """See `OvenPart.state_at`."""
        state = super().state_at(coordinate)
        state[: len(_AXES)] = self.mount.point
        return state

    def measure(self, state: FloatArray, noise: FloatArray) -> FloatArray:
        """Place and angle, with noise."""
        std = np.array([*[POSITION_NOISE] * len(_AXES), ANGLE_NOISE])
        return self.state_space.observable.clip(state[..., self._observable] + std * noise)

    def coordinate_of_hand(self, hand: FloatArray) -> FloatArray:
        """The hand's roll, the other way round [rad]."""
        return -np.asarray(hand).T[self._roll]


def _turned(change: FloatArray) -> FloatArray:
    """The change of a coordinate in a frame; a hand's roll may have wrapped."""
    return np.where(np.abs(change) > math.pi, change - 2 * math.pi * np.sign(change), change)


SlidingPart.state_space = SlidingPart.make_space(PartMount((0.0, 0.0, 0.0), 0.1))
Dial.state_space = Dial.make_space(PartMount((0.0, 0.0, 0.0), 1.75))
