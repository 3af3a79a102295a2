"""The microwave oven (paper sec. V, fig. 5): hand, door, on/off button, power knob and food.

Given: the places of things (`MicrowaveLayout`), the camera's frame and the spread of starts, as in
`models/scenarios/microwave.yaml`. Everything else is learned.
"""

import dataclasses
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
from pydrake.common.schema import Transform
from pydrake.math import RigidTransform

from ichain_drake.demonstrations.table import Demonstration
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.objects import WorldObject
from ichain_drake.objects.drawings.oven import DialDrawing, DoorDrawing, FoodDrawing, PushDrawing
from ichain_drake.objects.parts.food import Food, FoodSettings
from ichain_drake.objects.parts.oven_part import Dial, OvenPart, PartMount, SlidingPart
from ichain_drake.objects.vessels.cup_settings import CupFaults
from ichain_drake.robot import BodySpec, hand_pose
from ichain_drake.scenarios.adjustable import Adjustable
from ichain_drake.scenarios.adjustable_goal import least_wanted
from ichain_drake.scenarios.appliance import MODELS, Appliance, ApplianceConfig
from ichain_drake.scenarios.config import ScenarioConfig
from ichain_drake.scenarios.faults import FAULTS, Faults, GoalFaultConfig
from ichain_drake.scenarios.given import geometry
from ichain_drake.scenarios.object_maker import ObjectMaker
from ichain_drake.scenarios.probes import Probes
from ichain_drake.scenarios.scripted_piece import ScriptedPiece
from ichain_drake.settings import setting
from ichain_drake.state import FloatArray
from ichain_drake.systems.microwave.demonstrations import script_pieces
from ichain_drake.systems.microwave.layout import LAYOUT, MicrowaveStart
from ichain_drake.systems.microwave.motion import OvenMotion
from ichain_drake.systems.microwave.probes import OvenProbes
from ichain_drake.systems.microwave.teleoperation import HOLD
from ichain_drake.visualization import Camera

HAND, DOOR, BUTTON, KNOB, FOOD = "hand", "door", "button", "knob", "food"
_PARTS: dict[str, tuple[type[OvenPart], PartMount]] = {
    DOOR: (SlidingPart, LAYOUT.door),
    BUTTON: (SlidingPart, LAYOUT.button),
    KNOB: (Dial, LAYOUT.knob),
}
_STIFF = (BUTTON, KNOB)  # what the fault of that name meets


@dataclass
class OvenStartConfig:
    """How a run begins.

    Attributes:
        food: middle of the places where the food may stand, x, y in the robot's frame [m].
        spread: how far from there along x and y [m].
        temperature: of the food, from, to.
        knob: angle, from, to [rad].
    """

    food: list[float] = setting(lambda: [0.63, -0.28], "m", size=2, lower=-2, upper=2)
    spread: list[float] = setting(lambda: [0.012, 0.025], "m", size=2, lower=0, upper=1)
    temperature: list[float] = setting(lambda: [0.0, 0.2], size=2, lower=0, upper=1, rising=True)
    knob: list[float] = setting(lambda: [0.0, 0.08], "rad", size=2, lower=0, upper=LAYOUT.knob.travel, rising=True)


@dataclass
class MicrowaveConfig(ApplianceConfig):
    """Configuration of the microwave oven.

    Attributes:
        goal, camera_shift: see `ApplianceConfig`.
        start, fault: see there; `stiff` meets button and knob, what else goes wrong the food, and a knock is less than
            what the goal lets it be off.
    """

    start: OvenStartConfig = field(default_factory=OvenStartConfig)
    fault: GoalFaultConfig = field(default_factory=lambda: GoalFaultConfig(knock=0.02))


class Microwave(Appliance[MicrowaveStart]):
    """See the module's description and `GraphScenario`."""

    name: ClassVar[str] = "microwave"
    config_class: ClassVar[type[ScenarioConfig]] = MicrowaveConfig
    faults: ClassVar[tuple[str, ...]] = FAULTS
    displaced: ClassVar[tuple[str, ...]] = (FOOD,)
    closes_by: ClassVar[float] = 0.05
    script_purpose: ClassVar[int] = 1
    config: MicrowaveConfig

    def make_graph(self) -> InteractionGraph:
        """The seven interactions of paper fig. 5."""
        parts = {name: kind.make_space(mount) for name, (kind, mount) in _PARTS.items()}
        objects = {HAND: self.config.robot.hand.space, **parts, FOOD: Food.state_space}
        by_hand = [(HAND, child) for child in (DOOR, BUTTON, KNOB, FOOD)]
        return InteractionGraph(objects, [*by_hand, *((part, FOOD) for part in (KNOB, BUTTON, DOOR))])

    def food_settings(self, faults: Faults | None = None) -> FoodSettings:
        """Geometry of the food and of what it meets, and what goes wrong."""
        wrong = faults or Faults()
        settings = LAYOUT.food_settings(self.camera())
        return dataclasses.replace(settings, faults=CupFaults(wrong.slips, wrong.knocks, wrong.away))

    def draw_start(self, rng: np.random.Generator) -> MicrowaveStart:
        """The food's place and temperature and the knob's angle vary; the oven is open and off."""
        config = self.config.start
        place = np.array(config.food) + rng.uniform(-1.0, 1.0, 2) * config.spread
        return MicrowaveStart(
            (float(place[0]), float(place[1])),
            float(rng.uniform(config.temperature[0], config.temperature[1])),
            door=LAYOUT.door.travel,
            knob=float(rng.uniform(config.knob[0], config.knob[1])),
            hand=self.home(),
        )

    def make_objects(self, start: MicrowaveStart, make: ObjectMaker) -> Mapping[str, WorldObject]:
        """The oven's parts and the food."""
        coordinates = self._coordinates(start)

        def part(name: str) -> OvenPart:
            kind, mount = _PARTS[name]
            if name in _STIFF:
                mount = dataclasses.replace(mount, stiff=make.faults.stiffness)
            return make(kind, name, lambda part: part.state_at(coordinates[name]), mount=mount)

        def placed(food: Food) -> FloatArray:
            return food.state_at((*start.food, self._middle(start)), start.temperature)

        food = make(Food, FOOD, placed, dropouts=make.faults.dropouts, food=self.food_settings(make.faults))
        return {**{name: part(name) for name in _PARTS}, FOOD: food}

    @staticmethod
    def _coordinates(start: MicrowaveStart) -> dict[str, float]:
        return {DOOR: start.door, BUTTON: start.button, KNOB: start.knob}

    def _middle(self, start: MicrowaveStart) -> float:
        """Height of the food's middle [m]."""
        return (LAYOUT.cavity[2] if start.inside else 0.0) + self.food_settings().height / 2

    def bodies(self, start: MicrowaveStart, faults: Faults) -> Mapping[str, BodySpec]:
        """The oven's parts, whose models have their names, and the food."""
        parts = {
            name: BodySpec(
                f"{MODELS}/microwave/{name}{'_stiff' if name in _STIFF and faults.stiffness != 1.0 else ''}.sdf",
                Transform(translation=list(_PARTS[name][1].point)),
                joints={"move": coordinate},
            )
            for name, coordinate in self._coordinates(start).items()
        }
        food = Transform(translation=[*start.food, self._middle(start)])
        return {**parts, FOOD: BodySpec(f"{MODELS}/microwave/food.sdf", food, fixed=False)}

    def spared(self, place: FloatArray) -> bool:
        """Food inside the oven."""
        return self.food_settings().oven.cavity.holds(place.tolist(), False)

    def make_motion(self) -> OvenMotion | None:
        """Ways of the hand around the oven; in `ideal` a point hits nothing.

        Given beside the models: food is held at its middle.
        """
        if self.physics == "ideal":
            return None
        spec = self.config.robot
        grasp = hand_pose(spec.hand.full(np.array([0.0, 0.0, 0.0, 0.0, 1.0])))
        middle = RigidTransform([0.0, 0.0, self.food_settings().height / 2 - HOLD])

        def bodies(door: float) -> Mapping[str, BodySpec]:
            return self.bodies(MicrowaveStart((0.0, 0.0), 0.0, door=door), Faults())

        return OvenMotion(spec, bodies, DOOR, self.start(0).door, {FOOD: grasp.inverse() @ middle})

    def script(self, rng: np.random.Generator) -> Iterable[ScriptedPiece[MicrowaveStart]]:
        """See `script_pieces`."""
        return script_pieces(rng, bodies=self.physics == "contact")

    def probes(self, edge: Interaction, pieces: Sequence[Demonstration], count: int) -> Probes | None:
        """States around the border of an interaction; see `HasProbes`. For an evaluation alone."""
        return OvenProbes(self).make(edge, pieces, count)

    def drawings(self) -> Mapping[str, Any]:
        """Food and the oven's parts; the oven's body and the hand too where no plant shows them."""
        solid = self.physics != "contact"
        on_from = self.food_settings().oven.on_from
        drawings: dict[str, Any] = {
            BUTTON: PushDrawing(LAYOUT.button, on_from, cap=solid),
            KNOB: DialDrawing(LAYOUT.knob, knob=solid),
            FOOD: FoodDrawing(self.food_settings(), block=solid),
        }
        if solid:
            _, y0, z0, _, y1, z1 = LAYOUT.cavity
            panel = (LAYOUT.front - 0.02, y0, z0 + 0.002, LAYOUT.front - 0.002, y1, z1 - 0.002)
            boxes = LAYOUT.boxes if self.physics == "ideal" else ()
            drawings[DOOR] = DoorDrawing(LAYOUT.door, panel, boxes)
        return {**drawings, **super().drawings()}

    def view(self) -> Camera:
        """From the arm's left shoulder."""
        return Camera((-0.1, -1.0, 0.75), (0.62, 0.02, 0.12), 32.0)

    def adjustables(self) -> Sequence[Adjustable]:
        """Noise, and how hot the food is wanted."""
        return (*super().adjustables(), least_wanted(FOOD, "temperature", 0.0, 1.0, 0.8))

    def given(self) -> dict[str, Any]:
        """The configuration and the layout."""
        return super().given() | {"layout": geometry(LAYOUT), "food_in_hand": {"height": HOLD}}
