"""The car game (paper sec. IV): hand -> joystick -> car.

Given: the joystick's place and size, the reach of the hand's play, the start of a run, the nominal speed, and the
candidate lists of `models/scenarios/car_game.yaml`. Everything else is learned.
"""

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from ichain_drake.objects import Car
from ichain_drake.scenarios.joystick_game import JoystickGame
from ichain_drake.state import FloatArray

CAR = "car"


class CarGame(JoystickGame):
    """See the module's description and `Scenario`."""

    name: ClassVar[str] = "car_game"
    target: ClassVar[str] = CAR
    target_type: ClassVar[type[Car]] = Car
    drive_start: ClassVar[tuple[float, float]] = (0.5, 20.0)

    def state_at(self, position: FloatArray, heading: float, speed: float, setting: FloatArray) -> FloatArray:
        """Rolling straight ahead."""
        return np.array([*position, heading, speed, 0.0, 0.0])

    def reference_paths(self) -> Mapping[str, FloatArray]:
        """Figure eight, spiral, cursive (paper fig. 4; the paper gives no coordinates)."""
        return reference_paths()


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
