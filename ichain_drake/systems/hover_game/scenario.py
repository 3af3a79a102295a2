"""A second game with the joystick of the car game (paper sec. IV, its end): hand -> joystick -> hovercraft.

Given: as in the car game, and the candidate lists of `models/scenarios/hover_game.yaml`. Everything else is learned;
hand -> joystick may come from the car game's library.
"""

from collections.abc import Mapping
from typing import ClassVar

import numpy as np
from PIL import Image

from ichain_drake.control.tracking.levels import PredictiveWeights
from ichain_drake.objects import Hovercraft
from ichain_drake.objects.vehicles.hovercraft import HovercraftParameters
from ichain_drake.scenarios.joystick_demonstrations import DrivingStyle
from ichain_drake.scenarios.joystick_game import JoystickGame
from ichain_drake.state import FloatArray
from ichain_drake.visualization.sprites import hovercraft_sprite

HOVERCRAFT = "hovercraft"


def _cruise(speed: float) -> float:
    """Throttle at which the hovercraft keeps a speed straight on [px/s], nearly."""
    p = HovercraftParameters()
    return 1.25 * (p.drag_ahead + p.drag_quadratic * speed) * speed / p.thrust


class HoverGame(JoystickGame):
    """See the module's description and `Scenario`."""

    name: ClassVar[str] = "hover_game"
    target: ClassVar[str] = HOVERCRAFT
    target_type: ClassVar[type[Hovercraft]] = Hovercraft
    oracle_weights: ClassVar[PredictiveWeights] = PredictiveWeights(horizon=6, effort=0.02, iterations=4)
    driver: ClassVar[DrivingStyle] = DrivingStyle(
        name=HOVERCRAFT,
        variables=len(Hovercraft.state_space.observable),
        speeds=(20.0, 60.0),
        gains=(0.3, 1.0),
        cruise=_cruise,
        throttle_gain=0.02,
        near=50.0,
        patience=18,
    )

    def state_at(self, position: FloatArray, heading: float, speed: float, setting: FloatArray) -> FloatArray:
        """Not sliding; the fan as fast as the throttle says."""
        return np.array([*position, heading, speed, 0.0, 0.0, setting[1]])

    def sprite(self) -> Image.Image:
        """A hovercraft."""
        return hovercraft_sprite()

    def reference_paths(self) -> Mapping[str, FloatArray]:
        """Wide bends, as a thing that slides can go: an oval, a figure eight, waves."""
        return reference_paths()


def reference_paths(points: int = 4000) -> dict[str, FloatArray]:
    """The three reference paths [px], shape (points, 2) each."""
    t = np.linspace(-np.pi / 2, 3 * np.pi / 2, points)
    oval = np.stack([400 + 280 * np.cos(t), 300 + 180 * np.sin(t)], axis=1)
    lemniscate = np.stack([np.cos(t), np.sin(t) * np.cos(t)], axis=1) / (1 + np.sin(t) ** 2)[:, None]
    eight = [400.0, 300.0] + 330.0 * lemniscate
    s = np.linspace(0.0, 1.0, points)
    waves = np.stack([90 + 620 * s, 300 - 110 * np.sin(3 * np.pi * s)], axis=1)
    return {"oval": oval, "eight": eight, "waves": waves}
