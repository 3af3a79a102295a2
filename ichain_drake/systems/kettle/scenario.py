"""Bottle and kettle (paper sec. I): the same two objects act on each other in opposite directions at different times.

A hand pours cold water from the bottle into the kettle, boils it by a switch, and pours it back. Given: the places and
shapes of things (`KettleLayout`), the camera's frame, the spread of starts, and what faults do, as in
`models/scenarios/kettle.yaml`. Everything else is learned.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
from pydrake.common.schema import Transform

from ichain_drake.demonstrations.table import Demonstration
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.objects import Button, ButtonMount, Cup, CupFaults, CupSettings, Kettle, KettleSettings, WorldObject
from ichain_drake.objects.drawings.dispenser import ButtonDrawing, CupDrawing
from ichain_drake.objects.drawings.kettle import KettleDrawing, PlateDrawing
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
from ichain_drake.scenarios.standing_motion import StandingMotion
from ichain_drake.settings import setting
from ichain_drake.state import FloatArray
from ichain_drake.systems.kettle.demonstrations import script_pieces
from ichain_drake.systems.kettle.layout import LAYOUT, KettleStart, VesselShape
from ichain_drake.systems.kettle.probes import KettleProbes
from ichain_drake.visualization import Camera

HAND, BOTTLE, KETTLE, SWITCH = "hand", "bottle", "kettle", "switch"
_SHAPES = {BOTTLE: LAYOUT.bottle, KETTLE: LAYOUT.kettle}
_BODY = 0.13  # height of the kettle's body [m]
_RED = (0.9, 0.12, 0.05)


@dataclass
class KettleStartConfig:
    """How a run begins.

    Attributes:
        bottle, kettle: middle of the places where they may stand, x, y in the robot's frame [m].
        spread: how far from there, along x and y [m].
        water, temperature: of the bottle, from, to.
    """

    bottle: list[float] = setting(lambda: [0.70, -0.15], "m", size=2, lower=-2, upper=2)
    kettle: list[float] = setting(lambda: [0.735, 0.13], "m", size=2, lower=-2, upper=2)
    spread: float = setting(0.005, "m", lower=0, upper=1)
    water: list[float] = setting(lambda: [0.7, 0.95], size=2, lower=0, upper=1, rising=True)
    temperature: list[float] = setting(lambda: [0.0, 0.2], size=2, lower=0, upper=1, rising=True)


@dataclass
class KettleConfig(ApplianceConfig):
    """Configuration of the kettle.

    Attributes:
        goal, camera_shift, fault: see `ApplianceConfig`; slips and drop-outs meet both vessels, knocks the bottle.
        start: see there.
    """

    start: KettleStartConfig = field(default_factory=KettleStartConfig)


class KettleScenario(Appliance[KettleStart]):
    """See the module's description and `GraphScenario`."""

    name: ClassVar[str] = "kettle"
    config_class: ClassVar[type[ScenarioConfig]] = KettleConfig
    faults: ClassVar[tuple[str, ...]] = FAULTS
    displaced: ClassVar[tuple[str, ...]] = (BOTTLE,)
    config: KettleConfig

    def make_graph(self) -> InteractionGraph:
        """Six interactions; bottle and kettle act on each other."""
        objects = {
            HAND: self.config.robot.hand.space,
            BOTTLE: Cup.space([KETTLE]),
            KETTLE: Kettle.space([BOTTLE]),
            SWITCH: Button.state_space,
        }
        by_hand = [(HAND, BOTTLE), (HAND, KETTLE), (HAND, SWITCH)]
        return InteractionGraph(objects, [*by_hand, (BOTTLE, KETTLE), (KETTLE, BOTTLE), (SWITCH, KETTLE)])

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

    def draw_start(self, rng: np.random.Generator) -> KettleStart:
        """Places and the bottle's content vary, the kettle is empty and cold."""
        config = self.config.start
        bottle, kettle = (
            np.array(p) + rng.uniform(-1.0, 1.0, 2) * config.spread for p in (config.bottle, config.kettle)
        )
        return KettleStart(
            (float(bottle[0]), float(bottle[1])),
            (float(kettle[0]), float(kettle[1])),
            float(rng.uniform(config.water[0], config.water[1])),
            float(rng.uniform(config.temperature[0], config.temperature[1])),
            hand=self.home(),
        )

    def make_objects(self, start: KettleStart, make: ObjectMaker) -> Mapping[str, WorldObject]:
        """Both vessels and the switch."""
        faults = make.faults
        bottle = self.bottle_settings(CupFaults(faults.slips, faults.knocks, faults.away))
        kettle, plate = self.kettle_settings(CupFaults(slips=faults.slips))

        def bottle_filled(bottle: Cup) -> FloatArray:
            return bottle.state_at(LAYOUT.bottle.mouth_at(start.bottle), start.water, start.temperature)

        def kettle_filled(kettle: Kettle) -> FloatArray:
            mouth = LAYOUT.kettle.mouth_at(start.kettle, start.kettle_floor)
            return kettle.state_at(mouth, start.kettle_water, start.kettle_temperature)

        mount = ButtonMount(LAYOUT.switch, stiff=faults.stiffness)
        return {
            BOTTLE: make(Cup, BOTTLE, bottle_filled, dropouts=faults.dropouts, cup=bottle),
            KETTLE: make(Kettle, KETTLE, kettle_filled, dropouts=faults.dropouts, cup=kettle, kettle=plate),
            SWITCH: make(Button, SWITCH, mount=mount),
        }

    def bodies(self, start: KettleStart, faults: Faults) -> Mapping[str, BodySpec]:
        """Both vessels and the switch."""
        bottle = Transform(translation=[*start.bottle, 0.0])
        kettle = Transform(translation=[*start.kettle, start.kettle_floor])
        button = f"{MODELS}/dispenser/{'button' if faults.stiffness == 1.0 else 'button_stiff'}.sdf"
        return {
            BOTTLE: BodySpec(f"{MODELS}/kettle/bottle.sdf", bottle, fixed=False),
            KETTLE: BodySpec(f"{MODELS}/kettle/kettle.sdf", kettle, fixed=False),
            SWITCH: BodySpec(button, Transform(translation=list(LAYOUT.switch))),
        }

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
        planner = MotionPlanner(spec, self.bodies(start, Faults()), in_hand)
        standing = {
            BOTTLE: LAYOUT.bottle.in_hand(bottle, 0.0),
            KETTLE: LAYOUT.kettle.in_hand(kettle, start.kettle_floor),
        }
        return StandingMotion(planner, {n: spec.hand.reduce(v) for n, v in standing.items()})

    def script(self, rng: np.random.Generator) -> Iterable[ScriptedPiece[KettleStart]]:
        """See `script_pieces`."""
        return script_pieces(rng, bodies=self.physics == "contact")

    def probes(self, edge: Interaction, pieces: Sequence[Demonstration], count: int) -> Probes | None:
        """States around the border of an interaction; see `HasProbes`. For an evaluation alone."""
        return KettleProbes(self).make(edge, pieces, count)

    def drawings(self) -> Mapping[str, Any]:
        """Bottle, kettle and switch; plate, console and hand too where no plant shows them."""
        contact = self.physics == "contact"
        cup, _ = self.kettle_settings()
        plate, console = LAYOUT.plate, LAYOUT.console
        shown = (plate, console) if self.physics == "ideal" else ()
        boxes = [(s.x[0], s.y[0], 0.0, s.x[1], s.y[1], s.height) for s in shown]
        top = plate.height + LAYOUT.kettle.height
        shape = KettleDrawing(cup, _BODY, LAYOUT.kettle.hand, solid=not contact, bottom=LAYOUT.bottle.height)
        return {
            BOTTLE: CupDrawing(self.bottle_settings(), glass=not contact, bottom=top),
            KETTLE: PlateDrawing(shape, boxes),
            SWITCH: ButtonDrawing(ButtonMount(LAYOUT.switch), _RED, cap=not contact),
            **super().drawings(),
        }

    def view(self) -> Camera:
        """From the arm's right shoulder, so that the arm hides neither bottle nor kettle."""
        return Camera((0.05, -1.35, 0.85), (0.6, 0.03, 0.15), 32.0)

    def adjustables(self) -> Sequence[Adjustable]:
        """Noise, pushes of the bottle where no plant holds it, and how much water of which temperature is wanted."""
        pushes = [push(BOTTLE, v, "m", self.config.fault.knock) for v in ("x", "y") if self.physics != "contact"]
        wanted = [least_wanted(BOTTLE, v, 0.0, 1.0, value) for v, value in (("water", 0.6), ("temperature", 0.9))]
        return (*super().adjustables(), *pushes, *wanted)

    def given(self) -> dict[str, Any]:
        """The configuration and the layout."""
        return super().given() | {"layout": geometry(LAYOUT)}
