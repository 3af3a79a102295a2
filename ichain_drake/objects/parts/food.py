"""Food that a hand moves and an oven heats (paper sec. V, fig. 5): it heats only inside, shut in, and switched on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import ClassVar, Unpack

import numpy as np

from ichain_drake.errors import InputError
from ichain_drake.objects.base import ObjectArguments, ParentStates, WorldObject
from ichain_drake.objects.camera import FRAME as CAMERA
from ichain_drake.objects.camera import CameraFrame
from ichain_drake.objects.fault_clock import COUNTED, FaultClock
from ichain_drake.objects.hand_reading import HandReading
from ichain_drake.objects.parents import hand_among
from ichain_drake.objects.region import Region
from ichain_drake.objects.touch import TouchRule
from ichain_drake.objects.vessels.cup_settings import CupFaults, Surface
from ichain_drake.state import BoolArray, FloatArray, Role, StateSpace, Variable

POSITION_NOISE = 0.0015
"""Standard deviation of a reading of the position [m]."""

TEMPERATURE_NOISE = 0.004
"""Standard deviation of a reading of the temperature."""

_TOUCH = TouchRule(2.0, 0.5)
_LIFTED = 0.015  # m above its support: only then a grasp slips
_CUT = 0.5


@dataclass(frozen=True)
class OvenSettings:
    """The oven as the food meets it; lengths along the axes of the robot's frame.

    Attributes:
        door, button, dial: names of the food's parents that are these parts.
        cavity: where the middle of food is that is inside.
        doorway: where the middle of food is that the closed door would touch, or that is behind it.
        open_from: coordinate of the door from which on food and hand fit through [m].
        shut_until: coordinate of the door up to which it is shut [m].
        on_from: coordinate of the button from which on it is in: the oven is on [m].
        rate: heating in a second, for a radian of the dial.
        margin: hysteresis of the two thresholds [m].
    """

    door: str = "door"
    button: str = "button"
    dial: str = "knob"
    cavity: Region = field(default_factory=lambda: Region((0.765, 0.0425, 0.08), (0.065, 0.085, 0.05)))
    doorway: Region = field(default_factory=lambda: Region((0.75, 0.0425, 0.10), (0.13, 0.115, 0.15)))
    open_from: float = 0.16
    shut_until: float = 0.012
    on_from: float = 0.006
    rate: float = 0.0286
    margin: float = 0.001


@dataclass(frozen=True)
class FoodSettings:
    """What a scenario gives about food.

    Attributes:
        width, height: of the block that it is [m].
        grasp: where the hand must be, relative to its middle, when it closes around it.
        surfaces: what it can stand on beside the table at height 0.
        camera: frame in which its place is seen.
        oven: see `OvenSettings`.
        faults: see `CupFaults`; food inside the oven is not knocked.
    """

    width: float = 0.05
    height: float = 0.08
    grasp: Region = field(default_factory=lambda: Region((0.0, 0.0, 0.0), (0.015, 0.015, 0.025)))
    surfaces: tuple[Surface, ...] = ()
    camera: CameraFrame = field(default_factory=CameraFrame)
    oven: OvenSettings = field(default_factory=OvenSettings)
    faults: CupFaults = field(default_factory=CupFaults)


class Food(WorldObject):
    """A block of food. Its parents: one hand, and door, button and dial of an oven.

    Its position is that of its middle, in the camera's frame; `temperature` goes from 0, cold, to 1, hot. The hand
    moves it while it holds it, if the door lets it. The dial heats it while it is inside, the door shut and the button
    in; the button has its part in it just then. The door matters to whatever is inside: open, it keeps it from being
    heated (paper sec. V). All of this depends on more than an interaction's two ends.

    Args:
        name, parents, initial, settings: see `WorldObject`.
        food: see `FoodSettings`.

    Raises:
        InputError: if a part of the oven is not among its parents, or there is not exactly one hand beside them.
    """

    state_space: ClassVar[StateSpace] = StateSpace(
        "food",
        (
            *(Variable(a, "m", role=Role("position", CAMERA, a), measured_in="plant") for a in ("x", "y", "z")),
            Variable("temperature", "1", 0.0, 1.0),
            *(Variable(n, hidden=True) for n in ("held", "offset_x", "offset_y", "offset_z", "grip")),
            *(Variable(n, hidden=True) for n in COUNTED),
        ),
    )

    def __init__(
        self,
        name: str,
        parents: Mapping[str, StateSpace],
        food: FoodSettings | None = None,
        **given: Unpack[ObjectArguments],
    ) -> None:
        super().__init__(name, parents, **given)
        self.food = food or FoodSettings()
        oven = self.food.oven
        for part in (oven.door, oven.button, oven.dial):
            if part not in parents:
                raise InputError(
                    f"{name}: {part} is not among its parents {', '.join(parents)}; name it in OvenSettings"
                )
        self._hand = hand_among(parents, (oven.door, oven.button, oven.dial), name, "food")
        self._read = HandReading(parents[self._hand], name, grips=True)
        index = self.state_space.index
        self._temperature, self._holding, self._offset = index("temperature"), index("held"), index("offset_x")
        self._grip, self._age = index("grip"), index("age")
        self._faults = FaultClock(self.food.faults, self.state_space)
        self._door, self._button, self._dial = (
            parents[p].index(v) for p, v in ((oven.door, "y"), (oven.button, "x"), (oven.dial, "angle"))
        )

    def state_at(self, place: Sequence[float] | FloatArray, temperature: float) -> FloatArray:
        """Food that stands somewhere.

        Args:
            place: of its middle, in the robot's frame [m], shape (3,).
            temperature: 0 to 1.

        Returns:
            shape (n_variables,).

        Raises:
            InputError: if the temperature is outside 0..1.
        """
        if not 0.0 <= temperature <= 1.0:
            raise InputError(f"{self.get_name()}: temperature {temperature} is outside 0..1")
        state = np.zeros(len(self.state_space))
        state[:3] = self.food.camera.from_robot(np.asarray(place, dtype=float))
        state[self._temperature] = temperature
        return state

    def default_state(self) -> FloatArray:
        """Cold, at the robot's origin."""
        state = np.zeros(len(self.state_space))
        state[2] = FoodSettings.height / 2
        return state

    def support(self, x: FloatArray, y: FloatArray, z: FloatArray) -> FloatArray:
        """Height of what is below food [m], for a position of its middle in the robot's frame [m]."""
        below: FloatArray = np.zeros_like(x)
        for s in self.food.surfaces:
            below = np.where(s.reaches(x, y) & (z > s.height), np.maximum(below, s.height), below)
        return below

    def step(
        self, state: FloatArray, parents: ParentStates, active: Mapping[str, FloatArray], noise: FloatArray, dt: float
    ) -> FloatArray:
        """The dial's angle sets how fast it heats."""
        oven = self.food.oven
        s = np.array(state, dtype=float).T
        on, angle = np.asarray(active[oven.dial]).T, parents[oven.dial].T[self._dial]
        s[self._temperature] = np.clip(s[self._temperature] + on * oven.rate * angle * dt, 0.0, 1.0)
        s[self._grip] = parents[self._hand].T[self._read.grip_index] > _CUT
        s[self._age] += dt
        return s.T

    def settle(self, state: FloatArray, parents: ParentStates, active: Mapping[str, bool]) -> FloatArray:
        """Held food is where the hand has it; what is let go falls on what is below; faults happen."""
        held, was = np.asarray(active[self._hand]) > _CUT, state[..., self._holding] > _CUT
        if self.settings.body_size:
            return state  # the plant moves it
        new = self._carry(state, parents, held, was) if np.count_nonzero(held | was) else state
        return self._knock(new, held, parents[self._hand]) if self._faults.knocks else new

    def _carry(self, state: FloatArray, parents: ParentStates, held: BoolArray, was: BoolArray) -> FloatArray:
        s = np.array(state, dtype=float).T
        hand, k = parents[self._hand], self._offset
        place, middle = self._read.position(hand), self.food.camera.to_robot(state[..., :3]).T
        offset = self._read.rotate_back(hand, middle - place)
        s[k : k + 3] = np.where(held.T & ~was.T, offset, s[k : k + 3])
        moved = place + self._read.rotate(hand, s[k : k + 3])
        half = self.food.height / 2
        moved[2] = np.maximum(moved[2], self.support(*moved) + half)
        stands = np.array([middle[0], middle[1], self.support(*middle) + half])
        middle = np.where(held.T, moved, np.where(was.T, stands, middle))
        s[:3] = np.where(held.T | was.T, self.food.camera.from_robot(middle.T).T, s[:3])
        s[self._holding] = held.T
        self._faults.slipped(s, was.T & ~held.T & (hand.T[self._read.grip_index] > _CUT))
        return s.T

    def _knock(self, state: FloatArray, held: BoolArray, hand: FloatArray) -> FloatArray:
        s = np.array(state, dtype=float).T
        oven, camera = self.food.oven, self.food.camera
        middle = camera.to_robot(s[:3].T)
        inside = np.apply_along_axis(lambda p: oven.cavity.holds(p.tolist(), False), -1, middle)
        self._faults.knock(s, ~held.T & ~inside.T, camera, self._read.position(hand))
        return s.T

    def decide_active(
        self, state: FloatArray, parents: ParentStates, active: Mapping[str, bool], touch: float | None
    ) -> Mapping[str, bool]:
        """Heated only inside, shut in and switched on; moved only where the door lets the hand."""
        oven = self.food.oven
        place = self.food.camera.to_robot(state[:3])
        door, button = float(parents[oven.door][self._door]), float(parents[oven.button][self._button])
        was = active[oven.dial]
        inside = oven.cavity.holds(place.tolist(), was or active[oven.door])
        shut = door <= oven.shut_until + (oven.margin if was else 0.0)
        on = button >= oven.on_from - (oven.margin if was else 0.0)
        heats = inside and shut and on
        held = self._follows(state, parents[self._hand], place, door, active[self._hand], touch)
        return {self._hand: held, oven.door: inside, oven.button: heats, oven.dial: heats}

    def _follows(
        self, state: FloatArray, hand: FloatArray, place: FloatArray, door: float, was: bool, touch: float | None
    ) -> bool:
        if not hand[self._read.grip_index] > _CUT:
            return False
        if touch is not None:
            return _TOUCH.holds(touch, was)
        at = self._read.position(hand)
        if was:
            k = self._offset
            barred = self._barred(at + self._read.rotate(hand, state[k : k + 3]), door)
            return not barred and not self._slips_now(state, place)
        closes = bool(state[self._grip] < _CUT)
        return closes and self.food.grasp.holds((at - place).tolist()) and not self._barred(place, door)

    def _slips_now(self, state: FloatArray, place: FloatArray) -> bool:
        if not self._faults.slips(state):
            return False
        lifted = place[2] - self.food.height / 2 - float(self.support(*place)) > _LIFTED
        return bool(lifted)

    def _barred(self, place: FloatArray, door: float) -> bool:
        """Whether the door is in the way of food, or of the hand that holds it."""
        return door < self.food.oven.open_from and self.food.oven.doorway.holds(place.tolist())

    def sample_body(self, body: FloatArray) -> FloatArray:
        """Middle of a free body [q (w, x, y, z, position); v] whose origin is its middle."""
        return self.food.camera.from_robot(body[..., 4:7])

    def measure(self, state: FloatArray, noise: FloatArray) -> FloatArray:
        """Place and temperature, with noise."""
        read = state[..., self._observable] + np.array([*[POSITION_NOISE] * 3, TEMPERATURE_NOISE]) * noise
        read[..., 3] = np.clip(read[..., 3], 0.0, 1.0)
        return read
