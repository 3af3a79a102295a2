"""What scenarios share in which the hand plays a game with a joystick: hand -> joystick -> what the game is about.

The link hand -> joystick is the same in all of them, so that a library with it serves them all.
"""

import copy
import math
from abc import abstractmethod
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from pydrake.common.schema import Rotation, Transform
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix
from pydrake.systems.framework import Context, Diagram

from ichain_drake.control.path import PathLimits
from ichain_drake.demonstrations.table import Demonstration
from ichain_drake.errors import InputError
from ichain_drake.graph import InteractionGraph, Origin
from ichain_drake.objects import Joystick, JoystickMount, ObjectSettings, WorldObject
from ichain_drake.objects.joystick import FULL_TILT, JoystickDrawing, axes_from_tilt, tilt_from_axes
from ichain_drake.robot import BodySpec, RobotSpec, SphereSurface, build_robot, hand_pose
from ichain_drake.robot.arm import ArmRobot
from ichain_drake.robot.hand import FRAME as HAND_FRAME
from ichain_drake.scenarios.base import PathScenario, Progress
from ichain_drake.scenarios.car_game_demonstrations import Player
from ichain_drake.scenarios.config import PathConfig, ScenarioConfig
from ichain_drake.scenarios.episode import Prepare
from ichain_drake.scenarios.recorder import record
from ichain_drake.scenarios.seats import PlaceSeat, Seat
from ichain_drake.state import FloatArray, StateSpace
from ichain_drake.timing import TICK
from ichain_drake.visualization import Axis, GameScreen, HandDrawing
from ichain_drake.world.world import World

HAND, JOYSTICK = "hand", "joystick"
HAND_ID, JOYSTICK_ID, TARGET_ID = 0, 1, 2
_JOYSTICK_FILE = "package://ichain_drake_models/joystick/joystick.sdf"
_RUNS_PER_SEED = 1000
_WANTED_STEP = math.radians(15.0)


@dataclass
class MountConfig:
    """Where the joystick stands.

    Attributes:
        pivot: where it is declared to be, see `JoystickMount` [m]: the hand's sphere, its play and its home are about
            it, and the link to it is learned relative to it.
        offset: x, y of where it really is, relative to `pivot` [m]; nobody is told.
        yaw_deg: rotation about the vertical [deg]; nobody is told.
        handle: [m].
    """

    pivot: list[float] = field(default_factory=lambda: [0.5, 0.0, 0.05])
    offset: list[float] = field(default_factory=lambda: [0.0, 0.0])
    yaw_deg: float = 0.0
    handle: float = 0.1

    def origin(self) -> Origin:
        """Where it is declared to be.

        Raises:
            InputError: if the pivot does not have three coordinates.
        """
        if len(self.pivot) != 3 or not all(math.isfinite(v) for v in self.pivot):
            raise InputError(f"joystick.pivot is {self.pivot}; give x, y, z in metres")
        return Origin(HAND_FRAME, (self.pivot[0], self.pivot[1], self.pivot[2]))

    def mount(self) -> JoystickMount:
        """Where it really is.

        Raises:
            InputError: if pivot or offset do not have three and two coordinates, or the yaw is no angle.
        """
        x, y, z = self.origin().position
        if len(self.offset) != 2 or not all(math.isfinite(v) for v in self.offset):
            raise InputError(f"joystick.offset is {self.offset}; give x, y in metres")
        if not math.isfinite(self.yaw_deg):
            raise InputError(f"joystick.yaw_deg is {self.yaw_deg}; give degrees")
        return JoystickMount((x + self.offset[0], y + self.offset[1], z), math.radians(self.yaw_deg), self.handle)


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
        at_rest: whether what is driven stands; otherwise it has the path's nominal speed.
    """

    axes: list[float] = field(default_factory=lambda: [0.0, 0.4])
    at_rest: bool = False


@dataclass
class JoystickGameConfig(ScenarioConfig):
    """Configuration of a game with a joystick."""

    robot: RobotSpec = field(default_factory=lambda: RobotSpec(home={}))
    joystick: MountConfig = field(default_factory=MountConfig)
    play: PlayConfig = field(default_factory=PlayConfig)
    start: StartConfig = field(default_factory=StartConfig)
    path: PathConfig = field(default_factory=PathConfig)


class JoystickGame(PathScenario):
    """A hand holds a joystick, the joystick drives the last object of the chain along paths; see `Scenario`."""

    config: JoystickGameConfig

    # What a game provides.

    @abstractmethod
    def target_space(self) -> StateSpace:
        """State space of what the joystick drives."""

    @abstractmethod
    def make_target(self, state: FloatArray, settings: ObjectSettings) -> WorldObject:
        """What the joystick drives, a child of the joystick alone.

        Args:
            state: at the start, shape (n_variables,).
            settings: see `ObjectSettings`.
        """

    @abstractmethod
    def idle_state(self) -> FloatArray:
        """A state at rest, away from everything, shape (n_variables,)."""

    @abstractmethod
    def make_screen(self, X_WS: RigidTransform) -> GameScreen:
        """The drawing of the game, given the screen's pose in the world."""

    @abstractmethod
    def record_drive(
        self, count: int, physics: str | None = None, objects: tuple[str, ...] = (), run: int = 902
    ) -> Demonstration:
        """A scripted driver, in place of a person.

        Args:
            count: transitions.
            physics: in place of the scenario's.
            objects: whose measurements are recorded; all by default.
            run: keys noise and driver.
        """

    # What they share.

    def make_graph(self) -> InteractionGraph:
        """A chain: the hand, the joystick, and what it drives; where the joystick stands is declared."""
        _check_numbers(self.config)  # before the hand is brought anywhere
        origin = self.config.joystick.origin()
        _bring_hand_to(self.config, origin.position)
        spaces = {
            HAND: self.config.robot.hand.space,
            JOYSTICK: Joystick.state_space,
            self.target: self.target_space(),
        }
        return InteractionGraph(spaces, [(HAND, JOYSTICK), (JOYSTICK, self.target)], {JOYSTICK: origin})

    def path_limits(self) -> PathLimits:
        """From the configuration."""
        return self.config.path.limits()

    def robot_seconds(self) -> Mapping[str, float]:
        """The hand's play takes the robot's time; watching a person drive does not (paper sec. I)."""
        return {f"{HAND}->{JOYSTICK}": self.config.learning.samples * TICK, f"{JOYSTICK}->{self.target}": 0.0}

    def drawings(self) -> Mapping[str, Any]:
        """The game's screen behind the table; hand and joystick too where no plant shows them."""
        turn = RotationMatrix.MakeZRotation(-0.35) @ RotationMatrix.MakeXRotation(math.pi / 2)
        drawings: dict[str, Any] = {self.target: self.make_screen(RigidTransform(turn, [1.12, 0.22, 0.5]))}
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
        world, _ = self.build_world(self.idle_state(), self.config.start.axes, 0)
        return world.robot if isinstance(world.robot, Diagram) else None

    def command_range(self) -> tuple[FloatArray, FloatArray]:
        """The square that the hand plays in."""
        middle, reach = np.array(self.config.joystick.pivot[:2]), self.config.play.reach
        return middle - reach, middle + reach

    def seats(self) -> Mapping[str, Seat]:
        """The stick, held by the person and not by the arm; and the hand, in the scenario's physics."""
        plain = copy.copy(self)
        plain.physics = "ideal"
        stick = PlaceSeat(
            JOYSTICK,
            lambda run: self.build_world(self.idle_state(), [0.0, 0.0], run, "ideal"),
            plain.drawings,
            lambda: None,
            (JOYSTICK, self.target),
            (
                Axis("steering", ("ArrowLeft", "ArrowRight"), ("left", "right"), 0),
                Axis("throttle", ("ArrowDown", "ArrowUp"), ("brake", "go"), 1, -1.0),
            ),
            place=lambda axes: self.hand_for_tilt(FULL_TILT * axes),
        )
        return {JOYSTICK: stick, **super().seats()}

    def build_world(
        self, state: FloatArray, axes: FloatArray | list[float], run: int, physics: str | None = None
    ) -> tuple[World, Prepare]:
        """A world in any start state.

        Args:
            state: of what the joystick drives, shape (n_variables,).
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
        robot = build_robot(config.robot, physics, {JOYSTICK: body}, seed, HAND_ID)  # type: ignore[arg-type]
        has_body = isinstance(robot, ArmRobot) and physics == "contact"
        scale = config.noise.scale
        objects = {
            JOYSTICK: Joystick(
                JOYSTICK,
                {HAND: self.graph.objects[HAND]},
                Joystick.state_at_tilt(tilt),
                ObjectSettings(JOYSTICK_ID, seed, scale, body_size=robot.body_size(JOYSTICK) if has_body else 0),  # type: ignore[union-attr]
                mount,
            ),
            self.target: self.make_target(state, ObjectSettings(TARGET_ID, seed, scale)),
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
            progress(f"{JOYSTICK}->{self.target}: a scripted driver at the stick, {count} transitions")
        yield self.record_drive(count, physics="ideal", objects=(JOYSTICK, self.target))

    def record_play(self, count: int) -> Demonstration:
        """The hand tries positions around the joystick by itself (paper sec. IV).

        One more than asked for: in the first tick the grasp is not yet known to hold.
        """
        count += 1
        middle = np.array(self.config.joystick.pivot[:2])
        player = Player(middle, self.config.play.reach, self.config.play.step, count, [self.seed, 1])
        world, prepare = self.build_world(self.idle_state(), [0.0, 0.0], 901)
        return record(world, prepare, player, count, (HAND, JOYSTICK), "play")

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
        return self.record_drive(count, None, (HAND, self.target), 903)


def _bring_hand_to(config: JoystickGameConfig, pivot: Sequence[float]) -> None:
    """What the configuration leaves open about the hand: it keeps to the knob's sphere, within the stick's length."""
    robot, handle = config.robot, config.joystick.handle
    if robot.hand.surface is None:
        robot.hand.surface = SphereSurface(list(pivot), handle)
    for axis, middle in zip("xy", pivot[:2], strict=True):
        robot.home.setdefault(axis, middle)
        robot.hand.bounds.setdefault(axis, [middle - handle, middle + handle])


def _check_numbers(config: JoystickGameConfig) -> None:
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
