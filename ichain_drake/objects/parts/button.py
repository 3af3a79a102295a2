"""A sprung push button: a hand over it presses it down, its level of depression is 0 to 6 (paper sec. VI)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import ClassVar, Unpack

import numpy as np
from scipy.special import ndtri

from ichain_drake.errors import InputError
from ichain_drake.objects.base import ObjectArguments, ParentStates, WorldObject
from ichain_drake.objects.hand_reading import HandReading
from ichain_drake.objects.parents import only_hand
from ichain_drake.objects.region import GATE, Region
from ichain_drake.objects.touch import TouchRule
from ichain_drake.state import BoolArray, FloatArray, Role, StateSpace, Variable

LEVELS = 6
"""Highest level (paper sec. VI: a maximum depression of 6 pixels of the camera)."""

_MISREAD = 0.03  # probability that a reading is one off, at noise scale 1
_STICKY = 0.15  # levels by which a rounding threshold must be passed
_TOUCH = TouchRule(0.3, 0.05)
_HIGH = 0.5  # [m] the region over a button has no floor: what is below its top presses it


@dataclass(frozen=True)
class ButtonMount:
    """Where a button is: geometry that a scenario gives.

    Attributes:
        top: middle of its upper face at rest, in the robot's frame [m].
        travel: from rest to its end [m].
        reach: radius of the disc over it in which a hand presses [m].
        fingertip: from the hand's frame to the tips of its fingers [m].
        stiff: factor on the force; a hand's depression is divided by it.
    """

    top: tuple[float, float, float] = (0.5, 0.18, 0.06)
    travel: float = 0.008
    reach: float = field(default=0.018, metadata={GATE: True})
    fingertip: float = 0.0125
    stiff: float = 1.0

    @property
    def touch_height(self) -> float:
        """Height of a hand that points down and touches the button at rest [m]."""
        return self.top[2] + self.fingertip

    def hand_height(self, level: float) -> float:
        """Height of the hand that presses to the middle of a level [m], for a button that is not stiff."""
        return self.touch_height - level / LEVELS * self.travel


class Button(WorldObject):
    """The button. Its one parent is a hand: an object with a position along x, y, z.

    Where the hand has a pitch, it presses only while it points down rather than forwards. Without a body, its
    depression is the geometric one divided by `mount.stiff`; with one, the spring's.

    Args:
        mount: where it is.
        parents, initial, settings: see `WorldObject`.

    Raises:
        InputError: if the parent has no position along x, y and z, or the mount can't be.
    """

    state_space: ClassVar[StateSpace] = StateSpace(
        "button",
        (
            Variable("level", "1", 0.0, LEVELS, "integer", Role("level")),
            Variable("travel", "m", 0.0, 0.05, hidden=True, measured_in="plant"),
        ),
    )

    def __init__(
        self,
        name: str,
        parents: Mapping[str, StateSpace],
        mount: ButtonMount | None = None,
        **given: Unpack[ObjectArguments],
    ) -> None:
        super().__init__(name, parents, **given)
        self.mount = mount or ButtonMount()
        if not (self.mount.travel > 0 and self.mount.stiff > 0 and self.mount.reach > 0):
            raise InputError(f"{name}: travel, reach and stiff of a button are above 0; got {self.mount}")
        self._hand, space = only_hand(parents, name, "a button")
        self._read = HandReading(space, name)
        x, y, _ = self.mount.top
        reach, touch = self.mount.reach, self.mount.touch_height
        self.region = Region((x, y, touch - _HIGH + 0.002), (reach, reach, _HIGH), round=True)
        scale = self.settings.noise_scale
        # The normal noise of a run is scaled; how far out a misreading begins must undo that to keep its probability.
        self._misread = -float(ndtri(min(_MISREAD * scale, 0.5) / 2)) * scale if scale > 0 else np.inf

    def step(
        self, state: FloatArray, parents: ParentStates, active: Mapping[str, FloatArray], noise: FloatArray, dt: float
    ) -> FloatArray:
        """It has no motion of its own: spring and finger settle at once."""
        return state

    def settle(self, state: FloatArray, parents: ParentStates, active: Mapping[str, bool]) -> FloatArray:
        """Depression by the hand's height, and the level that it rounds to, with hysteresis."""
        # Counted: that takes a fraction of the time of `any`.
        if not (self.settings.body_size or np.count_nonzero(active[self._hand]) or np.count_nonzero(state)):
            return state  # at rest
        level, travel = np.asarray(state, dtype=float).T
        if not self.settings.body_size:
            depth = (self.mount.touch_height - self._read.position(parents[self._hand])[2]) / self.mount.stiff
            travel = np.asarray(active[self._hand]).T * np.minimum(np.maximum(depth, 0.0), self.mount.travel)
        exact = travel * (LEVELS / self.mount.travel)
        rounded = np.minimum(np.maximum(np.floor(exact + 0.5), 0.0), LEVELS)
        return np.array([np.where(np.abs(exact - level) > 0.5 + _STICKY, rounded, level), travel]).T

    def decide_active(
        self, state: FloatArray, parents: ParentStates, active: Mapping[str, bool], touch: float | None
    ) -> Mapping[str, bool]:
        """While the hand is over the button, at its top or lower; with a body, while it feels the hand."""
        hand = parents[self._hand]
        on = bool(self._read.points_down(hand))
        if on and touch is None:
            on = self.region.holds(self._read.position(hand).tolist(), active[self._hand])
        elif touch is not None:
            on = _TOUCH.holds(touch, active[self._hand])
        return {self._hand: on}

    def decide_rows(
        self, state: FloatArray, parents: ParentStates, active: Mapping[str, BoolArray]
    ) -> Mapping[str, BoolArray]:
        """See `DecidesRows`."""
        hand = parents[self._hand]
        over = self.region.holds_rows(self._read.position(hand), active[self._hand])
        return {self._hand: over & self._read.points_down(hand)}

    def sample_body(self, body: FloatArray) -> FloatArray:
        """Travel from the prismatic joint, which is negative when pressed."""
        return -body[..., :1]

    def measure(self, state: FloatArray, noise: FloatArray) -> FloatArray:
        """The level, now and then one off (paper sec. VI: counted in the camera's pixels)."""
        off = np.sign(noise) * (np.abs(noise) > self._misread)
        return np.clip(state[..., self._observable] + off, 0.0, LEVELS)
