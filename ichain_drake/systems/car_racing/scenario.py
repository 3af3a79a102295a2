"""A game that nobody here wrote: hand -> joystick -> the car of Gymnasium's CarRacing.

Given: as in the car game, and the map from the joystick's axes to the game's actions, the track, the paths on it. Needs
the extra `games`; without it the scenario is listed, and says what to install when it is to run.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from types import ModuleType
from typing import Any, ClassVar

import numpy as np
from PIL import Image, ImageDraw
from pydrake.math import RigidTransform

from ichain_drake.control.tracking.path import resample
from ichain_drake.objects import Joystick, ObjectSettings, WorldObject
from ichain_drake.objects.gymnasium import GameEnvironment, GymnasiumGame
from ichain_drake.objects.gymnasium.extra import require_gymnasium
from ichain_drake.scenarios.config import ScenarioConfig
from ichain_drake.scenarios.held_control import SCREEN_STAND, SCREEN_WIDTH
from ichain_drake.scenarios.joystick_demonstrations import DrivingStyle
from ichain_drake.scenarios.joystick_game import JOYSTICK, JoystickGame, JoystickGameConfig
from ichain_drake.settings import setting
from ichain_drake.state import FloatArray, StateSpace
from ichain_drake.visualization import GameScreen
from ichain_drake.visualization.sprites import FIELD

CAR = "car"
CAR_WIDTH, CAR_LENGTH = 2.4, 5.0
"""Of the car's hull, in the game's units."""

_WEAVE, _WEAVE_LENGTH = 2.5, 80.0  # units: how far from the middle of the road, and from one swing to the next
_UNFINISHED = 4  # tiles before the end of a lap, where the game would end
_MARGIN = 15.0  # units around the road on the screen
_ROAD = (58, 60, 64)


@dataclass
class GameConfig:
    """How the game is set up.

    Attributes:
        track: seed of the game's track.
        steer, gas, brake: share of the game's action at the end of an axis, 0 to 1.
        steps, frames: so many steps of the game in so many 30 Hz frames; 5 in 3 is real time.
    """

    track: int = setting(7, lower=0, upper=2**31)
    steer: float = setting(0.4, above=0, upper=1)
    gas: float = setting(0.15, above=0, upper=1)
    brake: float = setting(0.15, above=0, upper=1)
    steps: int = setting(5, lower=1, upper=1000)
    frames: int = setting(3, lower=1, upper=1000)


@dataclass
class CarRacingConfig(JoystickGameConfig):
    """Configuration of the racing game."""

    game: GameConfig = field(default_factory=GameConfig)


class CarRacing(JoystickGame):
    """See the module's description and `Scenario`."""

    name: ClassVar[str] = "car_racing"
    config_class: ClassVar[type[ScenarioConfig]] = CarRacingConfig
    target: ClassVar[str] = CAR
    unit: ClassVar[str] = "unit"
    y_down: ClassVar[bool] = False
    size: ClassVar[tuple[float, float]] = (2000 / 3, 2000 / 3)
    start_spread: ClassVar[float] = 0.1
    sprite_length: ClassVar[float] = 3 * CAR_LENGTH
    ghost_period: ClassVar[float] = 8.0
    drive_start: ClassVar[tuple[float, float]] = (0.5, 8.0)
    driver: ClassVar[DrivingStyle] = DrivingStyle(
        name=CAR,
        variables=6,
        speeds=(7.0, 22.0),
        gains=(-2.5, -0.8),
        cruise=lambda speed: 0.0,
        throttle_gain=0.1,
        near=12.0,
    )
    no_oracle: ClassVar[str] = "the true game can be stepped, but in single precision hardly be differentiated"
    config: CarRacingConfig

    @cached_property
    def _game(self) -> ModuleType:
        """What is special to this game; loaded late, as it needs the extra.

        Raises:
            InputError: if the extra is not installed; says how to install it.
        """
        require_gymnasium("envs.box2d.car_racing")
        from ichain_drake.systems.car_racing import game  # noqa: PLC0415  (an extra)

        return game

    @cached_property
    def environment(self) -> GameEnvironment:
        """The open game, on its track.

        Raises:
            InputError: if the extra is not installed.
        """
        config = self.config.game
        stick, clock = Joystick.state_space.observable.names, Fraction(config.steps, config.frames)
        return self._game.open_game(stick, config.steer, config.gas, config.brake, config.track, clock)

    def target_space(self) -> StateSpace:
        """The car's measured variables, and the game's whole state hidden behind them."""
        return self.environment.space

    def make_target(self, state: FloatArray, settings: ObjectSettings) -> WorldObject:
        """The game."""
        stick = {JOYSTICK: Joystick.state_space}
        return GymnasiumGame(CAR, stick, self.environment, initial=state, settings=settings)

    def state_at(self, position: FloatArray, heading: float, speed: float, setting: FloatArray) -> FloatArray:
        """The car at a place, whatever the stick."""
        return self.car_at(position, heading, speed)

    def car_at(self, position: FloatArray, heading: float, speed: float) -> FloatArray:
        """A state of the game with the car at a place.

        Args:
            position: on the playfield [unit], shape (2,).
            heading: [rad].
            speed: forward [unit/s].
        """
        return self._game.place_car(self.environment, position, heading, speed)

    def reference_paths(self) -> Mapping[str, FloatArray]:
        """`lap`: the middle of the game's own road, once round; `weave`: from side to side of it, half round."""
        middle = self._game.centre_line(self.environment)[:-_UNFINISHED]
        return {"lap": middle, "weave": weave(middle[: len(middle) // 2])}

    def make_screen(self, X_WS: RigidTransform) -> GameScreen:
        """The part of the playfield that the road goes through, 800 mm wide; the car is drawn three times as large."""
        polygons = self._game.road(self.environment)
        points = np.concatenate([np.array(corners) for corners in polygons])
        low, high = points.min(axis=0) - _MARGIN, points.max(axis=0) + _MARGIN
        width = max(high[0] - low[0], (high[1] - low[1]) * 4 / 3)
        size = (math.ceil(width), math.ceil(width * 3 / 4))
        corner = (low + high) / 2 - np.array(size) / 2
        return GameScreen(
            size,
            SCREEN_WIDTH / size[0],
            X_WS,
            y_down=self.y_down,
            sprite_length=self.sprite_length,
            field=_picture(polygons, corner, size),
            corner=(float(corner[0]), float(corner[1])),
            ghost_period=self.ghost_period,
            stand=SCREEN_STAND,
        )

    def shown(self) -> Mapping[str, StateSpace]:
        """Of the game, what is measured and how the episode goes; not the dozens of numbers that it goes on from."""
        space = self.graph.objects[CAR]
        names = [*space.observable.names, "reward", "terminated", "truncated"]
        return {**self.graph.objects, CAR: space.subspace(names)}

    def given(self) -> dict[str, Any]:
        """The configuration, the unit of errors and the measure for them."""
        return {**super().given(), "unit": self.unit, "half_car_width": CAR_WIDTH / 2}


def _picture(polygons: list[list[tuple[float, float]]], corner: FloatArray, size: tuple[int, int]) -> Image.Image:
    """The road from above, four image pixels to a unit."""
    zoom = 4
    image = Image.new("RGB", (zoom * size[0], zoom * size[1]), FIELD)
    draw = ImageDraw.Draw(image)
    for corners in polygons:
        draw.polygon([(zoom * (x - corner[0]), zoom * (size[1] - y + corner[1])) for x, y in corners], fill=_ROAD)
    return image


def weave(middle: FloatArray) -> FloatArray:
    """From side to side along a line.

    Args:
        middle: the line [unit], shape (n, 2).

    Returns:
        shape (m, 2), a point a unit; it begins and ends in the middle, more and more to the side at first.
    """
    line = resample(_smooth(middle), 1.0)
    along = np.arange(len(line), dtype=float)
    tangent = np.gradient(line, axis=0)
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    left = np.column_stack([-tangent[:, 1], tangent[:, 0]])
    fade = np.minimum(1.0, along / _WEAVE_LENGTH)
    return line + (_WEAVE * fade * np.sin(2 * math.pi * along / _WEAVE_LENGTH))[:, None] * left


def _smooth(points: FloatArray, window: int = 5) -> FloatArray:
    """A moving average that keeps both ends, shape (n, 2)."""
    padded = np.pad(points, ((window // 2, window // 2), (0, 0)), mode="edge")
    kernel = np.ones(window) / window
    smooth = np.column_stack([np.convolve(c, kernel, mode="valid") for c in padded.T])
    smooth[0], smooth[-1] = points[0], points[-1]
    return smooth
