"""What scenarios with a control that the hand holds have in their configurations, and refuse in them."""

# No `from __future__ import annotations`: Drake's typed YAML reader needs the fields' types themselves.

from collections.abc import Mapping
from dataclasses import dataclass, field

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
