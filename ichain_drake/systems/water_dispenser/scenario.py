"""The water dispenser (paper sec. VI): hand, cup, two buttons and a tank; cup and tank act on each other.

Given: the places of things (`DispenserLayout`), the camera's frame, the spread of starts, and what faults do, as in
`models/scenarios/water_dispenser.yaml`. Everything else is learned.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

import numpy as np
from pydrake.common.schema import Transform

from ichain_drake.demonstrations.table import Demonstration
from ichain_drake.errors import InputError
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.objects import Button, ButtonMount, Cup, CupFaults, CupSettings, Tank, TankSettings, WorldObject
from ichain_drake.objects.drawings.dispenser import ButtonDrawing, CupDrawing, TankDrawing
from ichain_drake.objects.placement import Placement
from ichain_drake.robot import BodySpec, MotionPlanner, hand_pose
from ichain_drake.scenarios.adjustable import Adjustable, push
from ichain_drake.scenarios.adjustable_goal import least_wanted
from ichain_drake.scenarios.appliance import MODELS, Appliance, ApplianceConfig
from ichain_drake.scenarios.config import ScenarioConfig
from ichain_drake.scenarios.faults import FAULTS, Faults
from ichain_drake.scenarios.given import geometry
from ichain_drake.scenarios.object_maker import ObjectMaker
from ichain_drake.scenarios.probes import Probes
from ichain_drake.scenarios.scripted_piece import ScriptedPiece
from ichain_drake.settings import setting
from ichain_drake.state import FloatArray
from ichain_drake.systems.water_dispenser.demonstrations import script_pieces
from ichain_drake.systems.water_dispenser.layout import LAYOUT, MIDDLE, DispenserStart
from ichain_drake.systems.water_dispenser.probes import DispenserProbes
from ichain_drake.systems.water_dispenser.teleoperation import FORWARD, GRASP
from ichain_drake.visualization import Camera

HAND, CUP, POWER, DISPENSE, TANK = "hand", "cup", "power", "dispense", "tank"
_ARM = 0.06  # m; half as wide as the wrist is
_RED, _BLUE = (0.9, 0.12, 0.05), (0.05, 0.3, 0.95)


@dataclass
class DispenserStartConfig:
    """How a run begins.

    Attributes:
        cup: middle of the places where the cup may stand, x, y in the robot's frame [m].
        spread: how far from there along x and y [m].
        water, temperature: from, to.
    """

    cup: list[float] = setting(lambda: [0.68, -0.16], "m", size=2, lower=-2, upper=2)
    spread: list[float] = setting(lambda: [0.02, 0.05], "m", size=2, lower=0, upper=1)
    water: list[float] = setting(lambda: [0.7, 0.95], size=2, lower=0, upper=1, rising=True)
    temperature: list[float] = setting(lambda: [0.0, 0.2], size=2, lower=0, upper=1, rising=True)


@dataclass
class MachineConfig:
    """Where the machine stands in a run; in demonstrations it stands where the layout says. Its buttons stay there.

    Attributes:
        seen: whether the camera measures where the tank is and how it is turned.
        shift: of the machine along x and y [m].
        turn_deg: of the machine about its middle [deg].
    """

    seen: bool = False
    shift: list[float] = setting(lambda: [0.0, 0.0], "m", size=2, lower=-1, upper=1)
    turn_deg: float = setting(0.0, "deg", lower=-180, upper=180)


@dataclass
class WaterDispenserConfig(ApplianceConfig):
    """Configuration of the water dispenser.

    Attributes:
        goal, camera_shift, fault: see `ApplianceConfig`.
        start, machine: see there.
    """

    start: DispenserStartConfig = field(default_factory=DispenserStartConfig)
    machine: MachineConfig = field(default_factory=MachineConfig)


class WaterDispenser(Appliance[DispenserStart]):
    """See the module's description and `GraphScenario`."""

    name: ClassVar[str] = "water_dispenser"
    config_class: ClassVar[type[ScenarioConfig]] = WaterDispenserConfig
    faults: ClassVar[tuple[str, ...]] = FAULTS
    displaced: ClassVar[tuple[str, ...]] = (CUP,)
    config: WaterDispenserConfig

    def check_config(self) -> None:
        """Refuse a machine that is moved where nothing tells, or where the arm's own scene holds it."""
        super().check_config()
        machine = self.config.machine
        if (any(machine.shift) or machine.turn_deg) and (not machine.seen or self.physics != "ideal"):
            raise InputError(
                "machine: a machine that is moved must be seen, and in ideal: set machine.seen=true and give "
                "--physics ideal, or leave machine.shift and machine.turn_deg at 0"
            )

    def make_graph(self) -> InteractionGraph:
        """The seven interactions of paper fig. 6; cup and tank act on each other."""
        objects = {
            HAND: self.config.robot.hand.space,
            CUP: Cup.space([TANK]),
            POWER: Button.state_space,
            DISPENSE: Button.state_space,
            TANK: Tank.space([CUP], seen=self.config.machine.seen),
        }
        by_hand = [(HAND, CUP), (HAND, POWER), (HAND, DISPENSE)]
        return InteractionGraph(objects, [*by_hand, (CUP, TANK), (DISPENSE, TANK), (POWER, TANK), (TANK, CUP)])

    def cup_settings(self, faults: CupFaults | None = None, machine: Placement | None = None) -> CupSettings:
        """Geometry of the cup and of what it meets."""
        body = (replace(s, moved=machine) for s in (LAYOUT.tray, LAYOUT.head))
        surfaces = (*body, LAYOUT.console)
        outlets = {TANK: LAYOUT.catch_region(CupSettings.height, machine)}
        return CupSettings(outlets=outlets, surfaces=surfaces, camera=self.camera(), faults=faults or CupFaults())

    def tank_settings(self, machine: Placement | None = None) -> TankSettings:
        """Geometry of the inlet, rates, and which button does what."""
        place = machine or Placement(MIDDLE)
        stands = (*place.forth(*MIDDLE), 0.0, place.turn) if self.config.machine.seen else None
        return TankSettings(
            LAYOUT.pour_region(machine), drain=DISPENSE, heater=POWER, camera=self.camera(), stands=stands
        )

    def button_mount(self, name: str, stiff: float = 1.0) -> ButtonMount:
        """Where a button is."""
        return ButtonMount({POWER: LAYOUT.power, DISPENSE: LAYOUT.dispense}[name], stiff=stiff)

    def draw_start(self, rng: np.random.Generator) -> DispenserStart:
        """The cup's place and content vary, the tank is empty and cold."""
        config = self.config.start
        place = np.array(config.cup) + rng.uniform(-1.0, 1.0, 2) * config.spread
        return DispenserStart(
            (float(place[0]), float(place[1])),
            float(rng.uniform(config.water[0], config.water[1])),
            float(rng.uniform(config.temperature[0], config.temperature[1])),
            hand=self.home(),
            stands=self.placement(),
        )

    def placement(self) -> Placement | None:
        """How the machine stands in runs; None for as the layout says."""
        x, y = self.config.machine.shift
        if not (x or y or self.config.machine.turn_deg):
            return None
        return Placement(MIDDLE, (x, y), math.radians(self.config.machine.turn_deg))

    def make_objects(self, start: DispenserStart, make: ObjectMaker) -> Mapping[str, WorldObject]:
        """Cup, buttons and tank; slips, knocks and drop-outs meet the cup."""
        mounts = {b: self.button_mount(b, make.faults.stiffness) for b in (POWER, DISPENSE)}
        return {
            CUP: self.make_cup(start, make),
            **{b: make(Button, b, mount=mount) for b, mount in mounts.items()},
            TANK: self.make_tank(TANK, start, make, self.tank_settings(start.stands)),
        }

    def make_cup(self, start: DispenserStart, make: ObjectMaker) -> Cup:
        """The cup in its start state."""
        settings = self.cup_settings(CupFaults(make.faults.slips, make.faults.knocks, make.faults.away), start.stands)
        rim = (*start.cup, settings.height + (LAYOUT.tray.height if start.on_tray else 0.0))

        def filled(cup: Cup) -> FloatArray:
            return cup.state_at(rim, start.water, start.temperature)

        return make(Cup, CUP, filled, dropouts=make.faults.dropouts, cup=settings)

    @staticmethod
    def make_tank(name: str, start: DispenserStart, make: ObjectMaker, settings: TankSettings) -> Tank:
        """A tank in its start state."""

        def filled(tank: Tank) -> FloatArray:
            return tank.state_at(start.tank_amount, start.tank_temperature)

        return make(Tank, name, filled, tank=settings)

    def bodies(self, start: DispenserStart, faults: Faults) -> Mapping[str, BodySpec]:
        """Cup and buttons."""
        height = LAYOUT.tray.height if start.on_tray else 0.0
        cup = Transform(translation=[start.cup[0], start.cup[1], height])
        button = f"{MODELS}/dispenser/{'button' if faults.stiffness == 1.0 else 'button_stiff'}.sdf"
        return {
            CUP: BodySpec(f"{MODELS}/cup/cup.sdf", cup, fixed=False),
            POWER: BodySpec(button, Transform(translation=list(LAYOUT.power))),
            DISPENSE: BodySpec(button, Transform(translation=list(LAYOUT.dispense))),
        }

    def spared(self, place: FloatArray) -> bool:
        """A cup beyond the buttons, which an arm that comes from before them can't take."""
        low, high = LAYOUT.console.y
        return low - _ARM <= place[1] <= high + _ARM

    def make_motion(self) -> MotionPlanner | None:
        """Ways of the hand around machine, buttons and what it put down; in `ideal` a point hits nothing.

        Given beside the models: a cup is held upright by a hand that points forward, at the height of a grasp.
        """
        if self.physics == "ideal":
            return None
        grasp = hand_pose(np.array([0.0, 0.0, GRASP, 0.0, FORWARD, 0.0, 1.0]))
        nowhere = DispenserStart((0.0, 0.0), 0.0, 0.0)
        return MotionPlanner(self.config.robot, self.bodies(nowhere, Faults()), {CUP: grasp.inverse()})

    def script(self, rng: np.random.Generator) -> Iterable[ScriptedPiece[DispenserStart]]:
        """See `script_pieces` (paper sec. VI)."""
        return script_pieces(rng, bodies=self.physics == "contact", point=self.physics == "ideal")

    def probes(self, edge: Interaction, pieces: Sequence[Demonstration], count: int) -> Probes | None:
        """States around the border of an interaction; see `HasProbes`. For an evaluation alone."""
        return DispenserProbes(self).make(edge, pieces, count)

    def drawings(self) -> Mapping[str, Any]:
        """Cup, buttons and tank; machine and hand too where no plant shows them."""
        contact = self.physics == "contact"
        x, y, z = LAYOUT.outlet
        boxes = LAYOUT.boxes if self.physics == "ideal" else ()
        return {
            CUP: CupDrawing(self.cup_settings(), glass=not contact, bottom=LAYOUT.inlet[2] - 0.02),
            POWER: ButtonDrawing(self.button_mount(POWER), _RED, cap=not contact),
            DISPENSE: ButtonDrawing(self.button_mount(DISPENSE), _BLUE, cap=not contact),
            TANK: TankDrawing(
                (0.77, -0.04, 0.03), 0.012, 0.22, (x, y, z), z - LAYOUT.tray.height, boxes, self.placement()
            ),
            **super().drawings(),
        }

    def view(self) -> Camera:
        """From the arm's left shoulder, so that neither the arm nor a button hides the others."""
        return Camera((0.05, -1.55, 0.95), (0.55, 0.03, 0.2), 32.0)

    def adjustables(self) -> Sequence[Adjustable]:
        """Noise, pushes of the cup where no plant holds it, and how much water of which temperature is wanted."""
        pushes = [push(CUP, v, "m", self.config.fault.knock) for v in ("x", "y") if self.physics != "contact"]
        wanted = [least_wanted(CUP, v, 0.0, 1.0, value) for v, value in (("water", 0.6), ("temperature", 0.9))]
        return (*super().adjustables(), *pushes, *wanted)

    def given(self) -> dict[str, Any]:
        """The configuration and the layout."""
        return super().given() | {"layout": geometry(LAYOUT), "cup_in_hand": {"height": GRASP}}
