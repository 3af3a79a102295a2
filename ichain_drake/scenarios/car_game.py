"""The car game (paper sec. IV): hand -> joystick -> car.

Given: the joystick's place and size, the reach of the hand's play, the start of a run, the nominal speed, and the
candidate lists of `models/scenarios/car_game.yaml`. Everything else is learned.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from pydrake.math import RigidTransform

from ichain_drake.objects import Car, Joystick, ObjectSettings
from ichain_drake.scenarios.config import ScenarioConfig
from ichain_drake.scenarios.joystick_game import JOYSTICK, JoystickGame, JoystickGameConfig
from ichain_drake.state import FloatArray, StateSpace
from ichain_drake.visualization import GameScreen

CAR = "car"


@dataclass
class CarGameConfig(JoystickGameConfig):
    """Configuration of the car game."""


class CarGame(JoystickGame):
    """See the module's description and `Scenario`."""

    name: ClassVar[str] = "car_game"
    config_class: ClassVar[type[ScenarioConfig]] = CarGameConfig
    target: ClassVar[str] = CAR
    drive_start: ClassVar[tuple[float, float]] = (0.5, 20.0)
    config: CarGameConfig

    def target_space(self) -> StateSpace:
        """The car's."""
        return Car.state_space

    def make_target(self, state: FloatArray, settings: ObjectSettings) -> Car:
        """The car."""
        return Car(CAR, {JOYSTICK: Joystick.state_space}, state, settings)

    def state_at(self, position: FloatArray, heading: float, speed: float, setting: FloatArray) -> FloatArray:
        """Rolling straight ahead."""
        return np.array([*position, heading, speed, 0.0, 0.0])

    def reference_paths(self) -> Mapping[str, FloatArray]:
        """Figure eight, spiral, cursive (paper fig. 4; the paper gives no coordinates)."""
        return reference_paths()

    def make_screen(self, X_WS: RigidTransform) -> GameScreen:
        """A car on a field of 800 x 600 mm."""
        return GameScreen((int(self.size[0]), int(self.size[1])), 0.001, X_WS, stand=0.2, ghost_period=4.0)


def reference_paths(points: int = 4000) -> dict[str, FloatArray]:
    """The three reference paths [px], shape (points, 2) each."""
    t = np.linspace(0.0, 2 * np.pi, points)
    eight = np.stack([400 + 230 * np.sin(t), 300 + 150 * np.sin(2 * t)], axis=1)
    t = np.linspace(1.2 * np.pi, 6.4 * np.pi, points)
    r = 45 + 13 * (t - 1.2 * np.pi)
    spiral = np.stack([400 + r * np.cos(t), 300 + r * np.sin(t)], axis=1)
    t = np.linspace(0.0, 8 * np.pi, points)
    cursive = np.stack([140 + 18.5 * t + 75 * np.sin(t), 300 - 95 * np.cos(t)], axis=1)
    return {"eight": eight, "spiral": spiral, "cursive": cursive}
