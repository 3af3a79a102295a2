"""The water dispenser (paper sec. VI): hand, cup, two buttons and a tank; cup and tank act on each other.

Given: the places of things (`DispenserLayout`), the camera's frame, the spread of starts, and what faults do, as in
`models/scenarios/water_dispenser.yaml`. Everything else is learned.
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
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.objects import (
    Button,
    ButtonMount,
    CameraFrame,
    Cup,
    CupFaults,
    CupSettings,
    ObjectSettings,
    Tank,
    TankSettings,
)
from ichain_drake.objects.dispenser_drawings import ButtonDrawing, CupDrawing, TankDrawing
from ichain_drake.robot import BodySpec, MotionPlanner, RobotSpec, build_robot, hand_pose
from ichain_drake.robot.arm import ArmRobot
from ichain_drake.scenarios.adjustable import Adjustable, push
from ichain_drake.scenarios.adjustable_goal import least_wanted
from ichain_drake.scenarios.base import Progress, Scenario
from ichain_drake.scenarios.commands import Commands
from ichain_drake.scenarios.config import ScenarioConfig
from ichain_drake.scenarios.episode import Prepare
from ichain_drake.scenarios.recorder import record
from ichain_drake.scenarios.seats import Seat, hand_seat
from ichain_drake.scenarios.status_accuracy import Probes
from ichain_drake.scenarios.water_dispenser_demonstrations import script_pieces
from ichain_drake.scenarios.water_dispenser_layout import LAYOUT, DispenserStart
from ichain_drake.scenarios.water_dispenser_probes import DispenserProbes
from ichain_drake.scenarios.water_dispenser_teleoperation import FORWARD, GRASP
from ichain_drake.visualization import Camera, HandDrawing
from ichain_drake.world.world import World

HAND, CUP, POWER, DISPENSE, TANK = "hand", "cup", "power", "dispense", "tank"
_IDS = {HAND: 0, CUP: 1, POWER: 2, DISPENSE: 3, TANK: 4}
_MODELS = "package://ichain_drake_models"
_RUNS_PER_SEED = 1000
_FIRST_DEMONSTRATION = 900  # runs of an evaluation are below: the script's noise is never theirs
_STARTS, _MISHAPS, _SCRIPTS = 0, 1, 2  # purposes of random numbers
_RED, _BLUE = (0.9, 0.12, 0.05), (0.05, 0.3, 0.95)


@dataclass
class StartConfig:
    """How a run begins.

    Attributes:
        cup: middle of the places where the cup may stand, x, y in the robot's frame [m].
        spread: how far from there along x and y [m].
        water, temperature: from, to.
    """

    cup: list[float] = field(default_factory=lambda: [0.68, -0.16])
    spread: list[float] = field(default_factory=lambda: [0.02, 0.05])
    water: list[float] = field(default_factory=lambda: [0.7, 0.95])
    temperature: list[float] = field(default_factory=lambda: [0.0, 0.2])


@dataclass
class MishapConfig:
    """What a fault does.

    Attributes:
        time: earliest and latest time of a slip, knock or drop-out [s].
        knock: by how much a standing cup is displaced [m].
        dropout: duration [s].
        stiffness: factor on a stiff button's force.
    """

    time: list[float] = field(default_factory=lambda: [4.0, 60.0])
    knock: float = 0.05
    dropout: float = 1.0
    stiffness: float = 1.5


@dataclass
class WaterDispenserConfig(ScenarioConfig):
    """Configuration of the water dispenser.

    Attributes:
        goal: what `run` and `plan` ask for where the command line says nothing else; see `make_goal`.
        camera_shift: the robot frame's origin in the camera frame [m].
        start, mishap: see there.
    """

    goal: list[str] = field(default_factory=list)
    camera_shift: list[float] = field(default_factory=lambda: [0.03, -0.02, -0.05])
    start: StartConfig = field(default_factory=StartConfig)
    mishap: MishapConfig = field(default_factory=MishapConfig)


class WaterDispenser(Scenario):
    """See the module's description and `Scenario`."""

    name: ClassVar[str] = "water_dispenser"
    config_class: ClassVar[type[ScenarioConfig]] = WaterDispenserConfig
    faults: ClassVar[tuple[str, ...]] = ("none", "slip", "knock", "stiff", "dropout")
    features: ClassVar[tuple[str, ...]] = ("camera",)
    config: WaterDispenserConfig

    def make_graph(self) -> InteractionGraph:
        """The seven interactions of paper fig. 6; cup and tank act on each other."""
        _check(self.config)
        if self.physics == "contact" and self.config.fault.kind in ("slip", "knock"):
            raise InputError(
                f"fault.kind {self.config.fault.kind}: in contact the plant alone moves the cup; choose ideal or arm"
            )
        objects = {
            HAND: self.config.robot.hand.space,
            CUP: Cup.space([TANK]),
            POWER: Button.state_space,
            DISPENSE: Button.state_space,
            TANK: Tank.space([CUP]),
        }
        by_hand = [(HAND, CUP), (HAND, POWER), (HAND, DISPENSE)]
        return InteractionGraph(objects, [*by_hand, (CUP, TANK), (DISPENSE, TANK), (POWER, TANK), (TANK, CUP)])

    def camera(self) -> CameraFrame:
        """The camera's frame."""
        x, y, z = self.config.camera_shift
        return CameraFrame(math.radians(self.config.camera.yaw_deg), (x, y, z))

    def cup_settings(self, faults: CupFaults | None = None) -> CupSettings:
        """Geometry of the cup and of what it meets."""
        surfaces = (LAYOUT.tray, LAYOUT.head, LAYOUT.console)
        outlets = {TANK: LAYOUT.catch_region(CupSettings.height)}
        return CupSettings(outlets=outlets, surfaces=surfaces, camera=self.camera(), faults=faults or CupFaults())

    def tank_settings(self) -> TankSettings:
        """Geometry of the inlet, rates, and which button does what."""
        return TankSettings(LAYOUT.pour_region(), drain=DISPENSE, heater=POWER, camera=self.camera())

    def button_mount(self, name: str, stiff: float = 1.0) -> ButtonMount:
        """Where a button is."""
        return ButtonMount({POWER: LAYOUT.power, DISPENSE: LAYOUT.dispense}[name], stiff=stiff)

    def start(self, run: int) -> DispenserStart:
        """The start of a run: the cup's place and content vary, the tank is empty and cold.

        Args:
            run: number of the run.
        """
        rng, config = np.random.default_rng([self.seed, _STARTS, run]), self.config.start
        place = np.array(config.cup) + rng.uniform(-1.0, 1.0, 2) * config.spread
        spec = self.config.robot
        return DispenserStart(
            (float(place[0]), float(place[1])),
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
        self, start: DispenserStart, run: int, physics: str | None = None, *, faulty: bool = False
    ) -> tuple[World, Prepare]:
        """A world in any start state.

        Args:
            start: see `DispenserStart`.
            run: keys noise and mishaps.
            physics: in place of the scenario's.
            faulty: whether the configured fault happens.
        """
        physics, config = physics or self.physics, self.config
        seed, scale = self.seed * _RUNS_PER_SEED + run, config.noise.scale
        fault = config.fault.kind if faulty else "none"
        stiff = config.mishap.stiffness if fault == "stiff" else 1.0
        mishaps = np.random.default_rng([self.seed, _MISHAPS, run])
        faults, dropouts = self._mishaps(fault, mishaps)
        cup_settings, buttons = self.cup_settings(faults), {b: self.button_mount(b, stiff) for b in (POWER, DISPENSE)}

        robot = build_robot(self._robot_spec(), physics, self._bodies(start, stiff), seed, _IDS[HAND])  # type: ignore[arg-type]

        def settings(name: str) -> ObjectSettings:
            has_body = isinstance(robot, ArmRobot) and physics == "contact" and name != TANK
            size = robot.body_size(name) if has_body else 0  # type: ignore[union-attr]
            return ObjectSettings(_IDS[name], seed, scale, dropouts if name == CUP else (), size)

        spaces = self.graph.objects
        parents = {name: {p: spaces[p] for p in self.graph.parents(name)} for name in spaces}
        cup = Cup(CUP, parents[CUP], None, settings(CUP), cup_settings)
        rim = (*start.cup, cup_settings.height + (LAYOUT.tray.height if start.on_tray else 0.0))
        objects = {
            CUP: Cup(CUP, parents[CUP], cup.state_at(rim, start.water, start.temperature), settings(CUP), cup_settings),
            **{b: Button(b, parents[b], None, settings(b), buttons[b]) for b in (POWER, DISPENSE)},
        }
        tank = Tank(TANK, parents[TANK], None, settings(TANK), self.tank_settings())
        content = tank.state_at(start.tank_amount, start.tank_temperature)
        objects[TANK] = Tank(TANK, parents[TANK], content, settings(TANK), self.tank_settings())
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

    def _bodies(self, start: DispenserStart, stiff: float) -> dict[str, BodySpec]:
        height = LAYOUT.tray.height if start.on_tray else 0.0
        cup = Transform(translation=[start.cup[0], start.cup[1], height])
        button = f"{_MODELS}/dispenser/{'button' if stiff == 1.0 else 'button_stiff'}.sdf"
        return {
            CUP: BodySpec(f"{_MODELS}/cup/cup.sdf", cup, fixed=False),
            POWER: BodySpec(button, Transform(translation=list(LAYOUT.power))),
            DISPENSE: BodySpec(button, Transform(translation=list(LAYOUT.dispense))),
        }

    def _mishaps(self, fault: str, rng: np.random.Generator) -> tuple[CupFaults, tuple[tuple[float, float], ...]]:
        mishap = self.config.mishap
        time = float(rng.uniform(mishap.time[0], mishap.time[1]))
        turn = float(rng.uniform(-math.pi, math.pi))
        if fault == "slip":
            return CupFaults(slips=(time,)), ()
        if fault == "knock":
            return CupFaults(knocks=((time, mishap.knock * math.cos(turn), mishap.knock * math.sin(turn)),)), ()
        return CupFaults(), ((time, time + mishap.dropout),) if fault == "dropout" else ()

    def make_motion(self) -> MotionPlanner | None:
        """Ways of the hand around machine, buttons and what it put down; in `ideal` a point hits nothing.

        Given beside the models: a cup is held upright by a hand that points forward, at the height of a grasp.
        """
        if self.physics == "ideal":
            return None
        grasp = hand_pose(np.array([0.0, 0.0, GRASP, 0.0, FORWARD, 0.0, 1.0]))
        nowhere = DispenserStart((0.0, 0.0), 0.0, 0.0)
        return MotionPlanner(self.config.robot, self._bodies(nowhere, 1.0), {CUP: grasp.inverse()})

    def record_demonstrations(
        self, progress: Progress | None = None, known: Collection[str] = ()
    ) -> Iterator[Demonstration]:
        """Short, unordered pieces that a script, standing in for a person, tele-operates (paper sec. VI).

        Args:
            progress: called with a line before each piece.
            known: names of interactions that need no demonstration. A piece shows several, so that all are recorded
                unless every interaction is known.
        """
        if {e.name for e in self.graph.interactions} <= set(known):
            return
        rng = np.random.default_rng([self.seed, _SCRIPTS])
        pieces = script_pieces(rng, bodies=self.physics == "contact", point=self.physics == "ideal")
        for number, piece in enumerate(pieces):
            ticks = len(piece.commands)
            if progress:
                progress(f"{piece.name}: {ticks} ticks ({self.physics})")
            world, prepare = self.build_world(piece.start, _FIRST_DEMONSTRATION + number)
            names = tuple(self.graph.objects)
            yield record(world, prepare, Commands(piece.commands), ticks, names, piece.name)

    def probes(self, edge: Interaction, pieces: Sequence[Demonstration], count: int) -> Probes | None:
        """States around the border of an interaction; see `HasProbes`. For an evaluation alone."""
        return DispenserProbes(self).make(edge, pieces, count)

    def drawings(self) -> Mapping[str, Any]:
        """Cup, buttons and tank; machine and hand too where no plant shows them."""
        plain, contact = self.physics == "ideal", self.physics == "contact"
        x, y, z = LAYOUT.outlet
        boxes = LAYOUT.boxes if plain else ()
        drawings: dict[str, Any] = {
            CUP: CupDrawing(self.cup_settings(), glass=not contact, bottom=LAYOUT.inlet[2] - 0.02),
            POWER: ButtonDrawing(self.button_mount(POWER), _RED, cap=not contact),
            DISPENSE: ButtonDrawing(self.button_mount(DISPENSE), _BLUE, cap=not contact),
            TANK: TankDrawing((0.77, -0.04, 0.03), 0.012, 0.22, (x, y, z), z - LAYOUT.tray.height, boxes),
        }
        if plain:
            spec = self.config.robot.hand
            grip = spec.space.index("grip")
            drawings[HAND] = HandDrawing(lambda state: (hand_pose(spec.full(state)), 0.08 - 0.02 * round(state[grip])))
        return drawings

    def view(self) -> Camera:
        """From the arm's left shoulder, so that neither the arm nor a button hides the others."""
        return Camera((0.05, -1.55, 0.95), (0.55, 0.03, 0.2), 32.0)

    def drawn_plant(self) -> Diagram | None:
        """The arm and the machine, in `contact` with cup and buttons."""
        if self.physics == "ideal":
            return None
        world, _ = self.build_world(self.start(0), 0)
        return world.robot if isinstance(world.robot, Diagram) else None

    def adjustables(self) -> Sequence[Adjustable]:
        """Noise, pushes of the cup where no plant holds it, and how much water of which temperature is wanted."""
        pushes = [push(CUP, v, "m", self.config.mishap.knock) for v in ("x", "y") if self.physics != "contact"]
        wanted = [least_wanted(CUP, v, 0.0, 1.0, value) for v, value in (("water", 0.6), ("temperature", 0.9))]
        return (*super().adjustables(), *pushes, *wanted)

    def seats(self) -> Mapping[str, Seat]:
        """The hand."""
        return {HAND: hand_seat(self, lambda run: self.build_world(self.start(run), run))}

    def given(self) -> dict[str, Any]:
        """The configuration and the layout."""
        return super().given() | {"layout": dataclasses.asdict(LAYOUT), "cup_in_hand": {"height": GRASP}}


def _check(config: WaterDispenserConfig) -> None:
    for key, values, size in (
        ("camera_shift", config.camera_shift, 3),
        ("start.cup", config.start.cup, 2),
        ("start.spread", config.start.spread, 2),
        ("start.water", config.start.water, 2),
        ("start.temperature", config.start.temperature, 2),
        ("mishap.time", config.mishap.time, 2),
    ):
        if len(values) != size or not np.isfinite(values).all():
            raise InputError(f"water_dispenser: {key} is {values}; give {size} numbers")
    for key, values in (("start.water", config.start.water), ("start.temperature", config.start.temperature)):
        if not 0.0 <= values[0] <= values[1] <= 1.0:
            raise InputError(f"water_dispenser: {key} is {values}; give from and to within 0..1")
    if not config.mishap.stiffness > 0:
        raise InputError(f"water_dispenser: mishap.stiffness is {config.mishap.stiffness}; give a number above 0")
