"""Steering wheel -> car (paper fig. 1): the hand turns and lifts a wheel, the wheel drives a car on the road.

Given: the wheel's place and size (the hand keeps to a ring about it), the reach of the hand's play, the start of a run,
the nominal speed, and the candidate lists of `models/scenarios/driving.yaml`. Everything else is learned.
"""

import math
from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from ichain_drake.objects import RoadCar
from ichain_drake.objects.vehicles.road_car import CAR_LENGTH
from ichain_drake.scenarios.wheel_demonstrations import DriverStyle
from ichain_drake.scenarios.wheel_drive import WheelDrive
from ichain_drake.state import FloatArray

CAR = "car"


class Driving(WheelDrive):
    """See the module's description and `Scenario`."""

    name: ClassVar[str] = "driving"
    target: ClassVar[str] = CAR
    target_type: ClassVar[type[RoadCar]] = RoadCar
    target_length: ClassVar[float] = CAR_LENGTH
    size: ClassVar[tuple[float, float]] = (400.0, 300.0)
    start_spread: ClassVar[float] = 0.02 * CAR_LENGTH
    sprite_length: ClassVar[float] = 4 * CAR_LENGTH
    ghost_period: ClassVar[float] = 8.0
    idle_start: ClassVar[tuple[float, float]] = (0.5, 5.0)
    driver: ClassVar[DriverStyle] = DriverStyle(
        speeds=(5.0, 15.0),
        near=18.0,
        patience=20,
        gains=(1.0, 2.5),
        damping=0.5,
        slide_per_speed=0.0003,
        slide_gain=0.004,
        tremble=(math.radians(14.0), 0.003),
        reach=(math.radians(118.0), 0.021),
        step=(math.radians(25.0), 0.012),
    )

    def state_at(self, position: FloatArray, heading: float, speed: float, setting: FloatArray) -> FloatArray:
        """Rolling straight ahead."""
        return np.array([*position, heading, speed, 0.0, 0.0, 0.0])

    def reference_paths(self) -> Mapping[str, FloatArray]:
        """A figure eight, and a road with two lane changes and a bend."""
        return reference_paths()


def reference_paths(points: int = 4000) -> dict[str, FloatArray]:
    """The two reference paths [m], shape (points, 2) each."""
    t = np.linspace(0.0, 2 * np.pi, points)
    eight = np.stack([200 + 115 * np.sin(t), 150 + 75 * np.sin(2 * t)], axis=1)
    # Lanes 3.5 m apart, changed over 40 m, then half round a bend of 40 m and back.
    straight = np.linspace(0.0, 260.0, points)
    lane = 3.5 * (_smooth((straight - 40) / 40) - _smooth((straight - 150) / 40))
    out = np.stack([60 + straight, 90 + lane], axis=1)
    a = np.linspace(-np.pi / 2, np.pi / 2, points // 2)[1:]
    bend = np.stack([320 + 40 * np.cos(a), 130 + 40 * np.sin(a)], axis=1)
    back = np.stack([np.linspace(320.0, 200.0, points // 4)[1:], np.full(points // 4 - 1, 170.0)], axis=1)
    return {"eight": eight, "lanes": np.concatenate([out, bend, back])}


def _smooth(s: FloatArray) -> FloatArray:
    """From 0 to 1 over 0..1 with continuous curvature."""
    s = np.clip(s, 0.0, 1.0)
    return s**3 * (10 - 15 * s + 6 * s**2)
