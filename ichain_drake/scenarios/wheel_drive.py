"""What scenarios share in which the hand turns and lifts a steering wheel: hand -> wheel -> what the wheel drives.

The link hand -> wheel is the same in all of them, so that a library with it serves them all.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

import numpy as np
from pydrake.common.schema import Transform

from ichain_drake.objects import ObjectSettings, Wheel, WheelMount
from ichain_drake.objects.controls.wheel import TRAVEL, WheelDrawing
from ichain_drake.robot import BodySpec, RingPath
from ichain_drake.scenarios.command_chart import CommandChart
from ichain_drake.scenarios.config import ScenarioConfig
from ichain_drake.scenarios.held_control import HAND, HeldControl
from ichain_drake.scenarios.held_control_config import HeldControlConfig
from ichain_drake.scenarios.seats import Seat
from ichain_drake.scenarios.wheel_demonstrations import DriverStyle, WheelDriver, WheelPlayer, random_walk
from ichain_drake.settings import setting
from ichain_drake.state import FloatArray
from ichain_drake.visualization import Axis

WHEEL = "wheel"
_WHEEL_FILE = "package://ichain_drake_models/wheel/wheel.sdf"
_ROOM = 0.03  # m, that the hand may be beyond the circle and the middle of the column's way
_HELD_OUT_STEP = np.array([math.radians(18.0), 0.008])


@dataclass
class WheelConfig:
    """Where the wheel lies; see `WheelMount`.

    Attributes:
        center: of the rim at rest [m]: the hand's ring, bounds and home are about it, and the link to it is learned
            relative to it.
        radius, knob: [m].
    """

    center: list[float] = setting(lambda: [0.47, 0.0, 0.12], "m", size=3, lower=-2, upper=2)
    radius: float = setting(0.11, "m", above=0, upper=1)
    knob: float = setting(0.045, "m", above=0, upper=1)

    def mount(self) -> WheelMount:
        """The same as `WheelMount`."""
        x, y, z = self.center
        return WheelMount((x, y, z), self.radius, self.knob)


@dataclass
class WheelPlayConfig:
    """How the hand plays with the wheel.

    Attributes:
        angle_deg, slide: farthest from the middle [deg, m].
        step_deg, step_slide: farthest in one tick [deg, m].
    """

    angle_deg: float = setting(120.0, "deg", above=0, upper=140)
    slide: float = setting(0.022, "m", above=0, upper=TRAVEL)
    step_deg: float = setting(25.0, "deg", above=0, upper=360)
    step_slide: float = setting(0.012, "m", above=0, upper=1)

    def reach(self) -> FloatArray:
        """Farthest angle [rad] and slide [m]."""
        return np.array([math.radians(self.angle_deg), self.slide])

    def step(self) -> FloatArray:
        """Farthest in one tick, angle [rad] and slide [m]."""
        return np.array([math.radians(self.step_deg), self.step_slide])


@dataclass
class WheelStartConfig:
    """How a run begins, the wheel straight.

    Attributes:
        slide: of the column [m].
        at_rest: whether what is driven stands; otherwise it has the path's nominal speed.
    """

    slide: float = setting(0.0, "m", lower=-TRAVEL, upper=TRAVEL)
    at_rest: bool = False


@dataclass
class WheelDriveConfig(HeldControlConfig):
    """Configuration of a scenario with a wheel."""

    wheel: WheelConfig = field(default_factory=WheelConfig)
    play: WheelPlayConfig = field(default_factory=WheelPlayConfig)
    start: WheelStartConfig = field(default_factory=WheelStartConfig)


class WheelDrive(HeldControl):
    """A hand turns and lifts a wheel, the wheel drives the last object of the chain along paths; see `HeldControl`.

    Its setting is angle [rad] and slide [m].
    """

    config_class: ClassVar[type[ScenarioConfig]] = WheelDriveConfig
    unit: ClassVar[str] = "m"
    y_down: ClassVar[bool] = False
    control: ClassVar[str] = WHEEL
    control_type: ClassVar[type[Wheel]] = Wheel
    finger_gap: ClassVar[float] = 0.032
    target_length: ClassVar[float]  # type: ignore[misc]
    driver: ClassVar[DriverStyle]
    """How the scripted person drives who is watched."""

    config: WheelDriveConfig

    def given(self) -> dict[str, Any]:
        """The configuration, with the unit of errors and the length of what is driven, to set them beside."""
        return super().given() | {"unit": self.unit, "vehicle_length": self.target_length}

    def origin(self) -> tuple[float, float, float]:
        """The middle of the rim."""
        return self.config.wheel.mount().center

    def bring_hand(self) -> None:
        """It keeps to the knob's circle, and begins where the knob is at rest."""
        hand, mount = self.config.robot.hand, self.config.wheel.mount()
        (x, y, z), radius = mount.center, mount.radius
        if hand.ring is None:
            hand.ring = RingPath([x, y], radius)
        height, reach = z + mount.knob, radius + _ROOM
        self.config.bring_hand(
            {"x": x - radius, "y": y, "z": height},
            {"x": (x - reach, x + reach), "y": (y - reach, y + reach), "z": (height - _ROOM, height + _ROOM)},
        )

    def command_range(self) -> tuple[FloatArray, FloatArray]:
        """Angle [rad] and slide [m] that the hand plays in: commands off the knob's way make no sense."""
        reach = self.config.play.reach()
        return -reach, reach

    def command_chart(self) -> CommandChart:
        """Angle and slide that a hand leads the knob to."""
        hand, mount = self.config.robot.hand, self.config.wheel.mount()
        return CommandChart(self.hand_for_setting, lambda state: mount.wheel_from_knob(hand.full(state)[..., :3]))

    def start_setting(self) -> tuple[FloatArray, bool]:
        """The wheel straight, the column as configured; and whether what is driven stands."""
        return np.array([0.0, self.config.start.slide]), self.config.start.at_rest

    def hand_for_setting(self, setting: FloatArray) -> FloatArray:
        """Hand state (exposed variables) at the knob: for start states, and the scripted person's skill.

        Args:
            setting: angle [rad] and slide [m], shape (..., 2).
        """
        knob = self.config.wheel.mount().knob_from_wheel(setting)
        full = np.zeros((*knob.shape[:-1], 7))
        full[..., :3], full[..., 6] = knob, 1.0
        return self.config.robot.hand.reduce(full)

    def hand_for_axes(self, axes: FloatArray) -> FloatArray:
        """As far as the hand plays."""
        return self.hand_for_setting(self.config.play.reach() * axes)

    def person_axes(self) -> tuple[Axis, Axis]:
        """Steering and speed."""
        return (
            Axis("steering", ("ArrowRight", "ArrowLeft"), ("right", "left"), 0, -1.0),
            Axis("speed", ("ArrowDown", "ArrowUp"), ("slower", "faster"), 1, -1.0),
        )

    def seats(self) -> Mapping[str, Seat]:
        """The wheel; and the hand, which turns it with the same axes."""
        seats = super().seats()
        hand = replace(
            seats[WHEEL],
            name=HAND,
            world=self.idle_world,
            drawings=self.drawings,
            plant=self.drawn_plant,
            objects=tuple(self.graph.objects),
        )
        return {**seats, HAND: hand}

    def make_body(self, setting: FloatArray) -> BodySpec:
        """The wheel, turned and lifted; the knob's spin undoes the turn: a hand of constant orientation holds it."""
        x, y, z = self.config.wheel.mount().center
        angle, slide = float(setting[0]), float(setting[1])
        joints = {"slide": slide, "turn": angle, "spin": -angle}
        return BodySpec(_WHEEL_FILE, Transform(translation=[x, y, z - 0.12]), joints=joints)

    def make_control(self, setting: FloatArray, settings: ObjectSettings) -> Wheel:
        """The wheel."""
        hand, mount = {HAND: self.graph.objects[HAND]}, self.config.wheel.mount()
        return Wheel(WHEEL, hand, mount, initial=setting, settings=settings)

    def control_drawing(self) -> WheelDrawing:
        """The wheel."""
        return WheelDrawing(self.config.wheel.mount())

    def make_player(self, count: int) -> WheelPlayer:
        """Tries places of the knob."""
        play = self.config.play
        return WheelPlayer(self.hand_for_setting, play.reach(), play.step(), count, [self.seed, 1])

    def make_driver(self, count: int, run: int) -> WheelDriver:
        """In the style of what is driven."""
        driven = (self.target, self.graph.objects[self.target].observable)
        return WheelDriver(self.hand_for_setting, driven, self.size, self.driver, count, [self.seed, run])

    def held_out_wanted(self, count: int) -> FloatArray:
        """Wheel states to ask for when the first link is measured: a random walk that no demonstration shares.

        Args:
            count: how many.

        Returns:
            Angle [rad] and slide [m], shape (count, 2), that change by at most 18 deg and 8 mm from one to the next.
        """
        return random_walk(self.config.play.reach(), _HELD_OUT_STEP, count, np.random.default_rng([self.seed, 905]))
