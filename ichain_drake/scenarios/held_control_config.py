"""What scenarios with a control that the hand holds have in their configurations, and refuse in them."""

# No `from __future__ import annotations`: Drake's typed YAML reader needs the fields' types themselves.

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from ichain_drake.errors import InputError
from ichain_drake.robot import RobotSpec
from ichain_drake.scenarios.config import PathConfig, ScenarioConfig

_DIGITS = 9  # nanometres: reports list these numbers, and 0.47 - 0.14 is not 0.33 in binary


@dataclass
class HeldControlConfig(ScenarioConfig):
    """Configuration of a scenario with a control; what it leaves open about the hand follows from the control."""

    robot: RobotSpec = field(default_factory=lambda: RobotSpec(home={}))
    path: PathConfig = field(default_factory=PathConfig)

    def bring_hand(self, home: Mapping[str, float], bounds: Mapping[str, tuple[float, float]]) -> None:
        """Fill in where the hand begins and may be; what is configured stays.

        Args:
            home: by variable [m].
            bounds: lowest and highest, by variable [m].
        """
        for name, value in home.items():
            self.robot.home.setdefault(name, round(value, _DIGITS))
        for name, limits in bounds.items():
            self.robot.hand.bounds.setdefault(name, [round(limit, _DIGITS) for limit in limits])


def check_place(key: str, place: Sequence[float]) -> tuple[float, float, float]:
    """Where a control is declared to be [m].

    Raises:
        InputError: naming the key, if it does not have three coordinates.
    """
    if len(place) != 3 or not all(math.isfinite(v) for v in place):
        raise InputError(f"{key} is {place}; give x, y, z in metres")
    return place[0], place[1], place[2]


def check_above_zero(numbers: Mapping[str, tuple[float, float, str]]) -> None:
    """Refuse numbers that would fail later, in the middle of a run.

    Args:
        numbers: value, the most that is possible, and unit in words, by key.

    Raises:
        InputError: naming the key.
    """
    for key, (value, most, unit) in numbers.items():
        if not (0 < value <= most and math.isfinite(value)):
            limit = "" if math.isinf(most) else f" and up to {most:g}"
            raise InputError(f"{key} is {value}; give a number above 0{limit}, in {unit}")
