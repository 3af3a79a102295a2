"""What scenarios share in which the hand turns and lifts a steering wheel: hand -> wheel -> what the wheel drives.

The link hand -> wheel is the same in all of them, so that a library with it serves them all.
"""

import copy
import math
from abc import abstractmethod
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

import numpy as np
from pydrake.common.schema import Transform
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.systems.framework import Context, Diagram

from ichain_drake.control.path import PathLimits, TimedPath
from ichain_drake.demonstrations.table import Demonstration
from ichain_drake.errors import InputError
from ichain_drake.graph import InteractionGraph
from ichain_drake.objects import ObjectSettings, Wheel, WheelMount, WorldObject
from ichain_drake.objects.wheel import TRAVEL, WheelDrawing
from ichain_drake.robot import BodySpec, Physics, build_robot, hand_pose
from ichain_drake.robot.arm import ArmRobot
from ichain_drake.scenarios.base import PathScenario, Progress
from ichain_drake.scenarios.command_chart import CommandChart
from ichain_drake.scenarios.config import PathConfig, ScenarioConfig
from ichain_drake.scenarios.episode import Prepare
from ichain_drake.scenarios.recorder import record
from ichain_drake.scenarios.seats import PlaceSeat, Seat
from ichain_drake.scenarios.wheel_demonstrations import DriverStyle, WheelDriver, WheelPlayer, random_walk
from ichain_drake.state import FloatArray, StateSpace
from ichain_drake.timing import TICK
from ichain_drake.visualization import Axis, GameScreen, HandDrawing
from ichain_drake.world.world import World

HAND, WHEEL = "hand", "wheel"
_HAND_ID, _WHEEL_ID, _TARGET_ID = 0, 1, 2
_WHEEL_FILE = "package://ichain_drake_models/wheel/wheel.sdf"
_RUNS_PER_SEED = 1000
_START_SPREAD = 0.02  # of the length of what is driven: standard deviation of where a run starts
_HELD_OUT_STEP = np.array([math.radians(18.0), 0.008])


@dataclass
class WheelConfig:
    """Where the wheel lies; see `WheelMount`.

    Attributes:
        center: of the rim at rest [m].
        radius, knob: [m].
    """

    center: list[float] = field(default_factory=lambda: [0.47, 0.0, 0.12])
    radius: float = 0.11
    knob: float = 0.045

    def mount(self) -> WheelMount:
        """The same as `WheelMount`.

        Raises:
            InputError: if the centre does not have three coordinates.
        """
        if len(self.center) != 3:
            raise InputError(f"wheel.center is {self.center}; give x, y, z in metres")
        return WheelMount((self.center[0], self.center[1], self.center[2]), self.radius, self.knob)


@dataclass
class WheelPlayConfig:
    """How the hand plays with the wheel.

    Attributes:
        angle_deg, slide: farthest from the middle [deg, m].
        step_deg, step_slide: farthest in one tick [deg, m].
    """

    angle_deg: float = 120.0
    slide: float = 0.022
    step_deg: float = 25.0
    step_slide: float = 0.012

    def reach(self) -> FloatArray:
        """Farthest angle [rad] and slide [m]."""
        return np.array([math.radians(self.angle_deg), self.slide])

    def step(self) -> FloatArray:
        """Farthest in one tick, angle [rad] and slide [m]."""
        return np.array([math.radians(self.step_deg), self.step_slide])


@dataclass
class WheelStartConfig:
    """How a run begins, the wheel straight.

    Attributes:
        slide: of the column [m].
        at_rest: whether what is driven stands; otherwise it has the path's nominal speed.
    """

    slide: float = 0.0
    at_rest: bool = False


@dataclass
class WheelDriveConfig(ScenarioConfig):
    """Configuration of a scenario with a wheel."""

    wheel: WheelConfig = field(default_factory=WheelConfig)
    play: WheelPlayConfig = field(default_factory=WheelPlayConfig)
    start: WheelStartConfig = field(default_factory=WheelStartConfig)
    path: PathConfig = field(default_factory=PathConfig)


class WheelDrive(PathScenario):
    """A hand turns and lifts a wheel, the wheel drives the last object of the chain along paths; see `Scenario`."""

    unit: ClassVar[str] = "m"
    y_down: ClassVar[bool] = False
    target_length: ClassVar[float]  # type: ignore[misc]
    driver: ClassVar[DriverStyle]
    """How the scripted person drives who is watched."""

    config: WheelDriveConfig

    def __init__(self, overrides: Sequence[str] = (), physics: Physics = "contact", seed: int = 0) -> None:
        super().__init__(overrides, physics, seed)
        _check_numbers(self.config)

    # What a scenario provides.

    @abstractmethod
    def target_space(self) -> StateSpace:
        """State space of what the wheel drives: a pose in the plane, then its speed; yaw rate last of the measured."""

    @abstractmethod
    def make_target(self, state: FloatArray, settings: ObjectSettings) -> WorldObject:
        """What the wheel drives, a child of the wheel alone.

        Args:
            state: at the start, shape (n_variables,).
            settings: see `ObjectSettings`.
        """

    @abstractmethod
    def start_state(self, x: float, y: float, heading: float, speed: float) -> FloatArray:
        """State of what is driven, straight ahead at a place [m], heading [rad] and speed [m/s], (n_variables,)."""

    @abstractmethod
    def make_screen(self, X_WS: RigidTransform) -> GameScreen:
        """The drawing of what is driven, given the screen's pose in the world."""

    # What they share.

    def make_graph(self) -> InteractionGraph:
        """A chain: the hand, the wheel, and what it drives."""
        spaces = {HAND: self.config.robot.hand.space, WHEEL: Wheel.state_space, self.target: self.target_space()}
        return InteractionGraph(spaces, [(HAND, WHEEL), (WHEEL, self.target)])

    def given(self) -> dict[str, Any]:
        """The configuration, with the unit of errors and the length of what is driven, to set them beside."""
        return super().given() | {"unit": self.unit, "vehicle_length": self.target_length}

    def path_limits(self) -> PathLimits:
        """From the configuration."""
        return self.config.path.limits()

    def robot_seconds(self) -> Mapping[str, float]:
        """The hand's play takes the robot's time; watching a person drive does not (paper sec. I)."""
        return {f"{HAND}->{WHEEL}": self.config.learning.samples * TICK, f"{WHEEL}->{self.target}": 0.0}

    def drawings(self) -> Mapping[str, Any]:
        """A screen behind the table; hand and wheel too where no plant shows them."""
        turn = RotationMatrix.MakeZRotation(-0.35) @ RotationMatrix.MakeXRotation(math.pi / 2)
        drawings: dict[str, Any] = {self.target: self.make_screen(RigidTransform(turn, [1.12, 0.22, 0.5]))}
        if self.physics != "contact":
            drawings[WHEEL] = WheelDrawing(self.config.wheel.mount())
        if self.physics == "ideal":
            spec = self.config.robot.hand
            drawings[HAND] = HandDrawing(lambda state: (hand_pose(spec.full(state)), 0.032))
        return drawings

    def drawn_plant(self) -> Diagram | None:
        """The arm, and in `contact` the wheel."""
        if self.physics == "ideal":
            return None
        world, _ = self.build_world(self._idle_state(), np.zeros(2), 0)
        return world.robot if isinstance(world.robot, Diagram) else None

    def command_range(self) -> tuple[FloatArray, FloatArray]:
        """Angle [rad] and slide [m] that the hand plays in: commands off the knob's way make no sense."""
        reach = self.config.play.reach()
        return -reach, reach

    def command_chart(self) -> CommandChart:
        """Angle and slide that a hand leads the knob to."""
        hand, mount = self.config.robot.hand, self.config.wheel.mount()
        return CommandChart(self.hand_for_wheel, lambda state: mount.wheel_from_knob(hand.full(state)[..., :3]))

    def hand_for_wheel(self, wheel: FloatArray) -> FloatArray:
        """Hand state (exposed variables) at the knob: for start states, and the scripted person's skill.

        Args:
            wheel: angle [rad] and slide [m], shape (..., 2).
        """
        knob = self.config.wheel.mount().knob_from_wheel(wheel)
        full = np.zeros((*knob.shape[:-1], 7))
        full[..., :3], full[..., 6] = knob, 1.0
        return self.config.robot.hand.reduce(full)

    def seats(self) -> Mapping[str, Seat]:
        """The wheel, held by the person and not by the arm; and the hand at it, in the scenario's physics."""
        plain = copy.copy(self)
        plain.physics = "ideal"
        reach = self.config.play.reach()
        wheel = PlaceSeat(
            WHEEL,
            lambda run: self.build_world(self._idle_state(), np.zeros(2), run, "ideal"),
            plain.drawings,
            lambda: None,
            (WHEEL, self.target),
            (
                Axis("steering", ("ArrowRight", "ArrowLeft"), ("right", "left"), 0, -1.0),
                Axis("speed", ("ArrowDown", "ArrowUp"), ("slower", "faster"), 1, -1.0),
            ),
            place=lambda axes: self.hand_for_wheel(reach * axes),
        )
        hand = replace(
            wheel,
            name=HAND,
            world=lambda run: self.build_world(self._idle_state(), np.zeros(2), run),
            drawings=self.drawings,
            plant=self.drawn_plant,
            objects=(HAND, WHEEL, self.target),
        )
        return {WHEEL: wheel, HAND: hand}

    def make_world(self, path: TimedPath, run: int) -> tuple[World, Prepare]:
        """On the path's first point, along it, at its nominal speed; the wheel straight, the column as configured."""
        rng = np.random.default_rng([self.seed, run, _TARGET_ID])
        spread = _START_SPREAD * self.target_length * min(1.0, self.config.noise.scale)
        x, y = path.points[0] + spread * rng.standard_normal(2)
        speed = 0.0 if self.config.start.at_rest else float(path.speed[0])
        heading = float(np.arctan2(np.sin(path.direction[0]), np.cos(path.direction[0])))
        state = self.start_state(float(x), float(y), heading, speed)
        return self.build_world(state, np.array([0.0, self.config.start.slide]), run)

    def build_world(
        self, state: FloatArray, wheel: FloatArray, run: int, physics: str | None = None
    ) -> tuple[World, Prepare]:
        """A world in any start state.

        Args:
            state: of what the wheel drives, shape (n_variables,).
            wheel: angle [rad] and slide [m] at start, shape (2,).
            run: number of the run; keys its noise.
            physics: in place of the scenario's.
        """
        physics = physics or self.physics
        config, mount = self.config, self.config.wheel.mount()
        seed = self.seed * _RUNS_PER_SEED + run
        # The knob's spin undoes the turn: a hand of constant orientation holds it.
        joints = {"slide": float(wheel[1]), "turn": float(wheel[0]), "spin": -float(wheel[0])}
        body = BodySpec(_WHEEL_FILE, Transform(translation=[*mount.center[:2], mount.center[2] - 0.12]), joints=joints)
        robot = build_robot(config.robot, physics, {WHEEL: body}, seed, _HAND_ID)  # type: ignore[arg-type]
        has_body = isinstance(robot, ArmRobot) and physics == "contact"
        scale = config.noise.scale
        objects = {
            WHEEL: Wheel(
                WHEEL,
                {HAND: self.graph.objects[HAND]},
                np.asarray(wheel, dtype=float),
                ObjectSettings(_WHEEL_ID, seed, scale, body_size=robot.body_size(WHEEL) if has_body else 0),  # type: ignore[union-attr]
                mount,
            ),
            self.target: self.make_target(state, ObjectSettings(_TARGET_ID, seed, scale)),
        }
        world = World(self.graph, robot, objects)
        hand = config.robot.hand.full(self.hand_for_wheel(np.asarray(wheel, dtype=float)))

        def prepare(context: Context) -> None:
            robot.set_hand(context, hand)

        return world, prepare

    def _idle_state(self) -> FloatArray:
        """In the middle of the plane, slowly ahead."""
        return self.start_state(self.size[0] / 2, self.size[1] / 2, 0.5, self.driver.speeds[0])

    def record_demonstrations(
        self, progress: Progress | None = None, known: Collection[str] = ()
    ) -> Iterator[Demonstration]:
        """Link one: the hand plays with the wheel. Link two: a scripted driver, standing in for a person, is watched.

        The driver turns the wheel himself, without the arm. The drive is recorded even if its link is known: validation
        paths are cut out of it.

        Args:
            progress: called with a line before each piece.
            known: names of interactions that need no demonstration.
        """
        count = self.config.learning.samples
        if f"{HAND}->{WHEEL}" not in known:
            if progress:
                progress(f"{HAND}->{WHEEL}: playing with the wheel, {count} hand positions ({self.physics})")
            yield self.record_play(count)
        if progress:
            progress(f"{WHEEL}->{self.target}: watching a scripted driver at the wheel, {count} transitions")
        yield self.record_drive(count, "ideal", (WHEEL, self.target))

    def record_play(self, count: int) -> Demonstration:
        """The hand tries places of the knob by itself (paper sec. IV).

        One more than asked for: in the first tick the grasp is not yet known to hold.
        """
        count += 1
        play = self.config.play
        player = WheelPlayer(self.hand_for_wheel, play.reach(), play.step(), count, [self.seed, 1])
        world, prepare = self.build_world(self._idle_state(), np.zeros(2), 901)
        return record(world, prepare, player, count, (HAND, WHEEL), "play")

    def record_drive(
        self, count: int, physics: str | None = None, objects: tuple[str, ...] = (), run: int = 902
    ) -> Demonstration:
        """The scripted driver wanders over the plane.

        Args:
            count: transitions.
            physics: in place of the scenario's.
            objects: whose measurements are recorded; all by default.
            run: keys noise and driver.
        """
        driven = (self.target, self.graph.objects[self.target].observable)
        driver = WheelDriver(self.hand_for_wheel, driven, self.size, self.driver, count, [self.seed, run])
        world, prepare = self.build_world(self._idle_state(), np.zeros(2), run, physics)
        return record(world, prepare, driver, count, objects or tuple(self.graph.objects), "drive")

    def held_out_wanted(self, count: int) -> FloatArray:
        """Wheel states to ask for when the first link is measured: a random walk that no demonstration shares.

        Args:
            count: how many.

        Returns:
            Angle [rad] and slide [m], shape (count, 2), that change by at most 18 deg and 8 mm from one to the next.
        """
        return random_walk(self.config.play.reach(), _HELD_OUT_STEP, count, np.random.default_rng([self.seed, 905]))

    def monolithic_demonstration(self, count: int) -> Demonstration:
        """The driver again, but with the robot's hand, in this scenario's physics."""
        return self.record_drive(count, None, (HAND, self.target), 903)


def _check_numbers(config: WheelDriveConfig) -> None:
    """Refuse numbers that would fail later, in the middle of a run.

    Raises:
        InputError: naming the key.
    """
    config.wheel.mount()
    play = config.play
    for key, value, most, unit in (
        ("wheel.radius", config.wheel.radius, math.inf, "metres"),
        ("wheel.knob", config.wheel.knob, math.inf, "metres"),
        ("play.angle_deg", play.angle_deg, 140.0, "degrees"),
        ("play.slide", play.slide, TRAVEL, "metres"),
        ("play.step_deg", play.step_deg, math.inf, "degrees"),
        ("play.step_slide", play.step_slide, math.inf, "metres"),
    ):
        if not (0 < value <= most and math.isfinite(value)):
            limit = "" if math.isinf(most) else f" and up to {most:g}"
            raise InputError(f"{key} is {value}; give a number above 0{limit}, in {unit}")
    if not abs(config.start.slide) <= TRAVEL:
        raise InputError(f"start.slide is {config.start.slide}; give metres from {-TRAVEL} to {TRAVEL}")
