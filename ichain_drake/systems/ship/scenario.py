"""Steering wheel -> ship (paper sec. IV, its end): the wheel of the drive steers a ship; only wheel -> ship is new.

Given: as in `driving`, and the candidate lists of `models/scenarios/ship.yaml`.
"""

import math
from collections.abc import Mapping
from typing import ClassVar

import numpy as np
from PIL import Image

from ichain_drake.control.tracking.levels import PredictiveWeights
from ichain_drake.objects import Ship
from ichain_drake.objects.controls.wheel import TRAVEL
from ichain_drake.objects.vehicles.ship import SHIP_LENGTH, ShipParameters
from ichain_drake.scenarios.wheel_demonstrations import DriverStyle
from ichain_drake.scenarios.wheel_drive import WheelDrive
from ichain_drake.state import FloatArray
from ichain_drake.visualization.sprites import ship_sprite

SHIP = "ship"


class ShipVoyage(WheelDrive):
    """See the module's description and `Scenario`."""

    name: ClassVar[str] = "ship"
    target: ClassVar[str] = SHIP
    target_type: ClassVar[type[Ship]] = Ship
    target_length: ClassVar[float] = SHIP_LENGTH
    size: ClassVar[tuple[float, float]] = (40.0, 30.0)
    oracle_weights: ClassVar[PredictiveWeights] = PredictiveWeights(horizon=20, effort=0.1)
    start_spread: ClassVar[float] = 0.02 * SHIP_LENGTH
    sprite_length: ClassVar[float] = 2 * SHIP_LENGTH
    ghost_period: ClassVar[float] = 15.0
    idle_start: ClassVar[tuple[float, float]] = (0.5, 0.5)
    driver: ClassVar[DriverStyle] = DriverStyle(
        speeds=(0.5, 1.0),
        near=2.5,
        patience=30,
        gains=(0.8, 2.0),
        damping=3.0,
        slide_per_speed=0.018,
        slide_gain=0.02,
        tremble=(math.radians(25.0), 0.004),
        reach=(math.radians(118.0), 0.021),
        step=(math.radians(25.0), 0.012),
    )

    def state_at(self, position: FloatArray, heading: float, speed: float, setting: FloatArray) -> FloatArray:
        """Under way straight ahead at the engine's configured speed, in the mean current."""
        p = ShipParameters()
        engine = p.full_ahead * self.config.start.slide / TRAVEL
        return np.array([*position, heading, speed, 0.0, 0.0, engine, 0.0, *p.current])

    def sprite(self) -> Image.Image:
        """A ship."""
        return ship_sprite()

    def reference_paths(self) -> Mapping[str, FloatArray]:
        """A figure eight (the lemniscate of Bernoulli), a winding channel, an oval, and wide bends."""
        return reference_paths()


def reference_paths(points: int = 4000) -> dict[str, FloatArray]:
    """The four reference paths [m], shape (points, 2) each."""
    t = np.linspace(-np.pi / 2, 3 * np.pi / 2, points)
    lemniscate = np.stack([np.cos(t), np.sin(t) * np.cos(t)], axis=1) / (1 + np.sin(t) ** 2)[:, None]
    eight = [20.0, 15.0] + 15.5 * lemniscate
    s = np.linspace(0.0, 1.0, points)
    channel = np.stack([5 + 30 * s, 10 + 10 * s + 1.2 * np.sin(3 * np.pi * s)], axis=1)
    oval = [20.0, 15.0] + np.stack([14.0 * np.cos(t), 10.5 * np.sin(t)], axis=1)
    bends = np.stack([4 + 32 * s, 15 + 4 * np.sin(2.5 * np.pi * s + 0.4)], axis=1)
    return {"eight": eight, "channel": channel, "oval": oval, "bends": bends}
