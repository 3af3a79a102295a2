"""What scenarios share in which the hand plays a game with a joystick: hand -> joystick -> what the game is about.

The link hand -> joystick is the same in all of them, so that a library with it serves them all.
"""

import math
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
from pydrake.common.schema import Rotation, Transform
from pydrake.math import RollPitchYaw

from ichain_drake.objects import Joystick, JoystickMount, ObjectSettings
from ichain_drake.objects.controls.joystick import FULL_TILT, JoystickDrawing, axes_from_tilt, tilt_from_axes
from ichain_drake.robot import BodySpec, SphereSurface
from ichain_drake.scenarios.config import ScenarioConfig
from ichain_drake.scenarios.held_control import HAND, HeldControl
from ichain_drake.scenarios.held_control_config import HeldControlConfig
from ichain_drake.scenarios.joystick_demonstrations import Driver, DrivingStyle, Player
from ichain_drake.settings import setting
from ichain_drake.state import FloatArray
from ichain_drake.visualization import Axis

JOYSTICK = "joystick"
_JOYSTICK_FILE = "package://ichain_drake_models/joystick/joystick.sdf"
_WANTED_STEP = math.radians(15.0)


@dataclass
class MountConfig:
    """Where the joystick stands.

    Attributes:
        pivot: where it is declared to be, see `JoystickMount` [m]: the hand's sphere, its play and its home are about
            it, and the link to it is learned relative to it.
        offset: x, y of where it really is, relative to `pivot` [m]; nobody is told.
        yaw_deg: rotation about the vertical [deg]; nobody is told.
        handle: [m].
    """

    pivot: list[float] = setting(lambda: [0.5, 0.0, 0.05], "m", size=3, lower=-2, upper=2)
    offset: list[float] = setting(lambda: [0.0, 0.0], "m", size=2, lower=-2, upper=2)
    yaw_deg: float = setting(0.0, "deg", lower=-360, upper=360)
    handle: float = setting(0.1, "m", above=0, upper=1)

    def mount(self) -> JoystickMount:
        """Where it really is."""
        x, y, z = self.pivot
        return JoystickMount((x + self.offset[0], y + self.offset[1], z), math.radians(self.yaw_deg), self.handle)


@dataclass
class PlayConfig:
    """How the hand plays with the joystick.

    Attributes:
        reach: farthest from the middle along x and y [m].
        step: farthest in one tick along x and y [m].
    """

    reach: float = setting(0.0425, "m", above=0, upper=1)
    step: float = setting(0.03, "m", above=0, upper=1)


@dataclass
class GameStartConfig:
    """How a run begins.

    Attributes:
        axes: steering and throttle of the stick.
        at_rest: whether what is driven stands; otherwise it has the path's nominal speed.
    """

    axes: list[float] = setting(lambda: [0.0, 0.4], size=2, lower=-1, upper=1)
    at_rest: bool = False


@dataclass
class JoystickGameConfig(HeldControlConfig):
    """Configuration of a game with a joystick."""

    joystick: MountConfig = field(default_factory=MountConfig)
    play: PlayConfig = field(default_factory=PlayConfig)
    start: GameStartConfig = field(default_factory=GameStartConfig)


class JoystickGame(HeldControl):
    """A hand holds a joystick, the joystick drives the last object of the chain along paths; see `HeldControl`.

    Its setting is the two axes.
    """

    config_class: ClassVar[type[ScenarioConfig]] = JoystickGameConfig
    control: ClassVar[str] = JOYSTICK
    control_type: ClassVar[type[Joystick]] = Joystick
    finger_gap: ClassVar[float] = 0.03
    start_spread: ClassVar[float] = 1.0
    ghost_period: ClassVar[float] = 4.0
    driver: ClassVar[DrivingStyle] = DrivingStyle()
    """How the scripted person drives."""

    config: JoystickGameConfig

    def origin(self) -> tuple[float, float, float]:
        """The pivot, as declared."""
        x, y, z = self.config.joystick.pivot
        return x, y, z

    def bring_hand(self) -> None:
        """It keeps to the knob's sphere, within the stick's length; unless z is another's to say."""
        hand, (x, y, z), handle = self.config.robot.hand, self.origin(), self.config.joystick.handle
        if hand.surface is None and "z" not in hand.exposed and "z" not in hand.held:
            hand.surface = SphereSurface([x, y, z], handle)
        self.config.bring_hand({"x": x, "y": y}, {"x": (x - handle, x + handle), "y": (y - handle, y + handle)})

    def command_range(self) -> tuple[FloatArray, FloatArray]:
        """The square that the hand plays in."""
        middle, reach = np.array(self.config.joystick.pivot[:2]), self.config.play.reach
        return middle - reach, middle + reach

    def start_setting(self) -> tuple[FloatArray, bool]:
        """The axes, and whether what is driven stands."""
        return np.array(self.config.start.axes, dtype=float), self.config.start.at_rest

    def hand_for_setting(self, setting: FloatArray) -> FloatArray:
        """Hand state that gives axes, shape (..., 2) -> (..., n_hand)."""
        return self.hand_for_tilt(tilt_from_axes(setting))

    def hand_for_tilt(self, tilt: FloatArray) -> FloatArray:
        """Hand state (exposed variables) over the knob at a tilt: for start states, and the scripted person's skill.

        Args:
            tilt: [rad], shape (..., 2).
        """
        knob = self.config.joystick.mount().knob_from_tilt(tilt)
        return knob[..., :2]

    def hand_for_axes(self, axes: FloatArray) -> FloatArray:
        """A person tilts in proportion."""
        return self.hand_for_tilt(FULL_TILT * axes)

    def person_axes(self) -> tuple[Axis, Axis]:
        """Steering and throttle."""
        return (
            Axis("steering", ("ArrowLeft", "ArrowRight"), ("left", "right"), 0),
            Axis("throttle", ("ArrowDown", "ArrowUp"), ("brake", "go"), 1, -1.0),
        )

    def make_body(self, setting: FloatArray) -> BodySpec:
        """The joystick where it really is, tilted."""
        mount, tilt = self.config.joystick.mount(), tilt_from_axes(setting)
        yaw = Rotation(RollPitchYaw(0.0, 0.0, mount.yaw))
        base = Transform(translation=[mount.pivot[0], mount.pivot[1], mount.pivot[2] - 0.05], rotation=yaw)
        return BodySpec(_JOYSTICK_FILE, base, joints={"tilt_x": float(tilt[0]), "tilt_y": float(tilt[1])})

    def make_control(self, setting: FloatArray, settings: ObjectSettings) -> Joystick:
        """The joystick."""
        state = Joystick.state_at_tilt(tilt_from_axes(setting))
        hand, mount = {HAND: self.graph.objects[HAND]}, self.config.joystick.mount()
        return Joystick(JOYSTICK, hand, mount, initial=state, settings=settings)

    def control_drawing(self) -> JoystickDrawing:
        """The joystick where it really is."""
        return JoystickDrawing(self.config.joystick.mount())

    def make_player(self, count: int) -> Player:
        """Tries positions around the joystick."""
        middle = np.array(self.config.joystick.pivot[:2])
        return Player(middle, self.config.play.reach, self.config.play.step, count, [self.seed, 1])

    def make_driver(self, count: int, run: int) -> Driver:
        """In this game's style."""
        return Driver(self.hand_for_tilt, self.size, count, [self.seed, run], self.driver)

    def held_out_wanted(self, count: int) -> FloatArray:
        """Axes to ask for when the first link is measured: a random walk of tilts that no demonstration shares.

        Args:
            count: how many.

        Returns:
            Wanted axes, shape (count, 2), for tilts within 25 deg that change by at most 15 deg from one to the next.
        """
        rng = np.random.default_rng([self.seed, 905])
        tilt = np.zeros(2)
        tilts: list[FloatArray] = []
        while len(tilts) < count:
            candidate = tilt + rng.uniform(-_WANTED_STEP, _WANTED_STEP, 2)
            if np.abs(candidate).max() <= FULL_TILT:
                tilt = candidate
                tilts.append(tilt)
        return axes_from_tilt(np.array(tilts))
