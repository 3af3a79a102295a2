"""Two water dispensers side by side and one cup: a goal that needs both (`ideal` alone: an arm does not reach both).

Given: the geometry of `water_dispenser`, once more at `spacing` along y. Everything else is learned, from pieces like
those of `water_dispenser`, at the one machine or at the other.
"""

import dataclasses
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
from pydrake.systems.framework import Context

from ichain_drake.demonstrations.table import Demonstration
from ichain_drake.errors import InputError
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.objects import (
    Button,
    ButtonMount,
    Cup,
    CupSettings,
    ObjectSettings,
    Region,
    Surface,
    Tank,
    TankSettings,
)
from ichain_drake.objects.dispenser_drawings import ButtonDrawing, CupDrawing, TankDrawing
from ichain_drake.robot import MotionPlanner, build_robot, hand_pose
from ichain_drake.scenarios.adjustable import Adjustable
from ichain_drake.scenarios.base import Progress, Scenario
from ichain_drake.scenarios.commands import Commands
from ichain_drake.scenarios.config import ScenarioConfig
from ichain_drake.scenarios.episode import Prepare
from ichain_drake.scenarios.recorder import record
from ichain_drake.scenarios.seats import Seat
from ichain_drake.scenarios.water_dispenser import WaterDispenser, WaterDispenserConfig
from ichain_drake.scenarios.water_dispenser_demonstrations import ScriptedPiece, script_pieces
from ichain_drake.scenarios.water_dispenser_layout import LAYOUT, DispenserStart
from ichain_drake.visualization import Camera, HandDrawing
from ichain_drake.world.world import World

HAND, CUP = "hand", "cup"
MACHINES = ("near", "far")
_RUNS_PER_SEED = 1000
_FIRST_DEMONSTRATION = 900
_STARTS, _SCRIPTS = 0, 2  # purposes of random numbers
_SHARED = ("relocate", "miss_grasps")  # pieces that show no machine
_RED, _BLUE = (0.9, 0.12, 0.05), (0.05, 0.3, 0.95)


@dataclass
class TwoDispensersConfig(WaterDispenserConfig):
    """Configuration of the two dispensers.

    Attributes:
        spacing: from the near machine to the far one along y [m].
    """

    spacing: float = field(default=-0.6)


class TwoDispensers(WaterDispenser):
    """See the module's description and `Scenario`."""

    name: ClassVar[str] = "two_dispensers"
    config_class: ClassVar[type[ScenarioConfig]] = TwoDispensersConfig
    faults: ClassVar[tuple[str, ...]] = ("none",)
    config: TwoDispensersConfig

    def make_graph(self) -> InteractionGraph:
        """The graph of `water_dispenser` with buttons and tank twice."""
        if self.physics != "ideal":
            raise InputError("two_dispensers: an arm does not reach both machines; give --physics ideal")
        if not abs(self.config.spacing) >= 0.5:
            raise InputError(f"two_dispensers: spacing is {self.config.spacing} m; the machines need 0.5 m or more")
        tanks = [f"{m}_tank" for m in MACHINES]
        objects = {HAND: self.config.robot.hand.space, CUP: Cup.space(tanks)}
        edges = [(HAND, CUP)]
        for m in MACHINES:
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

    def make_world(self, run: int) -> tuple[World, Prepare]:
        """The world of a run; see `WaterDispenser.make_world`."""
        return self._build(self.start(run), MACHINES[0], run)

    def _build(self, start: DispenserStart, machine: str, run: int) -> tuple[World, Prepare]:
        """A world in a start state that is laid out for one machine; the other one is empty and cold."""
        seed, scale = self.seed * _RUNS_PER_SEED + run, self.config.noise.scale
        ids = {name: k for k, name in enumerate(self.graph.objects)}
        robot = build_robot(self._robot_spec(), "ideal", {}, seed, ids[HAND])
        spaces = self.graph.objects
        shift = self._shift(machine)

        def common(name: str) -> tuple[str, dict[str, Any]]:
            return name, {p: spaces[p] for p in self.graph.parents(name)}

        cup_settings = self._cup_settings()
        rim = (start.cup[0], start.cup[1] + shift, CupSettings.height + (LAYOUT.tray.height if start.on_tray else 0.0))
        blank = Cup(*common(CUP), None, ObjectSettings(ids[CUP], seed, scale), cup_settings)
        content = blank.state_at(rim, start.water, start.temperature)
        objects: dict[str, Any] = {CUP: Cup(*common(CUP), content, ObjectSettings(ids[CUP], seed, scale), cup_settings)}
        for m in MACHINES:
            power, dispense, tank = self._names(m)
            for button in (power, dispense):
                settings = ObjectSettings(ids[button], seed, scale)
                objects[button] = Button(*common(button), None, settings, self._mount(m, button))
            settings = ObjectSettings(ids[tank], seed, scale)
            empty = Tank(*common(tank), None, settings, self._tank_settings(m))
            plain = DispenserStart((0.0, 0.0), 0.0, 0.0)
            source = start if m == machine else plain
            held = empty.state_at(source.tank_amount, source.tank_temperature)
            objects[tank] = Tank(*common(tank), held, settings, self._tank_settings(m))
        world = World(self.graph, robot, objects)
        hand = np.array(start.hand)
        hand[1] += shift
        full = self.config.robot.hand.full(hand)

        def prepare(context: Context) -> None:
            robot.set_hand(context, full)

        return world, prepare

    def _cup_settings(self) -> CupSettings:
        surfaces, outlets = [], {}
        for m in MACHINES:
            shift, (_, _, tank) = self._shift(m), self._names(m)
            surfaces += [_moved(s, shift) for s in (LAYOUT.tray, LAYOUT.head, LAYOUT.console)]
            outlets[tank] = _moved_region(LAYOUT.catch_region(CupSettings.height), shift)
        return CupSettings(outlets=outlets, surfaces=tuple(surfaces), camera=self.camera())

    def _tank_settings(self, machine: str) -> TankSettings:
        power, dispense, _ = self._names(machine)
        region = _moved_region(LAYOUT.pour_region(), self._shift(machine))
        return TankSettings(region, drain=dispense, heater=power, camera=self.camera())

    def _mount(self, machine: str, button: str) -> ButtonMount:
        x, y, z = LAYOUT.power if button == self._names(machine)[0] else LAYOUT.dispense
        return ButtonMount((x, y + self._shift(machine), z))

    def make_motion(self) -> MotionPlanner | None:
        """A point hits nothing."""
        return None

    def record_demonstrations(
        self, progress: Progress | None = None, known: Collection[str] = ()
    ) -> Iterator[Demonstration]:
        """Pieces like those of `water_dispenser` at each machine; see there."""
        if {e.name for e in self.graph.interactions} <= set(known):
            return
        rng = np.random.default_rng([self.seed, _SCRIPTS])
        # Machine by machine in the order of the script's draws; every piece shows one machine at most.
        pieces: list[tuple[str, ScriptedPiece]] = []
        for k, m in enumerate(MACHINES):
            pieces += [(m, p) for p in script_pieces(rng, point=True) if k == 0 or p.name not in _SHARED]
        for number, (m, piece) in enumerate(pieces):
            name = f"{m}_{piece.name}"
            if progress:
                progress(f"{name}: {len(piece.commands)} ticks (ideal)")
            world, prepare = self._build(piece.start, m, _FIRST_DEMONSTRATION + number)
            commands = piece.commands.copy()
            commands[:, 1] += self._shift(m)
            yield record(world, prepare, Commands(commands), len(commands), tuple(self.graph.objects), name)

    def probes(self, edge: Interaction, pieces: Sequence[Demonstration], count: int) -> None:
        """None are made here."""

    def drawings(self) -> Mapping[str, Any]:
        """Cup, hand, and buttons and tank of both machines."""
        spec = self.config.robot.hand
        grip = spec.space.index("grip")
        drawings: dict[str, Any] = {
            CUP: CupDrawing(self._cup_settings(), glass=True, bottom=LAYOUT.inlet[2] - 0.02),
            HAND: HandDrawing(lambda state: (hand_pose(spec.full(state)), 0.08 - 0.02 * round(state[grip]))),
        }
        x, y, z = LAYOUT.outlet
        for m in MACHINES:
            dy, (power, dispense, tank) = self._shift(m), self._names(m)
            boxes = tuple((b[0], b[1] + dy, b[2], b[3], b[4] + dy, b[5]) for b in LAYOUT.boxes)
            spout = (x, y + dy, z)
            drawings[power] = ButtonDrawing(self._mount(m, power), _RED, cap=True)
            drawings[dispense] = ButtonDrawing(self._mount(m, dispense), _BLUE, cap=True)
            drawings[tank] = TankDrawing((0.77, dy - 0.04, 0.03), 0.012, 0.22, spout, z - LAYOUT.tray.height, boxes)
        return drawings

    def view(self) -> Camera:
        """Both machines from the front."""
        middle = 0.5 * self.config.spacing
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
