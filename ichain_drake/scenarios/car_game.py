"""The car game (paper sec. IV): hand -> joystick -> car.

Given: the joystick's place and size, the reach of the hand's play, the start of a run, the nominal speed, and the
candidate lists of `models/scenarios/car_game.yaml`. Everything else is learned.
"""

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
from pydrake.common.schema import Rotation, Transform
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix
from pydrake.systems.framework import Context, Diagram

from ichain_drake.control.path import PathLimits, TimedPath
from ichain_drake.demonstrations.table import Demonstration
from ichain_drake.errors import InputError
from ichain_drake.graph import InteractionGraph
from ichain_drake.objects import Car, Joystick, JoystickMount, ObjectSettings
from ichain_drake.objects.joystick import FULL_TILT, JoystickDrawing, axes_from_tilt, tilt_from_axes
from ichain_drake.robot import BodySpec, Physics, build_robot, hand_pose
from ichain_drake.robot.arm import ArmRobot
from ichain_drake.scenarios.base import PathScenario, Progress
from ichain_drake.scenarios.car_game_demonstrations import Driver, Player
from ichain_drake.scenarios.config import PathConfig, ScenarioConfig
from ichain_drake.scenarios.episode import Prepare
from ichain_drake.scenarios.recorder import record
from ichain_drake.state import FloatArray
from ichain_drake.timing import TICK
from ichain_drake.visualization import GameScreen, HandDrawing
from ichain_drake.world.world import World

HAND, JOYSTICK, CAR = "hand", "joystick", "car"
_IDS = {HAND: 0, JOYSTICK: 1, CAR: 2}
_JOYSTICK_FILE = "package://ichain_drake_models/joystick/joystick.sdf"
_START_SPREAD = 1.0  # px, standard deviation of where a run starts
_RUNS_PER_SEED = 1000
_WANTED_STEP = math.radians(15.0)


@dataclass
class MountConfig:
    """Where the joystick stands.

    Attributes:
        pivot: see `JoystickMount` [m].
        yaw_deg: rotation about the vertical [deg].
        handle: [m].
    """

    pivot: list[float] = field(default_factory=lambda: [0.5, 0.0, 0.05])
    yaw_deg: float = 0.0
    handle: float = 0.1

    def mount(self) -> JoystickMount:
        """The same as `JoystickMount`.

        Raises:
            InputError: if the pivot does not have three coordinates.
        """
        if len(self.pivot) != 3:
            raise InputError(f"joystick.pivot is {self.pivot}; give x, y, z in metres")
        return JoystickMount((self.pivot[0], self.pivot[1], self.pivot[2]), math.radians(self.yaw_deg), self.handle)


@dataclass
class PlayConfig:
    """How the hand plays with the joystick.

    Attributes:
        reach: farthest from the middle along x and y [m].
        step: farthest in one tick along x and y [m].
    """

    reach: float = 0.0425
    step: float = 0.03


@dataclass
class StartConfig:
    """How a run begins.

    Attributes:
        axes: steering and throttle of the stick.
        at_rest: whether the car stands; otherwise it has the path's nominal speed.
    """

    axes: list[float] = field(default_factory=lambda: [0.0, 0.4])
    at_rest: bool = False


@dataclass
class CarGameConfig(ScenarioConfig):
    """Configuration of the car game."""

    joystick: MountConfig = field(default_factory=MountConfig)
    play: PlayConfig = field(default_factory=PlayConfig)
    start: StartConfig = field(default_factory=StartConfig)
    path: PathConfig = field(default_factory=PathConfig)


class CarGame(PathScenario):
    """See the module's description and `Scenario`."""

    name: ClassVar[str] = "car_game"
    config_class: ClassVar[type[ScenarioConfig]] = CarGameConfig
    target: ClassVar[str] = CAR
    config: CarGameConfig

    def __init__(self, overrides: Sequence[str] = (), physics: Physics = "contact", seed: int = 0) -> None:
        super().__init__(overrides, physics, seed)
        _check_numbers(self.config)

    def make_graph(self) -> InteractionGraph:
        """A chain: hand -> joystick -> car."""
        objects = {HAND: self.config.robot.hand.space, JOYSTICK: Joystick.state_space, CAR: Car.state_space}
        return InteractionGraph(objects, [(HAND, JOYSTICK), (JOYSTICK, CAR)])

    def path_limits(self) -> PathLimits:
        """From the configuration."""
        return self.config.path.limits()

    def reference_paths(self) -> Mapping[str, FloatArray]:
        """Figure eight, spiral, cursive (paper fig. 4; the paper gives no coordinates)."""
        return reference_paths()

    def robot_seconds(self) -> Mapping[str, float]:
        """The hand's play takes the robot's time; watching a person drive does not (paper sec. I)."""
        return {"hand->joystick": self.config.learning.samples * TICK, "joystick->car": 0.0}

    def drawings(self) -> Mapping[str, Any]:
        """The game's screen behind the table; hand and joystick too where no plant shows them."""
        turn = RotationMatrix.MakeZRotation(-0.35) @ RotationMatrix.MakeXRotation(math.pi / 2)
        X_WS = RigidTransform(turn, [1.12, 0.22, 0.5])
        size = (int(self.size[0]), int(self.size[1]))
        drawings: dict[str, Any] = {CAR: GameScreen(size, 0.001, X_WS, stand=0.2, ghost_period=4.0)}
        if self.physics != "contact":
            drawings[JOYSTICK] = JoystickDrawing(self.config.joystick.mount())
        if self.physics == "ideal":
            spec = self.config.robot.hand
            drawings[HAND] = HandDrawing(lambda state: (hand_pose(spec.full(state)), 0.03))
        return drawings

    def drawn_plant(self) -> Diagram | None:
        """The arm, and in `contact` the joystick."""
        if self.physics == "ideal":
            return None
        world, _ = self.build_world(Car.state_space.clip(np.zeros(len(Car.state_space))), self.config.start.axes, 0)
        return world.robot if isinstance(world.robot, Diagram) else None

    def command_range(self) -> tuple[FloatArray, FloatArray]:
        """The square that the hand plays in."""
        middle, reach = np.array(self.config.joystick.pivot[:2]), self.config.play.reach
        return middle - reach, middle + reach

    def make_world(self, path: TimedPath, run: int) -> tuple[World, Prepare]:
        """The car on the path's first point, along it, at its nominal speed; the stick as configured."""
        rng = np.random.default_rng([self.seed, run, _IDS[CAR]])
        start = path.points[0] + _START_SPREAD * rng.standard_normal(2) * min(1.0, self.config.noise.scale)
        speed = 0.0 if self.config.start.at_rest else float(path.speed[0])
        heading = float(np.arctan2(np.sin(path.direction[0]), np.cos(path.direction[0])))
        return self.build_world(np.array([*start, heading, speed, 0.0, 0.0]), self.config.start.axes, run)

    def build_world(
        self, car: FloatArray, axes: FloatArray | list[float], run: int, physics: str | None = None
    ) -> tuple[World, Prepare]:
        """A world in any start state.

        Args:
            car: the car's state, shape (6,).
            axes: steering and throttle at start, shape (2,).
            run: number of the run; keys its noise.
            physics: in place of the scenario's.
        """
        physics = physics or self.physics
        config, mount = self.config, self.config.joystick.mount()
        tilt = tilt_from_axes(np.asarray(axes, dtype=float))
        seed = self.seed * _RUNS_PER_SEED + run
        yaw = Rotation(RollPitchYaw(0.0, 0.0, mount.yaw))
        base = Transform(translation=[mount.pivot[0], mount.pivot[1], mount.pivot[2] - 0.05], rotation=yaw)
        body = BodySpec(_JOYSTICK_FILE, base, joints={"tilt_x": float(tilt[0]), "tilt_y": float(tilt[1])})
        robot = build_robot(config.robot, physics, {JOYSTICK: body}, seed, _IDS[HAND])  # type: ignore[arg-type]
        has_body = isinstance(robot, ArmRobot) and physics == "contact"
        scale = config.noise.scale
        objects = {
            JOYSTICK: Joystick(
                JOYSTICK,
                {HAND: self.graph.objects[HAND]},
                Joystick.state_at_tilt(tilt),
                ObjectSettings(_IDS[JOYSTICK], seed, scale, body_size=robot.body_size(JOYSTICK) if has_body else 0),  # type: ignore[union-attr]
                mount,
            ),
            CAR: Car(CAR, {JOYSTICK: Joystick.state_space}, car, ObjectSettings(_IDS[CAR], seed, scale)),
        }
        world = World(self.graph, robot, objects)
        hand = config.robot.hand.full(self.hand_for_tilt(tilt))

        def prepare(context: Context) -> None:
            robot.set_hand(context, hand)

        return world, prepare

    def hand_for_tilt(self, tilt: FloatArray) -> FloatArray:
        """Hand state (exposed variables) over the knob at a tilt: for start states, and the scripted person's skill.

        Args:
            tilt: [rad], shape (..., 2).
        """
        knob = self.config.joystick.mount().knob_from_tilt(tilt)
        return knob[..., :2]

    def record_demonstrations(
        self, progress: Progress | None = None, known: Collection[str] = ()
    ) -> Iterator[Demonstration]:
        """Link one: the hand plays with the joystick. Link two: a scripted driver, standing in for a person, drives.

        The driver holds the stick himself, without the arm, moving it as a tick moves the hand. The drive is
        recorded even if its link is known: validation paths are cut out of it.

        Args:
            progress: called with a line before each piece.
            known: names of interactions that need no demonstration.
        """
        count = self.config.learning.samples
        if f"{HAND}->{JOYSTICK}" not in known:
            if progress:
                progress(f"hand->joystick: playing with the joystick, {count} hand positions ({self.physics})")
            yield self.record_play(count)
        if progress:
            progress(f"joystick->car: a scripted driver at the stick, {count} transitions")
        yield self.record_drive(count, physics="ideal", objects=(JOYSTICK, CAR))

    def record_play(self, count: int) -> Demonstration:
        """The hand tries positions around the joystick by itself (paper sec. IV).

        One more than asked for: in the first tick the grasp is not yet known to hold.
        """
        count += 1
        middle = np.array(self.config.joystick.pivot[:2])
        player = Player(middle, self.config.play.reach, self.config.play.step, count, [self.seed, 1])
        world, prepare = self.build_world(np.array([400.0, 300.0, 0.0, 0.0, 0.0, 0.0]), [0.0, 0.0], 901)
        return record(world, prepare, player, count, (HAND, JOYSTICK), "play")

    def record_drive(
        self, count: int, physics: str | None = None, objects: tuple[str, ...] = (HAND, JOYSTICK, CAR), run: int = 902
    ) -> Demonstration:
        """A scripted driver wanders over the screen.

        Args:
            count: transitions.
            physics: in place of the scenario's.
            objects: whose measurements are recorded.
            run: keys noise and driver.
        """
        driver = Driver(self.hand_for_tilt, self.size, count, [self.seed, run])
        world, prepare = self.build_world(np.array([400.0, 300.0, 0.5, 20.0, 0.0, 0.0]), [0.0, 0.0], run, physics)
        return record(world, prepare, driver, count, objects, "drive")

    def held_out_wanted(self, count: int) -> FloatArray:
        """Axes to ask for when the first link is measured: a random walk of tilts that no demonstration shares.

        Args:
            count: how many.

        Returns:
            Wanted axes, shape (count, 2), for tilts within 25 deg that change by at most 15 deg from one to the next.
        """
        rng = np.random.default_rng([self.seed, 905])
        tilt = np.zeros(2)
        tilts: list[FloatArray] = []
        while len(tilts) < count:
            candidate = tilt + rng.uniform(-_WANTED_STEP, _WANTED_STEP, 2)
            if np.abs(candidate).max() <= FULL_TILT:
                tilt = candidate
                tilts.append(tilt)
        return axes_from_tilt(np.array(tilts))

    def monolithic_demonstration(self, count: int) -> Demonstration:
        """The driver again, but with the robot's hand, in this scenario's physics."""
        return self.record_drive(count, None, (HAND, CAR), 903)


def _check_numbers(config: CarGameConfig) -> None:
    """Refuse numbers that would fail later, in the middle of a run.

    Raises:
        InputError: naming the key.
    """
    config.joystick.mount()
    for key, value in (
        ("joystick.handle", config.joystick.handle),
        ("play.reach", config.play.reach),
        ("play.step", config.play.step),
    ):
        if not 0 < value < math.inf:
            raise InputError(f"{key} is {value}; give a number above 0, in metres")
    axes = config.start.axes
    if len(axes) != 2 or not all(-1 <= a <= 1 for a in axes):
        raise InputError(f"start.axes is {axes}; give steering and throttle, each from -1 to 1")


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
