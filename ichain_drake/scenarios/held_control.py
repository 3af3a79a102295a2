"""What scenarios share in which the hand holds a control that drives something: hand -> control -> what it drives.

A control is a joystick or a steering wheel: an object of two variables that is held all the time. What it drives, the
last object of the chain, follows paths in the plane.
"""

from __future__ import annotations

import copy
import math
from abc import abstractmethod
from collections.abc import Collection, Iterator, Mapping
from typing import Any, ClassVar

import numpy as np
from PIL import Image
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.systems.framework import Diagram, LeafSystem

from ichain_drake.control.tracking.path import PathLimits, TimedPath
from ichain_drake.demonstrations.table import Demonstration
from ichain_drake.graph import InteractionGraph, Origin
from ichain_drake.objects import ObjectSettings, WorldObject
from ichain_drake.robot import BodySpec, Physics, build_robot, hand_pose
from ichain_drake.robot.arm import ArmRobot
from ichain_drake.robot.hand import FRAME as HAND_FRAME
from ichain_drake.scenarios.base import READING_NOISE, PathScenario, Progress
from ichain_drake.scenarios.held_control_config import HeldControlConfig
from ichain_drake.scenarios.seats import PlaceSeat, Seat
from ichain_drake.simulation.recorder import record
from ichain_drake.state import FloatArray, StateSpace
from ichain_drake.visualization import Axis, Drawing, GameScreen, HandDrawing
from ichain_drake.visualization.sprites import car_sprite
from ichain_drake.world.world import World

HAND = "hand"
SCREEN_WIDTH = 0.8
"""Of the screen that shows what is driven [m]."""

SCREEN_STAND = 0.2
"""Height of its lower edge over the ground [m]."""

_HAND_ID, _CONTROL_ID, _TARGET_ID = 0, 1, 2
_RUNS_PER_SEED = 1000
_PLAY, _DRIVE, _MONOLITHIC = 901, 902, 903  # runs of an evaluation are below: a demonstration's noise is never theirs
_SCREEN = RigidTransform(
    RotationMatrix.MakeZRotation(-0.35) @ RotationMatrix.MakeXRotation(math.pi / 2), [1.12, 0.22, 0.5]
)
"""The screen's pose in the world: behind the table."""


class HeldControl(PathScenario):
    """A hand holds a control, the control drives the last object of a chain along paths; see `Scenario`."""

    control: ClassVar[str]
    """The control's name."""

    control_type: ClassVar[type[WorldObject]]
    """Its class."""

    target_type: ClassVar[type[WorldObject]]
    """Class of what it drives; not needed where `target_space` and `make_target` are overridden."""

    finger_gap: ClassVar[float]
    """Between the fingers of a hand that is drawn holding it [m]."""

    start_spread: ClassVar[float]
    """Standard deviation of where a run starts, in the path's unit."""

    idle_start: ClassVar[tuple[float, float]] = (0.0, 0.0)
    """Heading [rad] and speed of what is driven where nothing is to be followed."""

    drive_start: ClassVar[tuple[float, float] | None] = None
    """The same where the scripted driver begins; None if that is idle too."""

    sprite_length: ClassVar[float] = 44.0
    """Of what is driven, as it is drawn, in the path's unit."""

    ghost_period: ClassVar[float]
    """A faded picture of it stays behind every so often [s]."""

    config: HeldControlConfig

    def __init_subclass__(cls, **more: Any) -> None:
        """What its vehicle declares, it has."""
        super().__init_subclass__(**more)
        if getattr(getattr(cls, "target_type", None), "reading_std", ()) and READING_NOISE not in cls.features:
            cls.features = (*cls.features, READING_NOISE)

    # What the control provides.

    @abstractmethod
    def origin(self) -> tuple[float, float, float]:
        """Where the control is declared to be in the robot's frame [m]; the link to it is learned relative to it."""

    @abstractmethod
    def bring_hand(self) -> None:
        """What the configuration leaves open about the hand."""

    @abstractmethod
    def start_setting(self) -> tuple[FloatArray, bool]:
        """As configured for the start of a run.

        Returns:
            The control's setting, shape (2,), and whether what is driven stands; otherwise it has the path's speed.
        """

    @abstractmethod
    def hand_for_setting(self, setting: FloatArray) -> FloatArray:
        """Hand state (exposed variables) that holds the control at a setting, shape (..., 2) -> (..., n_hand)."""

    @abstractmethod
    def make_body(self, setting: FloatArray) -> BodySpec:
        """The control's body in the arm's plant, set as given, shape (2,)."""

    @abstractmethod
    def make_control(self, setting: FloatArray, settings: ObjectSettings) -> WorldObject:
        """The control, a child of the hand alone.

        Args:
            setting: at the start, shape (2,).
            settings: see `ObjectSettings`.
        """

    @abstractmethod
    def control_drawing(self) -> Drawing:
        """The control, for physics in which no plant holds it."""

    @abstractmethod
    def make_player(self, count: int) -> LeafSystem:
        """What leads the hand while it plays with the control: so many commands."""

    @abstractmethod
    def make_driver(self, count: int, run: int) -> LeafSystem:
        """A scripted driver, in place of a person: so many commands, keyed by `run`."""

    @abstractmethod
    def person_axes(self) -> tuple[Axis, Axis]:
        """What a person who holds the control steers with."""

    @abstractmethod
    def hand_for_axes(self, axes: FloatArray) -> FloatArray:
        """Hand state that holds the control where a person's axes, -1 to 1, shape (2,), are."""

    # What a scenario provides.

    @abstractmethod
    def state_at(self, position: FloatArray, heading: float, speed: float, setting: FloatArray) -> FloatArray:
        """A state of what is driven, shape (n_variables,).

        Args:
            position: in the plane, shape (2,).
            heading: [rad].
            speed: straight ahead.
            setting: of the control, shape (2,).
        """

    # What a scenario may provide.

    def target_space(self) -> StateSpace:
        """State space of what is driven: its class's."""
        return self.target_type.state_space

    def make_target(self, state: FloatArray, settings: ObjectSettings) -> WorldObject:
        """What is driven, a child of the control alone.

        Args:
            state: at the start, shape (n_variables,).
            settings: see `ObjectSettings`.
        """
        parents = {self.control: self.control_type.state_space}
        return self.target_type(self.target, parents, initial=state, settings=settings)

    def sprite(self) -> Image.Image:
        """What is driven from above, pointing to the right: a car."""
        return car_sprite()

    def make_screen(self, X_WS: RigidTransform) -> GameScreen:
        """The drawing of what is driven: the whole plane, 800 mm wide.

        Args:
            X_WS: the screen's pose in the world.
        """
        width, height = (int(length) for length in self.size)
        return GameScreen(
            (width, height),
            SCREEN_WIDTH / width,
            X_WS,
            y_down=self.y_down,
            sprite=self.sprite(),
            sprite_length=self.sprite_length,
            ghost_period=self.ghost_period,
            stand=SCREEN_STAND,
        )

    # What they share.

    def make_graph(self) -> InteractionGraph:
        """A chain: the hand, the control, and what it drives; where the control stands is declared."""
        self.bring_hand()
        spaces = {
            HAND: self.config.robot.hand.space,
            self.control: self.control_type.state_space,
            self.target: self.target_space(),
        }
        edges = [(HAND, self.control), (self.control, self.target)]
        return InteractionGraph(spaces, edges, {self.control: Origin(HAND_FRAME, self.origin())})

    def path_limits(self) -> PathLimits:
        """From the configuration."""
        return self.config.path.limits()

    def drawings(self) -> Mapping[str, Any]:
        """A screen behind the table; hand and control too where no plant shows them."""
        drawings: dict[str, Any] = {self.target: self.make_screen(_SCREEN)}
        if self.physics != "contact":
            drawings[self.control] = self.control_drawing()
        if self.physics == "ideal":
            spec, gap = self.config.robot.hand, self.finger_gap
            drawings[HAND] = HandDrawing(lambda state: (hand_pose(spec.full(state)), gap))
        return drawings

    def drawn_plant(self) -> Diagram | None:
        """The arm, and in `contact` the control."""
        if self.physics == "ideal":
            return None
        world = self.idle_world(0)
        return world.robot if isinstance(world.robot, Diagram) else None

    def seats(self) -> Mapping[str, Seat]:
        """The control, held by the person and not by the arm; and the hand, in the scenario's physics."""
        plain = copy.copy(self)
        plain.physics = "ideal"
        seat = PlaceSeat(
            self.control,
            lambda run: self.idle_world(run, "ideal"),
            plain.drawings,
            lambda: None,
            (self.control, self.target),
            self.person_axes(),
            place=self.hand_for_axes,
        )
        return {self.control: seat, **super().seats()}

    def make_world(self, path: TimedPath, run: int) -> World:
        """On the path's first point, along it, at its nominal speed; the control as configured."""
        rng = np.random.default_rng([self.seed, run, _TARGET_ID])
        start = path.points[0] + self.start_spread * rng.standard_normal(2) * min(1.0, self.config.noise.scale)
        setting, at_rest = self.start_setting()
        heading = float(np.arctan2(np.sin(path.direction[0]), np.cos(path.direction[0])))
        speed = 0.0 if at_rest else float(path.speed[0])
        return self.build_world(self.state_at(start, heading, speed, setting), setting, run)

    def idle_state(self) -> FloatArray:
        """What is driven in the middle of the plane, shape (n_variables,)."""
        return self.state_at(np.array(self.size) / 2, *self.idle_start, np.zeros(2))

    def idle_world(self, run: int, physics: Physics | None = None) -> World:
        """A world in that state, the control in its middle; arguments as `build_world`."""
        return self.build_world(self.idle_state(), np.zeros(2), run, physics)

    def build_world(
        self, state: FloatArray, setting: FloatArray | list[float], run: int, physics: Physics | None = None
    ) -> World:
        """A world whose default context is any start state.

        Args:
            state: of what is driven, shape (n_variables,).
            setting: of the control at start, shape (2,).
            run: number of the run; keys its noise.
            physics: in place of the scenario's.
        """
        physics = physics or self.physics
        setting = np.asarray(setting, dtype=float)
        seed, scale = self.seed * _RUNS_PER_SEED + run, self.config.noise.scale
        hand = self.config.robot.hand.full(self.hand_for_setting(setting))
        robot = build_robot(self.config.robot, physics, {self.control: self.make_body(setting)}, seed, _HAND_ID, hand)
        size = robot.body_size(self.control) if isinstance(robot, ArmRobot) and physics == "contact" else 0
        objects = {
            self.control: self.make_control(setting, ObjectSettings(_CONTROL_ID, seed, scale, body_size=size)),
            self.target: self.make_target(
                state, ObjectSettings(_TARGET_ID, seed, scale, reading_scale=self.config.noise.vehicle)
            ),
        }
        return World(self.graph, robot, objects)

    def record_demonstrations(
        self, progress: Progress | None = None, known: Collection[str] = ()
    ) -> Iterator[Demonstration]:
        """Link one: the hand plays with the control. Link two: a scripted driver, standing in for a person, is watched.

        The driver holds the control himself, without the arm, and moves it as a tick moves the hand. The drive is
        recorded even if its link is known: validation paths are cut out of it.

        Args:
            progress: called with a line before each piece.
            known: names of interactions that need no demonstration.
        """
        count = self.config.learning.samples
        say = progress or (lambda line: None)
        if f"{HAND}->{self.control}" not in known:
            say(f"{HAND}->{self.control}: playing with the {self.control}, {count} hand positions ({self.physics})")
            yield self.record_play(count)
        say(f"{self.control}->{self.target}: watching a scripted driver at the {self.control}, {count} transitions")
        yield self.record_drive(count, "ideal", (self.control, self.target))

    def record_play(self, count: int) -> Demonstration:
        """The hand tries places of the control by itself (paper sec. IV).

        One more than asked for: in the first tick the grasp is not yet known to hold.
        """
        count += 1
        return record(self.idle_world(_PLAY), self.make_player(count), count, (HAND, self.control), "play")

    def record_drive(
        self, count: int, physics: Physics | None = None, objects: tuple[str, ...] = (), run: int = _DRIVE
    ) -> Demonstration:
        """The scripted driver wanders over the plane.

        Args:
            count: transitions.
            physics: in place of the scenario's.
            objects: whose measurements are recorded; all by default.
            run: keys noise and driver.
        """
        setting = np.zeros(2)
        start = self.state_at(np.array(self.size) / 2, *(self.drive_start or self.idle_start), setting)
        world = self.build_world(start, setting, run, physics)
        driver = self.make_driver(count, run)
        return record(world, driver, count, objects or tuple(self.graph.objects), "drive")

    def monolithic_demonstration(self, count: int) -> Demonstration:
        """The driver again, but with the robot's hand, in this scenario's physics."""
        return self.record_drive(count, None, (HAND, self.target), _MONOLITHIC)
