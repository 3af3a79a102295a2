"""A pot under a lid that a spring shuts: one hand holds it open, the other one pours.

Given: the places and shapes of things (`PotLayout`), where the hands are at first, the spread of starts, and what
faults do, as in `models/scenarios/lidded_pot.yaml`. Everything else is learned: that either hand can take lid or jug,
that the lid shuts by itself, and that water gets into the pot only while it is open.
"""

import dataclasses
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np

from ichain_drake.errors import InputError
from ichain_drake.graph import InteractionGraph
from ichain_drake.objects import Jug, Lid, Pot, WorldObject
from ichain_drake.objects.drawings.pot import JugDrawing, LidDrawing, PotDrawing
from ichain_drake.robot import Physics, RobotSpec
from ichain_drake.scenarios.adjustable import Adjustable
from ichain_drake.scenarios.adjustable_goal import least_wanted
from ichain_drake.scenarios.config import ScenarioConfig
from ichain_drake.scenarios.given import geometry
from ichain_drake.scenarios.graph_scenario import GraphConfig, GraphScenario
from ichain_drake.scenarios.object_maker import ObjectMaker
from ichain_drake.scenarios.scripted_piece import ScriptedPiece
from ichain_drake.settings import setting
from ichain_drake.state import FloatArray
from ichain_drake.systems.lidded_pot.demonstrations import script_pieces
from ichain_drake.systems.lidded_pot.layout import HANDS, JUG, LAYOUT, LID, POT, PotStart
from ichain_drake.visualization import Camera


@dataclass
class PotStartConfig:
    """How a run begins.

    Attributes:
        jug: middle of the places where the jug may stand, along y [m].
        spread: how far from there [m].
        water, pot_water: what jug and pot hold, from, to.
    """

    jug: float = setting(-0.26, "m", lower=-0.45, upper=-0.15)
    spread: float = setting(0.03, "m", lower=0, upper=0.2)
    water: list[float] = setting(lambda: [0.75, 0.95], size=2, lower=0, upper=1, rising=True)
    pot_water: list[float] = setting(lambda: [0.0, 0.1], size=2, lower=0, upper=1, rising=True)


@dataclass
class PotConfig(GraphConfig):
    """Configuration of the lidded pot.

    Attributes:
        goal, fault: see `GraphConfig`; slips and drop-outs meet the jug.
        hands: `left_hand` and `right_hand`, or one of them alone; what the goal says of the other is left out then.
        homes: where each hand is at first, y, z [m].
        start: see there.
    """

    hands: list[str] = field(default_factory=lambda: list(HANDS))
    homes: dict[str, list[float]] = setting(
        lambda: {"left_hand": [0.30, 0.36], "right_hand": [-0.30, 0.36]}, "m", lower=-0.5, upper=0.6
    )
    start: PotStartConfig = field(default_factory=PotStartConfig)


class LiddedPot(GraphScenario[PotStart]):
    """See the module's description and `GraphScenario`."""

    name: ClassVar[str] = "lidded_pot"
    config_class: ClassVar[type[ScenarioConfig]] = PotConfig
    physics_kinds: ClassVar[tuple[Physics, ...]] = ("ideal", "arm", "contact")
    faults: ClassVar[tuple[str, ...]] = ("none", "slip", "dropout")
    config: PotConfig

    def check_config(self) -> None:
        """Refuse other hands, and physics with one arm.

        Raises:
            InputError: naming the setting.
        """
        super().check_config()
        hands, homes = self.config.hands, self.config.homes
        if not hands or not set(hands) <= set(HANDS):
            raise InputError(
                f"hands: {', '.join(hands) or 'none'} given; they are {' and '.join(HANDS)}, or one of them"
            )
        if set(homes) != set(HANDS) or any(len(at) != 2 for at in homes.values()):  # noqa: PLR2004 - y, z
            raise InputError(f"homes: {homes} given; say where {' and '.join(HANDS)} are: y, z")
        absent = set(HANDS) - set(hands)
        self.config.goal = [text for text in self.config.goal if not any(hand in text for hand in absent)]
        if self.physics != "ideal":
            raise InputError(
                f"{self.name}: physics {self.physics} has one arm that moves in space; a system with two hands is for "
                "ideal"
            )

    def make_graph(self) -> InteractionGraph:
        """Either hand may hold lid and jug."""
        hands = self._hands
        objects = {h: self.config.robot.hand.space for h in hands}
        objects |= {LID: Lid.space(hands), JUG: Jug.space(hands), POT: Pot.state_space}
        by_hand = [(h, what) for what in (LID, JUG) for h in hands]
        return InteractionGraph(objects, [*by_hand, (LID, POT), (JUG, POT)], robots=hands if len(hands) > 1 else ())

    @property
    def _hands(self) -> tuple[str, ...]:
        return tuple(h for h in HANDS if h in self.config.hands)

    def robots(self) -> Mapping[str, RobotSpec]:
        """The same hand twice, at home in different places."""
        spec, at = self.config.robot, self.config.homes
        return {h: dataclasses.replace(spec, home={"y": at[h][0], "z": at[h][1]}) for h in self._hands}

    def start_hands(self, start: PotStart) -> Mapping[str, FloatArray]:
        """The full hand state that each hand starts from, shape (7,) each."""
        return {h: self.config.robot.hand.full(np.array(start.hands[h])) for h in self._hands}

    def draw_start(self, rng: np.random.Generator) -> PotStart:
        """The jug's place and what jug and pot hold vary."""
        config = self.config.start
        hands = {h: (*self.config.homes[h], 0.0, 0.0) for h in self._hands}
        return PotStart(
            hands,
            config.jug + float(rng.uniform(-1.0, 1.0)) * config.spread,
            float(rng.uniform(config.water[0], config.water[1])),
            float(rng.uniform(config.pot_water[0], config.pot_water[1])),
        )

    def make_objects(self, start: PotStart, make: ObjectMaker) -> Mapping[str, WorldObject]:
        """Lid, jug and pot."""
        faults = make.faults
        settings = dataclasses.replace(LAYOUT.jug, slips=faults.slips)

        def lid(made: Lid) -> FloatArray:
            state = made.default_state()
            state[0] = start.lid
            return state

        def jug(made: Jug) -> FloatArray:
            z = start.hands[start.held][1] if start.held else None
            return made.state_at(start.jug, start.water, start.held, z)

        return {
            LID: make(Lid, LID, lid, mount=LAYOUT.lid),
            JUG: make(Jug, JUG, jug, dropouts=faults.dropouts, jug=settings),
            POT: make(Pot, POT, lambda made: made.state_at(start.pot_water), pot=LAYOUT.pot),
        }

    def script(self, rng: np.random.Generator) -> Iterable[ScriptedPiece[PotStart]]:
        """See `script_pieces`."""
        return script_pieces(rng, {h: self.config.homes[h] for h in self._hands})

    def drawings(self) -> Mapping[str, Any]:
        """Lid, jug, pot and the hands."""
        x = self.config.robot.hand.held["x"] + LAYOUT.beyond
        return {
            LID: LidDrawing(LAYOUT.lid, x, 2.1 * LAYOUT.radius),
            JUG: JugDrawing(LAYOUT.jug, x, 0.01),
            POT: PotDrawing(LAYOUT.pot, x, LAYOUT.radius),
            **super().drawings(),
        }

    def view(self) -> Camera:
        """From before the table, over the hands."""
        return Camera((-0.4, -0.35, 0.8), (0.62, 0.0, 0.2), 33.0)

    def adjustables(self) -> Sequence[Adjustable]:
        """Noise, and how much water is wanted in the pot."""
        return (*super().adjustables(), least_wanted(POT, "water", 0.0, 1.0, 0.5))

    def given(self) -> dict[str, Any]:
        """The configuration and the layout."""
        return super().given() | {"layout": geometry(LAYOUT)}
