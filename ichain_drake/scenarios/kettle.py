"""Bottle and kettle (paper sec. I): the same two objects act on each other in opposite directions at different times.

A hand pours cold water from the bottle into the kettle, boils it by a switch, and pours it back. Given: the places and
shapes of things (`KettleLayout`), the camera's frame, the spread of starts, and what faults do, as in
`models/scenarios/kettle.yaml`. Everything else is learned.
"""

import dataclasses
import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
from pydrake.common.schema import Transform
from pydrake.systems.framework import Context, Diagram

from ichain_drake.demonstrations.table import Demonstration
from ichain_drake.errors import InputError
from ichain_drake.graph import InteractionGraph
from ichain_drake.objects import (
    Button,
    ButtonMount,
    CameraFrame,
    Cup,
    CupFaults,
    CupSettings,
    Kettle,
    KettleSettings,
    ObjectSettings,
)
from ichain_drake.objects.base import WorldObject
from ichain_drake.objects.dispenser_drawings import ButtonDrawing, CupDrawing
from ichain_drake.objects.kettle_drawings import KettleDrawing, PlateDrawing
from ichain_drake.robot import BodySpec, MotionPlanner, RobotSpec, build_robot, hand_pose
from ichain_drake.robot.arm import ArmRobot
from ichain_drake.scenarios.adjustable import Adjustable, push
from ichain_drake.scenarios.adjustable_goal import least_wanted
from ichain_drake.scenarios.base import Progress, Scenario
from ichain_drake.scenarios.commands import Commands
from ichain_drake.scenarios.config import ScenarioConfig
from ichain_drake.scenarios.episode import Prepare
from ichain_drake.scenarios.kettle_demonstrations import script_pieces
from ichain_drake.scenarios.kettle_layout import LAYOUT, KettleStart, VesselShape
from ichain_drake.scenarios.recorder import record
from ichain_drake.scenarios.seats import Seat, hand_seat
from ichain_drake.scenarios.standing_motion import StandingMotion
from ichain_drake.scenarios.water_dispenser import MishapConfig
from ichain_drake.visualization import Camera, HandDrawing
from ichain_drake.world.world import World

HAND, BOTTLE, KETTLE, SWITCH = "hand", "bottle", "kettle", "switch"
_IDS = {HAND: 0, BOTTLE: 1, KETTLE: 2, SWITCH: 3}
_SHAPES = {BOTTLE: LAYOUT.bottle, KETTLE: LAYOUT.kettle}
_MODELS = "package://ichain_drake_models"
_BODY = 0.13  # height of the kettle's body [m]
_RUNS_PER_SEED = 1000
_FIRST_DEMONSTRATION = 900  # runs of an evaluation are below: the script's noise is never theirs
_STARTS, _MISHAPS, _SCRIPTS = 0, 1, 2  # purposes of random numbers
_RED = (0.9, 0.12, 0.05)


@dataclass
class KettleStartConfig:
    """How a run begins.

    Attributes:
        bottle, kettle: middle of the places where they may stand, x, y in the robot's frame [m].
        spread: how far from there, along x and y [m].
        water, temperature: of the bottle, from, to.
    """

    bottle: list[float] = field(default_factory=lambda: [0.70, -0.15])
    kettle: list[float] = field(default_factory=lambda: [0.735, 0.13])
    spread: float = 0.005
    water: list[float] = field(default_factory=lambda: [0.7, 0.95])
    temperature: list[float] = field(default_factory=lambda: [0.0, 0.2])


@dataclass
class KettleConfig(ScenarioConfig):
    """Configuration of the kettle.

    Attributes:
        goal: what `run` and `plan` ask for where the command line says nothing else; see `make_goal`.
        camera_shift: the robot frame's origin in the camera frame [m].
        start, mishap: see there; slips and drop-outs meet both vessels, knocks the bottle.
    """

    goal: list[str] = field(default_factory=list)
    camera_shift: list[float] = field(default_factory=lambda: [0.03, -0.02, -0.05])
    start: KettleStartConfig = field(default_factory=KettleStartConfig)
    mishap: MishapConfig = field(default_factory=MishapConfig)


class KettleScenario(Scenario):
    """See the module's description and `Scenario`."""

    name: ClassVar[str] = "kettle"
    config_class: ClassVar[type[ScenarioConfig]] = KettleConfig
    faults: ClassVar[tuple[str, ...]] = ("none", "slip", "knock", "stiff", "dropout")
    features: ClassVar[tuple[str, ...]] = ("camera",)
    config: KettleConfig

    def make_graph(self) -> InteractionGraph:
        """Six interactions; bottle and kettle act on each other."""
        _check(self.config)
        if self.physics == "contact" and self.config.fault.kind in ("slip", "knock"):
            raise InputError(
                f"fault.kind {self.config.fault.kind}: in contact the plant moves the vessels; choose ideal or arm"
            )
        objects = {
            HAND: self.config.robot.hand.space,
            BOTTLE: Cup.space([KETTLE]),
            KETTLE: Kettle.space([BOTTLE]),
            SWITCH: Button.state_space,
        }
        by_hand = [(HAND, BOTTLE), (HAND, KETTLE), (HAND, SWITCH)]
        return InteractionGraph(objects, [*by_hand, (BOTTLE, KETTLE), (KETTLE, BOTTLE), (SWITCH, KETTLE)])

    def camera(self) -> CameraFrame:
        """The camera's frame."""
        x, y, z = self.config.camera_shift
        return CameraFrame(math.radians(self.config.camera.yaw_deg), (x, y, z))

    def bottle_settings(self, faults: CupFaults | None = None) -> CupSettings:
        """Geometry of the bottle and of what it meets."""
        return self._vessel(LAYOUT.bottle, {KETTLE: LAYOUT.return_region()}, faults)

    def kettle_settings(self, faults: CupFaults | None = None) -> tuple[CupSettings, KettleSettings]:
        """Geometry of the kettle and of what it meets; its plate."""
        settings = self._vessel(LAYOUT.kettle, {BOTTLE: LAYOUT.pour_region()}, faults)
        return settings, KettleSettings(LAYOUT.plate_region(), SWITCH)

    def _vessel(self, shape: VesselShape, inlets: Mapping[str, Any], faults: CupFaults | None) -> CupSettings:
        return CupSettings(
            height=shape.height,
            radius=shape.radius,
            mouth=shape.mouth,
            grasp=shape.grasp(),
            outlets={},
            inlets=inlets,
            surfaces=(LAYOUT.plate, LAYOUT.console),
            camera=self.camera(),
            faults=faults or CupFaults(),
        )

    def start(self, run: int) -> KettleStart:
        """The start of a run: places and the bottle's content vary, the kettle is empty and cold.

        Args:
            run: number of the run.
        """
        rng, config = np.random.default_rng([self.seed, _STARTS, run]), self.config.start
        bottle, kettle = (
            np.array(p) + rng.uniform(-1.0, 1.0, 2) * config.spread for p in (config.bottle, config.kettle)
        )
        spec = self.config.robot
        return KettleStart(
            (float(bottle[0]), float(bottle[1])),
            (float(kettle[0]), float(kettle[1])),
            float(rng.uniform(config.water[0], config.water[1])),
            float(rng.uniform(config.temperature[0], config.temperature[1])),
            hand=tuple(spec.hand.reduce(spec.home_hand()).tolist()),
        )

    def make_world(self, run: int) -> tuple[World, Prepare]:
        """The world of a run, with the fault that the configuration asks for.

        Args:
            run: number of the run; keys its start, noise and mishaps.
        """
        return self.build_world(self.start(run), run, faulty=True)

    def build_world(
        self, start: KettleStart, run: int, physics: str | None = None, *, faulty: bool = False
    ) -> tuple[World, Prepare]:
        """A world in any start state.

        Args:
            start: see `KettleStart`.
            run: keys noise and mishaps.
            physics: in place of the scenario's.
            faulty: whether the configured fault happens.
        """
        physics, config = physics or self.physics, self.config
        seed, scale = self.seed * _RUNS_PER_SEED + run, config.noise.scale
        fault = config.fault.kind if faulty else "none"
        stiff = config.mishap.stiffness if fault == "stiff" else 1.0
        faults, dropouts = self._mishaps(fault, np.random.default_rng([self.seed, _MISHAPS, run]))
        robot = build_robot(self._robot_spec(), physics, self._bodies(start, stiff), seed, _IDS[HAND])  # type: ignore[arg-type]

        def settings(name: str) -> ObjectSettings:
            size = robot.body_size(name) if physics == "contact" and isinstance(robot, ArmRobot) else 0
            return ObjectSettings(_IDS[name], seed, scale, () if name == SWITCH else dropouts, size)

        spaces = self.graph.objects
        parents = {name: {p: spaces[p] for p in self.graph.parents(name)} for name in spaces}
        bottle_settings, kettle_settings = self.bottle_settings(faults[0]), self.kettle_settings(faults[1])
        bottle = Cup(BOTTLE, parents[BOTTLE], cup=bottle_settings).state_at(
            LAYOUT.bottle.mouth_at(start.bottle), start.water, start.temperature
        )
        kettle = Kettle(KETTLE, parents[KETTLE], None, None, *kettle_settings).state_at(
            LAYOUT.kettle.mouth_at(start.kettle, start.kettle_floor), start.kettle_water, start.kettle_temperature
        )
        objects: dict[str, WorldObject] = {
            BOTTLE: Cup(BOTTLE, parents[BOTTLE], bottle, settings(BOTTLE), bottle_settings),
            KETTLE: Kettle(KETTLE, parents[KETTLE], kettle, settings(KETTLE), *kettle_settings),
            SWITCH: Button(SWITCH, parents[SWITCH], None, settings(SWITCH), ButtonMount(LAYOUT.switch, stiff=stiff)),
        }
        world = World(self.graph, robot, objects)
        hand = config.robot.hand.full(np.array(start.hand))

        def prepare(context: Context) -> None:
            robot.set_hand(context, hand)

        return world, prepare

    def _robot_spec(self) -> RobotSpec:
        """The robot with its sensor noise at this run's scale."""
        hand = self.config.robot.hand
        noise = {name: self.config.noise.scale * std for name, std in hand.noise_std.items()}
        return dataclasses.replace(self.config.robot, hand=dataclasses.replace(hand, noise_std=noise))

    def _bodies(self, start: KettleStart, stiff: float = 1.0) -> dict[str, BodySpec]:
        bottle = Transform(translation=[*start.bottle, 0.0])
        kettle = Transform(translation=[*start.kettle, start.kettle_floor])
        button = f"{_MODELS}/dispenser/{'button' if stiff == 1.0 else 'button_stiff'}.sdf"
        return {
            BOTTLE: BodySpec(f"{_MODELS}/kettle/bottle.sdf", bottle, fixed=False),
            KETTLE: BodySpec(f"{_MODELS}/kettle/kettle.sdf", kettle, fixed=False),
            SWITCH: BodySpec(button, Transform(translation=list(LAYOUT.switch))),
        }

    def _mishaps(
        self, fault: str, rng: np.random.Generator
    ) -> tuple[tuple[CupFaults, CupFaults], tuple[tuple[float, float], ...]]:
        """Faults of bottle and kettle, and their sensors' drop-outs."""
        mishap, none = self.config.mishap, (CupFaults(), CupFaults())
        time = float(rng.uniform(mishap.time[0], mishap.time[1]))
        turn = float(rng.uniform(-math.pi, math.pi))
        if fault == "slip":
            return (CupFaults(slips=(time,)), CupFaults(slips=(time,))), ()
        if fault == "knock":
            knock = (time, mishap.knock * math.cos(turn), mishap.knock * math.sin(turn))
            return (CupFaults(knocks=(knock,)), CupFaults()), ()
        return none, ((time, time + mishap.dropout),) if fault == "dropout" else ()

    def make_motion(self) -> StandingMotion | None:
        """Ways of the hand around what stands there; in `ideal` a point hits nothing.

        Given beside the models: bottle and kettle are held upright by a hand that points forward, where `VesselShape`
        says, and stand at first where the configuration says.
        """
        if self.physics == "ideal":
            return None
        config, spec = self.config.start, self.config.robot
        bottle, kettle = ((p[0], p[1]) for p in (config.bottle, config.kettle))
        start = KettleStart(bottle, kettle, 0.0, 0.0)
        in_hand = {n: hand_pose(v.in_hand((0.0, 0.0), 0.0)).inverse() for n, v in _SHAPES.items()}
        planner = MotionPlanner(spec, self._bodies(start), in_hand)
        standing = {
            BOTTLE: LAYOUT.bottle.in_hand(bottle, 0.0),
            KETTLE: LAYOUT.kettle.in_hand(kettle, start.kettle_floor),
        }
        return StandingMotion(planner, {n: spec.hand.reduce(v) for n, v in standing.items()})

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
            names = tuple(self.graph.objects)
            yield record(world, prepare, Commands(piece.commands), ticks, names, piece.name)

    def drawings(self) -> Mapping[str, Any]:
        """Bottle, kettle and switch; plate, console and hand too where no plant shows them."""
        plain, contact = self.physics == "ideal", self.physics == "contact"
        cup, _ = self.kettle_settings()
        plate, console = LAYOUT.plate, LAYOUT.console
        boxes = [(s.x[0], s.y[0], 0.0, s.x[1], s.y[1], s.height) for s in (plate, console)] if plain else []
        top = plate.height + LAYOUT.kettle.height
        shape = KettleDrawing(cup, _BODY, LAYOUT.kettle.hand, solid=not contact, bottom=LAYOUT.bottle.height)
        drawings: dict[str, Any] = {
            BOTTLE: CupDrawing(self.bottle_settings(), glass=not contact, bottom=top),
            KETTLE: PlateDrawing(shape, boxes),
            SWITCH: ButtonDrawing(ButtonMount(LAYOUT.switch), _RED, cap=not contact),
        }
        if plain:
            spec = self.config.robot.hand
            grip = spec.space.index("grip")
            drawings[HAND] = HandDrawing(lambda state: (hand_pose(spec.full(state)), 0.08 - 0.02 * round(state[grip])))
        return drawings

    def view(self) -> Camera:
        """From the arm's right shoulder, so that the arm hides neither bottle nor kettle."""
        return Camera((0.05, -1.35, 0.85), (0.6, 0.03, 0.15), 32.0)

    def drawn_plant(self) -> Diagram | None:
        """The arm and what stands there, in `contact` with bottle, kettle and switch."""
        if self.physics == "ideal":
            return None
        world, _ = self.build_world(self.start(0), 0)
        return world.robot if isinstance(world.robot, Diagram) else None

    def adjustables(self) -> Sequence[Adjustable]:
        """Noise, pushes of the bottle where no plant holds it, and how much water of which temperature is wanted."""
        pushes = [push(BOTTLE, v, "m", self.config.mishap.knock) for v in ("x", "y") if self.physics != "contact"]
        wanted = [least_wanted(BOTTLE, v, 0.0, 1.0, value) for v, value in (("water", 0.6), ("temperature", 0.9))]
        return (*super().adjustables(), *pushes, *wanted)

    def seats(self) -> Mapping[str, Seat]:
        """The hand."""
        return {HAND: hand_seat(self, lambda run: self.build_world(self.start(run), run))}

    def given(self) -> dict[str, Any]:
        """The configuration and the layout."""
        return super().given() | {"layout": dataclasses.asdict(LAYOUT)}


def _check(config: KettleConfig) -> None:
    for key, values, size in (
        ("camera_shift", config.camera_shift, 3),
        ("start.bottle", config.start.bottle, 2),
        ("start.kettle", config.start.kettle, 2),
        ("start.water", config.start.water, 2),
        ("start.temperature", config.start.temperature, 2),
        ("mishap.time", config.mishap.time, 2),
    ):
        if len(values) != size or not np.isfinite(values).all():
            raise InputError(f"kettle: {key} is {values}; give {size} numbers")
    for key, values in (("start.water", config.start.water), ("start.temperature", config.start.temperature)):
        if not 0.0 <= values[0] <= values[1] <= 1.0:
            raise InputError(f"kettle: {key} is {values}; give from and to within 0..1")
    if not config.start.spread >= 0:
        raise InputError(f"kettle: start.spread is {config.start.spread}; give a number from 0")
    if not config.mishap.stiffness > 0:
        raise InputError(f"kettle: mishap.stiffness is {config.mishap.stiffness}; give a number above 0")
