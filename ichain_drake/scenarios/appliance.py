"""What scenarios with an appliance on a table share: a camera that looks from somewhere, and a start with a hand."""

# No `from __future__ import annotations`: Drake's typed YAML reader needs the fields' types themselves.

import math
from dataclasses import dataclass
from typing import ClassVar, Protocol, TypeVar

import numpy as np

from ichain_drake.objects.camera import CameraFrame
from ichain_drake.scenarios.base import CAMERA
from ichain_drake.scenarios.config import ScenarioConfig
from ichain_drake.scenarios.graph_scenario import GraphConfig, GraphScenario
from ichain_drake.settings import setting
from ichain_drake.state import FloatArray

MODELS = "package://ichain_drake_models"


class HasHand(Protocol):
    """A start state that says where the hand is."""

    @property
    def hand(self) -> tuple[float, ...]:
        """The hand's exposed state."""
        ...


StartT = TypeVar("StartT", bound=HasHand)


@dataclass
class ApplianceConfig(GraphConfig):
    """Configuration of a scenario with an appliance.

    Attributes:
        goal, fault: see `GraphConfig`.
        camera_shift: the robot frame's origin in the camera frame [m].
    """

    camera_shift: list[float] = setting(lambda: [0.03, -0.02, -0.05], "m", size=3, lower=-10, upper=10)


class Appliance(GraphScenario[StartT]):
    """A scenario with an appliance; see `GraphScenario`.

    Raises:
        InputError: see `Scenario`.
    """

    config_class: ClassVar[type[ScenarioConfig]] = ApplianceConfig
    features: ClassVar[tuple[str, ...]] = (CAMERA,)
    config: ApplianceConfig

    def camera(self) -> CameraFrame:
        """The camera's frame."""
        x, y, z = self.config.camera_shift
        return CameraFrame(math.radians(self.config.camera.yaw_deg), (x, y, z))

    def home(self) -> tuple[float, ...]:
        """The hand's exposed state at home."""
        spec = self.config.robot
        return tuple(spec.hand.reduce(spec.home_hand()).tolist())

    def start_hand(self, start: StartT) -> FloatArray:
        """The full hand state that a world starts from, shape (7,)."""
        return self.config.robot.hand.full(np.array(start.hand))
