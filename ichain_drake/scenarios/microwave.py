"""The microwave oven (paper sec. V, fig. 5): hand, door, on/off button, power knob and food.

Given: the places of things (`MicrowaveLayout`), the camera's frame and the spread of starts, as in
`models/scenarios/microwave.yaml`. Everything else is learned.
"""

import dataclasses
import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
from pydrake.common.schema import Transform
from pydrake.math import RigidTransform
from pydrake.systems.framework import Context, Diagram

from ichain_drake.demonstrations.table import Demonstration
from ichain_drake.errors import InputError
from ichain_drake.graph import InteractionGraph
from ichain_drake.objects.base import ObjectSettings
from ichain_drake.objects.camera import CameraFrame
from ichain_drake.objects.food import Food, FoodSettings
from ichain_drake.objects.oven_drawings import DialDrawing, DoorDrawing, FoodDrawing, PushDrawing
from ichain_drake.objects.oven_part import Dial, SlidingPart
from ichain_drake.robot import BodySpec, RobotSpec, build_robot, hand_pose
from ichain_drake.robot.arm import ArmRobot
from ichain_drake.scenarios.adjustable import Adjustable
from ichain_drake.scenarios.adjustable_goal import least_wanted
from ichain_drake.scenarios.base import Progress, Scenario
from ichain_drake.scenarios.commands import Commands
from ichain_drake.scenarios.config import ScenarioConfig
from ichain_drake.scenarios.episode import Prepare
from ichain_drake.scenarios.microwave_demonstrations import script_pieces
from ichain_drake.scenarios.microwave_layout import LAYOUT, MicrowaveStart
from ichain_drake.scenarios.microwave_motion import OvenMotion
from ichain_drake.scenarios.microwave_teleoperation import HOLD
from ichain_drake.scenarios.recorder import record
from ichain_drake.scenarios.seats import Seat, hand_seat
from ichain_drake.visualization import Camera, HandDrawing
from ichain_drake.world.world import World

HAND, DOOR, BUTTON, KNOB, FOOD = "hand", "door", "button", "knob", "food"
_IDS = {HAND: 0, DOOR: 1, BUTTON: 2, KNOB: 3, FOOD: 4}
_MODELS = "package://ichain_drake_models/microwave"
_RUNS_PER_SEED = 1000
_FIRST_DEMONSTRATION = 900  # runs of an evaluation are below: the script's noise is never theirs
_STARTS, _SCRIPTS = 0, 1  # purposes of random numbers


@dataclass
class OvenStartConfig:
    """How a run begins.

    Attributes:
        food: middle of the places where the food may stand, x, y in the robot's frame [m].
        spread: how far from there along x and y [m].
        temperature: of the food, from, to.
        knob: angle, from, to [rad].
    """

    food: list[float] = field(default_factory=lambda: [0.63, -0.28])
    spread: list[float] = field(default_factory=lambda: [0.012, 0.025])
    temperature: list[float] = field(default_factory=lambda: [0.0, 0.2])
    knob: list[float] = field(default_factory=lambda: [0.0, 0.08])


@dataclass
class MicrowaveConfig(ScenarioConfig):
    """Configuration of the microwave oven.

    Attributes:
        goal: what `run` and `plan` ask for where the command line says nothing else; see `make_goal`.
        camera_shift: the robot frame's origin in the camera frame [m].
        start: see there.
    """

    goal: list[str] = field(default_factory=list)
    camera_shift: list[float] = field(default_factory=lambda: [0.03, -0.02, -0.05])
    start: OvenStartConfig = field(default_factory=OvenStartConfig)


class Microwave(Scenario):
    """See the module's description and `Scenario`."""

    name: ClassVar[str] = "microwave"
    config_class: ClassVar[type[ScenarioConfig]] = MicrowaveConfig
    features: ClassVar[tuple[str, ...]] = ("camera",)
    config: MicrowaveConfig

    def make_graph(self) -> InteractionGraph:
        """The seven interactions of paper fig. 5."""
        _check(self.config)
        objects = {
            HAND: self.config.robot.hand.space,
            DOOR: SlidingPart.make_space(LAYOUT.door),
            BUTTON: SlidingPart.make_space(LAYOUT.button),
            KNOB: Dial.make_space(LAYOUT.knob),
            FOOD: Food.state_space,
        }
        by_hand = [(HAND, child) for child in (DOOR, BUTTON, KNOB, FOOD)]
        return InteractionGraph(objects, [*by_hand, *((part, FOOD) for part in (KNOB, BUTTON, DOOR))])

    def camera(self) -> CameraFrame:
        """The camera's frame."""
        x, y, z = self.config.camera_shift
        return CameraFrame(math.radians(self.config.camera.yaw_deg), (x, y, z))

    def food_settings(self) -> FoodSettings:
        """Geometry of the food and of what it meets."""
        return LAYOUT.food_settings(self.camera())

    def start(self, run: int) -> MicrowaveStart:
        """The start of a run: the food's place and temperature and the knob's angle vary; the oven is open and off.

        Args:
            run: number of the run.
        """
        rng, config = np.random.default_rng([self.seed, _STARTS, run]), self.config.start
        place = np.array(config.food) + rng.uniform(-1.0, 1.0, 2) * config.spread
        spec = self.config.robot
        return MicrowaveStart(
            (float(place[0]), float(place[1])),
            float(rng.uniform(config.temperature[0], config.temperature[1])),
            door=LAYOUT.door.travel,
            knob=float(rng.uniform(config.knob[0], config.knob[1])),
            hand=tuple(spec.hand.reduce(spec.home_hand()).tolist()),
        )

    def make_world(self, run: int) -> tuple[World, Prepare]:
        """The world of a run.

        Args:
            run: number of the run; keys its start and noise.
        """
        return self.build_world(self.start(run), run)

    def build_world(self, start: MicrowaveStart, run: int, physics: str | None = None) -> tuple[World, Prepare]:
        """A world in any start state.

        Args:
            start: see `MicrowaveStart`.
            run: keys noise.
            physics: in place of the scenario's.
        """
        physics, config = physics or self.physics, self.config
        seed, scale = self.seed * _RUNS_PER_SEED + run, config.noise.scale
        robot = build_robot(self._robot_spec(), physics, self._bodies(start), seed, _IDS[HAND])  # type: ignore[arg-type]

        def settings(name: str) -> ObjectSettings:
            has_body = isinstance(robot, ArmRobot) and physics == "contact"
            return ObjectSettings(_IDS[name], seed, scale, (), robot.body_size(name) if has_body else 0)  # type: ignore[union-attr]

        spaces = self.graph.objects
        parents = {name: {p: spaces[p] for p in self.graph.parents(name)} for name in spaces}
        hand_only = {HAND: spaces[HAND]}
        places = {
            DOOR: SlidingPart(DOOR, hand_only, LAYOUT.door).state_at(start.door),
            BUTTON: SlidingPart(BUTTON, hand_only, LAYOUT.button).state_at(start.button),
            KNOB: Dial(KNOB, hand_only, LAYOUT.knob).state_at(start.knob),
        }
        food = Food(FOOD, parents[FOOD], None, settings(FOOD), self.food_settings())
        at = food.state_at((*start.food, self._floor(start) + self.food_settings().height / 2), start.temperature)
        objects = {
            DOOR: SlidingPart(DOOR, hand_only, LAYOUT.door, places[DOOR], settings(DOOR)),
            BUTTON: SlidingPart(BUTTON, hand_only, LAYOUT.button, places[BUTTON], settings(BUTTON)),
            KNOB: Dial(KNOB, hand_only, LAYOUT.knob, places[KNOB], settings(KNOB)),
            FOOD: Food(FOOD, parents[FOOD], at, settings(FOOD), self.food_settings()),
        }
        world = World(self.graph, robot, objects)
        hand = config.robot.hand.full(np.array(start.hand))

        def prepare(context: Context) -> None:
            robot.set_hand(context, hand)

        return world, prepare

    def _floor(self, start: MicrowaveStart) -> float:
        return LAYOUT.cavity[2] if start.inside else 0.0

    def _robot_spec(self) -> RobotSpec:
        """The robot with its sensor noise at this run's scale."""
        hand = self.config.robot.hand
        noise = {name: self.config.noise.scale * std for name, std in hand.noise_std.items()}
        return dataclasses.replace(self.config.robot, hand=dataclasses.replace(hand, noise_std=noise))

    def _bodies(self, start: MicrowaveStart) -> dict[str, BodySpec]:
        half = self.food_settings().height / 2
        food = Transform(translation=[start.food[0], start.food[1], self._floor(start) + half])

        def part(file: str, name: str, at: float) -> BodySpec:
            mount = {DOOR: LAYOUT.door, BUTTON: LAYOUT.button, KNOB: LAYOUT.knob}[name]
            return BodySpec(f"{_MODELS}/{file}.sdf", Transform(translation=list(mount.point)), joints={"move": at})

        return {
            DOOR: part("door", DOOR, start.door),
            BUTTON: part("button", BUTTON, start.button),
            KNOB: part("knob", KNOB, start.knob),
            FOOD: BodySpec(f"{_MODELS}/food.sdf", food, fixed=False),
        }

    def make_motion(self) -> OvenMotion | None:
        """Ways of the hand around the oven; in `ideal` a point hits nothing.

        Given beside the models: food is held at its middle.
        """
        if self.physics == "ideal":
            return None
        spec = self.config.robot
        grasp = hand_pose(spec.hand.full(np.array([0.0, 0.0, 0.0, 0.0, 1.0])))
        middle = RigidTransform([0.0, 0.0, self.food_settings().height / 2 - HOLD])

        def bodies(door: float) -> dict[str, BodySpec]:
            return self._bodies(MicrowaveStart((0.0, 0.0), 0.0, door=door))

        return OvenMotion(spec, bodies, DOOR, self.start(0).door, {FOOD: grasp.inverse() @ middle})

    def record_demonstrations(
        self, progress: Progress | None = None, known: Collection[str] = ()
    ) -> Iterator[Demonstration]:
        """Short, unordered pieces that a script, standing in for a person, tele-operates.

        Args:
            progress: called with a line before each piece.
            known: names of interactions that need no demonstration. A piece shows several, so that all are recorded
                unless every interaction is known.
        """
        if {e.name for e in self.graph.interactions} <= set(known):
            return
        rng = np.random.default_rng([self.seed, _SCRIPTS])
        for number, piece in enumerate(script_pieces(rng, bodies=self.physics == "contact")):
            ticks = len(piece.commands)
            if progress:
                progress(f"{piece.name}: {ticks} ticks ({self.physics})")
            world, prepare = self.build_world(piece.start, _FIRST_DEMONSTRATION + number)
            yield record(world, prepare, Commands(piece.commands), ticks, tuple(self.graph.objects), piece.name)

    def drawings(self) -> Mapping[str, Any]:
        """Food and the oven's parts; the oven's body and the hand too where no plant shows them."""
        plain, solid = self.physics == "ideal", self.physics != "contact"
        on_from = self.food_settings().oven.on_from
        drawings: dict[str, Any] = {
            BUTTON: PushDrawing(LAYOUT.button, on_from, cap=solid),
            KNOB: DialDrawing(LAYOUT.knob, knob=solid),
            FOOD: FoodDrawing(self.food_settings(), block=solid),
        }
        if solid:
            _, y0, z0, _, y1, z1 = LAYOUT.cavity
            panel = (LAYOUT.front - 0.02, y0, z0 + 0.002, LAYOUT.front - 0.002, y1, z1 - 0.002)
            drawings[DOOR] = DoorDrawing(LAYOUT.door, panel, LAYOUT.boxes if plain else ())
        if plain:
            spec = self.config.robot.hand
            grip = spec.space.index("grip")
            drawings[HAND] = HandDrawing(lambda state: (hand_pose(spec.full(state)), 0.08 - 0.05 * round(state[grip])))
        return drawings

    def view(self) -> Camera:
        """From the arm's left shoulder."""
        return Camera((-0.1, -1.0, 0.75), (0.62, 0.02, 0.12), 32.0)

    def drawn_plant(self) -> Diagram | None:
        """The arm and the oven, in `contact` with its parts and the food."""
        if self.physics == "ideal":
            return None
        world, _ = self.build_world(self.start(0), 0)
        return world.robot if isinstance(world.robot, Diagram) else None

    def adjustables(self) -> Sequence[Adjustable]:
        """Noise, and how hot the food is wanted."""
        return (*super().adjustables(), least_wanted(FOOD, "temperature", 0.0, 1.0, 0.8))

    def seats(self) -> Mapping[str, Seat]:
        """The hand."""
        return {HAND: hand_seat(self, lambda run: self.build_world(self.start(run), run))}

    def given(self) -> dict[str, Any]:
        """The configuration and the layout."""
        return super().given() | {"layout": dataclasses.asdict(LAYOUT), "food_in_hand": {"height": HOLD}}


def _check(config: MicrowaveConfig) -> None:
    for key, values, size in (
        ("camera_shift", config.camera_shift, 3),
        ("start.food", config.start.food, 2),
        ("start.spread", config.start.spread, 2),
        ("start.temperature", config.start.temperature, 2),
        ("start.knob", config.start.knob, 2),
    ):
        if len(values) != size or not np.isfinite(values).all():
            raise InputError(f"microwave: {key} is {values}; give {size} numbers")
    for key, values, most in (
        ("start.temperature", config.start.temperature, 1.0),
        ("start.knob", config.start.knob, LAYOUT.knob.travel),
    ):
        if not 0.0 <= values[0] <= values[1] <= most:
            raise InputError(f"microwave: {key} is {values}; give from and to within 0..{most:g}")
