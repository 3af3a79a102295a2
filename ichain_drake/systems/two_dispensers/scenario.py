"""Two water dispensers side by side and one cup: a goal that needs both (`ideal` alone: an arm does not reach both).

Given: the geometry of `water_dispenser`, once more at `spacing` along y. Everything else is learned, from pieces like
those of `water_dispenser`, at the one machine or at the other.
"""

import dataclasses
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ichain_drake.demonstrations.table import Demonstration
from ichain_drake.errors import InputError
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.objects import (
    Button,
    ButtonMount,
    Cup,
    CupFaults,
    CupSettings,
    Region,
    Surface,
    Tank,
    TankSettings,
    WorldObject,
)
from ichain_drake.objects.drawings.dispenser import ButtonDrawing, CupDrawing, TankDrawing
from ichain_drake.objects.placement import Placement
from ichain_drake.robot import BodySpec
from ichain_drake.scenarios.adjustable import Adjustable
from ichain_drake.scenarios.base import Scenario
from ichain_drake.scenarios.config import ScenarioConfig
from ichain_drake.scenarios.faults import Faults
from ichain_drake.scenarios.graph_scenario import GraphScenario
from ichain_drake.scenarios.object_maker import ObjectMaker
from ichain_drake.scenarios.scripted_piece import ScriptedPiece
from ichain_drake.scenarios.seats import Seat
from ichain_drake.settings import setting
from ichain_drake.systems.water_dispenser.demonstrations import script_pieces
from ichain_drake.systems.water_dispenser.layout import LAYOUT, DispenserStart
from ichain_drake.systems.water_dispenser.scenario import WaterDispenser, WaterDispenserConfig
from ichain_drake.visualization import Camera

HAND, CUP = "hand", "cup"
MACHINES = ("near", "far", *(f"more{k}" for k in range(1, 63)))
"""What the machines are called, from the near one on; usually there are two."""
_SHARED = ("relocate", "miss_grasps")  # pieces that show no machine
_RED, _BLUE = (0.9, 0.12, 0.05), (0.05, 0.3, 0.95)


@dataclass
class TwoDispensersConfig(WaterDispenserConfig):
    """Configuration of the two dispensers.

    Attributes:
        machines: so many are there; of more than two, the hand's bounds must reach all (`robot.hand.bounds`).
        spacing: from each machine to the next one along y [m].
    """

    machines: int = setting(2, "machines", lower=1, upper=len(MACHINES))
    spacing: float = setting(-0.6, "m", lower=-2, upper=2)


@dataclass(frozen=True)
class MachineStart(DispenserStart):
    """A start whose tank is that of one machine; the other is empty and cold.

    Attributes:
        cup, water, temperature, tank_amount, tank_temperature, hand, on_tray: see `DispenserStart`.
        machine: of `MACHINES`.
    """

    machine: str = MACHINES[0]


class TwoDispensers(WaterDispenser):
    """See the module's description and `GraphScenario`."""

    name: ClassVar[str] = "two_dispensers"
    config_class: ClassVar[type[ScenarioConfig]] = TwoDispensersConfig
    faults: ClassVar[tuple[str, ...]] = ("none",)
    config: TwoDispensersConfig

    def check_config(self) -> None:
        """Refuse an arm, and machines that stand in each other."""
        super().check_config()
        if self.physics != "ideal":
            raise InputError("two_dispensers: an arm does not reach both machines; give --physics ideal")
        if self.config.machine.seen:
            raise InputError("two_dispensers: its machines stand where they are; leave machine.seen at false")
        if self.config.machines > 1 and not abs(self.config.spacing) >= 0.5:
            raise InputError(f"two_dispensers: spacing is {self.config.spacing} m; the machines need 0.5 m or more")

    @property
    def machines(self) -> tuple[str, ...]:
        """Names of the machines."""
        return MACHINES[: self.config.machines]

    def make_graph(self) -> InteractionGraph:
        """The graph of `water_dispenser` with buttons and tank twice."""
        tanks = [f"{m}_tank" for m in self.machines]
        objects = {HAND: self.config.robot.hand.space, CUP: Cup.space(tanks)}
        edges = [(HAND, CUP)]
        for m in self.machines:
            power, dispense, tank = self._names(m)
            objects |= {power: Button.state_space, dispense: Button.state_space, tank: Tank.space([CUP])}
            edges += [(HAND, power), (HAND, dispense), (power, tank), (dispense, tank), (CUP, tank), (tank, CUP)]
        return InteractionGraph(objects, edges)

    @staticmethod
    def _names(machine: str) -> tuple[str, str, str]:
        return f"{machine}_power", f"{machine}_dispense", f"{machine}_tank"

    def _shift(self, machine: str) -> float:
        """How far a machine is from the one of `water_dispenser` along y [m]."""
        return self.config.spacing * MACHINES.index(machine)

    def make_objects(self, start: DispenserStart, make: ObjectMaker) -> Mapping[str, WorldObject]:
        """The cup, and buttons and tank of both machines; a plain start is one of the near machine."""
        at = start.machine if isinstance(start, MachineStart) else MACHINES[0]
        empty = dataclasses.replace(
            start, tank_amount=DispenserStart.tank_amount, tank_temperature=DispenserStart.tank_temperature
        )
        objects: dict[str, WorldObject] = {CUP: self.make_cup(start, make)}
        for m in self.machines:
            power, dispense, tank = self._names(m)
            objects |= {b: make(Button, b, mount=self.button_mount(b)) for b in (power, dispense)}
            objects[tank] = self.make_tank(tank, start if m == at else empty, make, self._tank_settings(m))
        return objects

    def bodies(self, start: DispenserStart, faults: Faults) -> Mapping[str, BodySpec]:
        """None: a point touches nothing."""
        return {}

    def cup_settings(self, faults: CupFaults | None = None, machine: Placement | None = None) -> CupSettings:
        """Geometry of the cup and of what it meets."""
        surfaces, outlets = [], {}
        for m in self.machines:
            shift, (_, _, tank) = self._shift(m), self._names(m)
            surfaces += [_moved(s, shift) for s in (LAYOUT.tray, LAYOUT.head, LAYOUT.console)]
            outlets[tank] = _moved_region(LAYOUT.catch_region(CupSettings.height), shift)
        return CupSettings(
            outlets=outlets, surfaces=tuple(surfaces), camera=self.camera(), faults=faults or CupFaults()
        )

    def _tank_settings(self, machine: str) -> TankSettings:
        power, dispense, _ = self._names(machine)
        region = _moved_region(LAYOUT.pour_region(), self._shift(machine))
        return TankSettings(region, drain=dispense, heater=power, camera=self.camera())

    def button_mount(self, name: str, stiff: float = 1.0) -> ButtonMount:
        """Where a button is."""
        machine = name.partition("_")[0]
        x, y, z = LAYOUT.power if name == self._names(machine)[0] else LAYOUT.dispense
        return ButtonMount((x, y + self._shift(machine), z), stiff=stiff)

    def script(self, rng: np.random.Generator) -> Iterator[ScriptedPiece[DispenserStart]]:
        """Pieces like those of `water_dispenser` at each machine; see there."""
        # Machine by machine in the order of the script's draws; every piece shows one machine at most.
        pieces = [(m, p) for m in self.machines for p in script_pieces(rng, point=True)]
        for m, piece in pieces:
            if m == MACHINES[0] or piece.name not in _SHARED:
                yield self._moved_piece(piece, m)

    def _moved_piece(self, piece: ScriptedPiece[DispenserStart], machine: str) -> ScriptedPiece[DispenserStart]:
        """The same piece before a machine."""
        start, shift, commands = piece.start, self._shift(machine), piece.commands.copy()
        commands[:, 1] += shift
        hand, cup = list(start.hand), (start.cup[0], start.cup[1] + shift)
        hand[1] += shift
        placed = vars(start) | {"cup": cup, "hand": tuple(hand), "machine": machine}
        shows = tuple(
            Interaction(*(n if n in (HAND, CUP) else f"{machine}_{n}" for n in name.split("->"))).name
            for name in piece.shows
        )
        return ScriptedPiece(f"{machine}_{piece.name}", MachineStart(**placed), commands, shows)

    def probes(self, edge: Interaction, pieces: Sequence[Demonstration], count: int) -> None:
        """None are made here."""

    def drawings(self) -> Mapping[str, Any]:
        """Cup, hand, and buttons and tank of both machines."""
        drawings: dict[str, Any] = {
            CUP: CupDrawing(self.cup_settings(), glass=True, bottom=LAYOUT.inlet[2] - 0.02),
            **GraphScenario.drawings(self),
        }
        x, y, z = LAYOUT.outlet
        for m in self.machines:
            dy, (power, dispense, tank) = self._shift(m), self._names(m)
            boxes = tuple((b[0], b[1] + dy, b[2], b[3], b[4] + dy, b[5]) for b in LAYOUT.boxes)
            spout = (x, y + dy, z)
            drawings[power] = ButtonDrawing(self.button_mount(power), _RED, cap=True)
            drawings[dispense] = ButtonDrawing(self.button_mount(dispense), _BLUE, cap=True)
            drawings[tank] = TankDrawing((0.77, dy - 0.04, 0.03), 0.012, 0.22, spout, z - LAYOUT.tray.height, boxes)
        return drawings

    def view(self) -> Camera:
        """Both machines from the front."""
        middle = 0.5 * self.config.spacing * (self.config.machines - 1)
        return Camera((-0.9, middle - 0.9, 1.1), (0.6, middle, 0.15), 32.0)

    def adjustables(self) -> Sequence[Adjustable]:
        """Noise."""
        return Scenario.adjustables(self)

    def seats(self) -> Mapping[str, Seat]:
        """None."""
        return {}


def _moved(surface: Surface, dy: float) -> Surface:
    return dataclasses.replace(surface, y=(surface.y[0] + dy, surface.y[1] + dy))


def _moved_region(region: Region, dy: float) -> Region:
    x, y, z = region.center
    return dataclasses.replace(region, center=(x, y + dy, z))
