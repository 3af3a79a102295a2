"""A second game with the joystick of the car game (paper sec. IV, its end): hand -> joystick -> hovercraft.

Given: as in the car game, and the candidate lists of `models/scenarios/hover_game.yaml`. Everything else is learned;
hand -> joystick may come from the car game's library.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from pydrake.math import RigidTransform

from ichain_drake.control.levels import PredictiveWeights
from ichain_drake.control.path import TimedPath
from ichain_drake.demonstrations.table import Demonstration
from ichain_drake.objects import Hovercraft, Joystick, ObjectSettings
from ichain_drake.objects.hovercraft import HovercraftParameters
from ichain_drake.scenarios.car_game_demonstrations import Driver, DrivingStyle
from ichain_drake.scenarios.config import ScenarioConfig
from ichain_drake.scenarios.episode import Prepare
from ichain_drake.scenarios.joystick_game import HAND, JOYSTICK, TARGET_ID, JoystickGame, JoystickGameConfig
from ichain_drake.scenarios.recorder import record
from ichain_drake.state import FloatArray, StateSpace
from ichain_drake.visualization import GameScreen
from ichain_drake.visualization.sprites import hovercraft_sprite
from ichain_drake.world.world import World

HOVERCRAFT = "hovercraft"
_START_SPREAD = 1.0  # px, standard deviation of where a run starts


def _cruise(speed: float) -> float:
    """Throttle at which the hovercraft keeps a speed straight on [px/s], nearly."""
    p = HovercraftParameters()
    return 1.25 * (p.drag_ahead + p.drag_quadratic * speed) * speed / p.thrust


_STYLE = DrivingStyle(
    name=HOVERCRAFT,
    variables=len(Hovercraft.state_space.observable),
    speeds=(20.0, 60.0),
    gains=(0.3, 1.0),
    cruise=_cruise,
    throttle_gain=0.02,
    near=50.0,
    patience=18,
)


@dataclass
class HoverGameConfig(JoystickGameConfig):
    """Configuration of the game with the hovercraft."""


class HoverGame(JoystickGame):
    """See the module's description and `Scenario`."""

    name: ClassVar[str] = "hover_game"
    config_class: ClassVar[type[ScenarioConfig]] = HoverGameConfig
    target: ClassVar[str] = HOVERCRAFT
    oracle_weights: ClassVar[PredictiveWeights] = PredictiveWeights(horizon=6, effort=0.02, iterations=4)
    config: HoverGameConfig

    def target_space(self) -> StateSpace:
        """The hovercraft's."""
        return Hovercraft.state_space

    def make_target(self, state: FloatArray, settings: ObjectSettings) -> Hovercraft:
        """The hovercraft."""
        return Hovercraft(HOVERCRAFT, {JOYSTICK: Joystick.state_space}, state, settings)

    def idle_state(self) -> FloatArray:
        """In the middle of the screen."""
        return np.array([400.0, 300.0, 0.0, 0.0, 0.0, 0.0, 0.0])

    def reference_paths(self) -> Mapping[str, FloatArray]:
        """Wide bends, as a thing that slides can go: an oval, a figure eight, waves."""
        return reference_paths()

    def make_screen(self, X_WS: RigidTransform) -> GameScreen:
        """A hovercraft on a field of 800 x 600 mm."""
        size = (int(self.size[0]), int(self.size[1]))
        return GameScreen(size, 0.001, X_WS, sprite=hovercraft_sprite(), stand=0.2, ghost_period=4.0)

    def make_world(self, path: TimedPath, run: int) -> tuple[World, Prepare]:
        """On the path's first point, along it, at its nominal speed, not sliding; the stick as configured."""
        rng = np.random.default_rng([self.seed, run, TARGET_ID])
        start = path.points[0] + _START_SPREAD * rng.standard_normal(2) * min(1.0, self.config.noise.scale)
        speed = 0.0 if self.config.start.at_rest else float(path.speed[0])
        heading = float(np.arctan2(np.sin(path.direction[0]), np.cos(path.direction[0])))
        axes = self.config.start.axes
        return self.build_world(np.array([*start, heading, speed, 0.0, 0.0, axes[1]]), axes, run)

    def record_drive(
        self,
        count: int,
        physics: str | None = None,
        objects: tuple[str, ...] = (HAND, JOYSTICK, HOVERCRAFT),
        run: int = 902,
    ) -> Demonstration:
        """A scripted driver wanders over the screen.

        Args:
            count: transitions.
            physics: in place of the scenario's.
            objects: whose measurements are recorded.
            run: keys noise and driver.
        """
        driver = Driver(self.hand_for_tilt, self.size, count, [self.seed, run], _STYLE)
        world, prepare = self.build_world(self.idle_state(), [0.0, 0.0], run, physics)
        return record(world, prepare, driver, count, objects, "drive")


def reference_paths(points: int = 4000) -> dict[str, FloatArray]:
    """The three reference paths [px], shape (points, 2) each."""
    t = np.linspace(-np.pi / 2, 3 * np.pi / 2, points)
    oval = np.stack([400 + 280 * np.cos(t), 300 + 180 * np.sin(t)], axis=1)
    lemniscate = np.stack([np.cos(t), np.sin(t) * np.cos(t)], axis=1) / (1 + np.sin(t) ** 2)[:, None]
    eight = [400.0, 300.0] + 330.0 * lemniscate
    s = np.linspace(0.0, 1.0, points)
    waves = np.stack([90 + 620 * s, 300 - 110 * np.sin(3 * np.pi * s)], axis=1)
    return {"oval": oval, "eight": eight, "waves": waves}
