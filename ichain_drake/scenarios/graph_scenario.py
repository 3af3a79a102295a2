"""A scenario with a goal over its graph: what worlds, demonstrations and playbacks of all such scenarios share."""

# No `from __future__ import annotations`: Drake's typed YAML reader needs the fields' types themselves.

import dataclasses
import itertools
from abc import abstractmethod
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar, Generic

import numpy as np
from pydrake.systems.framework import Diagram

from ichain_drake.control.execution.course import RobotMotion
from ichain_drake.control.planning.planner import PLANNERS
from ichain_drake.control.tracking.path import TimedPath
from ichain_drake.demonstrations.table import Demonstration
from ichain_drake.errors import InputError
from ichain_drake.objects.base import WorldObject
from ichain_drake.objects.rows import NotTogetherError
from ichain_drake.robot import BodySpec, Displacement, Physics, RobotSpec, build_robot, hand_pose
from ichain_drake.robot.arm import ArmRobot
from ichain_drake.scenarios.base import Progress, Scenario
from ichain_drake.scenarios.config import ScenarioConfig
from ichain_drake.scenarios.faults import Faults, GoalFaultConfig, draw_faults
from ichain_drake.scenarios.hand_commands import HandCommands
from ichain_drake.scenarios.object_maker import ObjectMaker
from ichain_drake.scenarios.scripted_piece import ScriptedPiece, StartT
from ichain_drake.scenarios.seats import Seat, hand_seat
from ichain_drake.settings import setting
from ichain_drake.simulation.commands import Commands
from ichain_drake.simulation.recorder import record
from ichain_drake.simulation.recording_together import nobody_looks, record_together
from ichain_drake.state import FloatArray
from ichain_drake.visualization import HandDrawing
from ichain_drake.world.world import World

_RUNS_PER_SEED = 1000
FIRST_DEMONSTRATION = 900
"""Number of the run in which a script's first piece is recorded. Runs of an evaluation are below: the script's noise is
never theirs."""

_STARTS, _FAULTS = 0, 1  # purposes of random numbers
_IDEAL_ALONE = "{}: physics {} has one arm, and it has several hands ({}); choose ideal"
_OPEN = 0.08  # m between the fingers of a hand that is drawn open


@dataclass
class GraphConfig(ScenarioConfig):
    """Configuration of a scenario with a goal.

    Attributes:
        goal: what `run` and `plan` ask for where the command line says nothing else, such as `object.variable >= 0.5`,
            `keep object.variable within 0.02` or `not parent->child`.
        fault: what goes wrong, and how much.
        planner: `fast` for a plan of few steps, `optimal` for that of least expected time, which takes longer to find.
    """

    goal: list[str] = field(default_factory=list)
    fault: GoalFaultConfig = field(default_factory=GoalFaultConfig)
    planner: str = setting("fast", choices=PLANNERS)


class GraphScenario(Scenario, Generic[StartT]):
    """A scenario whose goal is a state of its graph: bounds on variables, and interactions that are over.

    A subclass has a `name`, may have a `config_class`, and provides `make_graph`, `draw_start`, `make_objects` and
    `script`; what it has of bodies, drawings, ways of the hand and faults, it adds. `StartT` is whatever it lets vary
    from run to run.

    Args:
        overrides: `--set` settings.
        physics: `ideal`, `arm` or `contact`.
        seed: seed of the run.

    Raises:
        InputError: see `Scenario`; and on slips and knocks in `contact`, where the plant alone moves things, and on
            `moved` there unless something is `displaced`.
    """

    config_class: ClassVar[type[ScenarioConfig]] = GraphConfig
    config: GraphConfig
    closes_by: ClassVar[float] = 0.02
    """How far the fingers of a hand that is drawn come together when it grips [m]."""

    displaced: ClassVar[tuple[str, ...]] = ()
    """Objects that the fault `moved` meets in `contact`: free bodies, which a force on them alone brings elsewhere."""

    script_purpose: ClassVar[int] = 2
    """Key of the script's random numbers, beside the seed."""

    # What a subclass provides, beside `make_graph`.

    @abstractmethod
    def draw_start(self, rng: np.random.Generator) -> StartT:
        """The start of a run.

        Args:
            rng: draws what varies.
        """

    @abstractmethod
    def make_objects(self, start: StartT, make: ObjectMaker) -> Mapping[str, WorldObject]:
        """All objects but the robot, by name.

        Args:
            start: state that the world starts from.
            make: makes one, by its class and name; knows what goes wrong in this world (`make.faults`).
        """

    @abstractmethod
    def script(self, rng: np.random.Generator) -> Iterable[ScriptedPiece[StartT]]:
        """Short, unordered demonstrations, as hand commands that stand in for a person's.

        Args:
            rng: draws starts and the unsteadiness of the person's hand.
        """

    def bodies(self, start: StartT, faults: Faults) -> Mapping[str, BodySpec]:
        """Bodies in the arm's plant, by object name; `contact` needs them for whatever a hand touches."""
        return {}

    def spared(self, place: FloatArray) -> bool:
        """Whether nobody displaces anything from or to a place in the robot's frame [m], shape (3,), in `contact`."""
        return False

    def start_hand(self, start: StartT) -> FloatArray:
        """The full hand state that a world starts from, shape (7,): at home unless overridden."""
        return self.config.robot.home_hand()

    def robots(self) -> Mapping[str, RobotSpec]:
        """The robots by name; override it, and `start_hands`, where the graph has several: in `ideal` alone."""
        return {self.graph.root: self.config.robot}

    def start_hands(self, start: StartT) -> Mapping[str, FloatArray]:
        """The full hand state that each robot starts from, shape (7,) each."""
        return {self.graph.root: self.start_hand(start)}

    def make_motion(self) -> RobotMotion | None:
        """Ways of the hand around what stands in its way; None for straight lines."""
        return None

    def drawings(self) -> Mapping[str, Any]:
        """See `Scenario`; here the hand, where no plant shows it."""
        if self.physics != "ideal":
            return {}
        return {name: _drawn_hand(spec, self.closes_by) for name, spec in self.robots().items()}

    # What all of them share.

    def hand_commands(self, start: FloatArray | Sequence[float] | None = None) -> HandCommands:
        """What a script lays its commands out with.

        Args:
            start: the hand's exposed variables at the start, shape (n_hand,); default at home.
        """
        spec = next(iter(self.robots().values()))
        at_start = spec.hand.reduce(spec.home_hand()) if start is None else start
        return HandCommands(spec.hand.space.names, at_start)

    def check_config(self) -> None:
        """Refuse faults that the physics can't have."""
        super().check_config()
        kind = self.config.fault.kind
        refused = ("slip", "knock") if self.displaced else ("slip", "knock", "moved")
        if self.physics == "contact" and kind in refused:
            raise InputError(f"fault.kind {kind}: in contact the plant alone moves things; choose ideal or arm")

    def start(self, run: int) -> StartT:
        """The start of a run.

        Args:
            run: number of the run.
        """
        return self.draw_start(np.random.default_rng([self.seed, _STARTS, run]))

    def draw_faults(self, run: int) -> Faults:
        """What the configured fault does in a run."""
        return draw_faults(self.config.fault, np.random.default_rng([self.seed, _FAULTS, run]))

    def make_world(self, run: int) -> World:
        """The world of a run, with the fault that the configuration asks for; its default context is the start.

        Args:
            run: number of the run; keys its start, noise and faults.
        """
        return self.build_world(self.start(run), run, faulty=True)

    def start_world(self, path: str | TimedPath = "", run: int = 0) -> World:
        """As `make_world`; it has no paths."""
        if path:
            raise InputError(f"{self.name} has no paths; leave path {path!r} out")
        return self.make_world(run)

    def build_world(self, start: StartT, run: int, physics: Physics | None = None, *, faulty: bool = False) -> World:
        """A world whose default context is any start state.

        Args:
            start: state that it starts from.
            run: keys noise and faults.
            physics: in place of the scenario's.
            faulty: whether the configured fault happens.

        Raises:
            InputError: in `contact`, if no object has a body to touch; with several robots in any physics but `ideal`.
        """
        physics = physics or self.physics
        if physics != "ideal" and len(self.graph.roots) > 1:
            raise InputError(_IDEAL_ALONE.format(self.name, physics, " and ".join(self.graph.roots)))
        seed, faults = self.seed * _RUNS_PER_SEED + run, self.draw_faults(run) if faulty else Faults()
        bodies = self.bodies(start, faults)
        if physics == "contact" and not bodies:
            raise InputError(f"{self.name}: no object has a body that a hand could touch; choose ideal or arm")
        moves = tuple(Displacement(time, x, y, faults.away, self.spared) for time, x, y in faults.knocks)
        displacements = dict.fromkeys(self.displaced, moves) if moves else None
        hands, several = self.start_hands(start), len(self.graph.roots) > 1
        robots = {
            name: build_robot(
                self._noisy(spec), physics, bodies, seed, k if several else 0,
                start=hands[name], displacements=displacements,
            )
            for k, (name, spec) in enumerate(self.robots().items())
        }  # fmt: skip
        robot = robots[self.graph.root]
        touched = bodies if isinstance(robot, ArmRobot) and physics == "contact" else {}
        sizes = {name: robot.body_size(name) for name in touched}  # type: ignore[union-attr] # an ArmRobot
        make = ObjectMaker(self.graph, seed, self.config.noise.scale, sizes, faults)
        return World(self.graph, robots, dict(self.make_objects(start, make)))

    def _noisy(self, spec: RobotSpec) -> RobotSpec:
        """A robot with its sensor noise at this run's scale."""
        noise = {name: self.config.noise.scale * std for name, std in spec.hand.noise_std.items()}
        return dataclasses.replace(spec, hand=dataclasses.replace(spec.hand, noise_std=noise))

    def record_demonstrations(
        self, progress: Progress | None = None, known: Collection[str] = ()
    ) -> Iterator[Demonstration]:
        """Record the script's pieces.

        Args:
            progress: called with a line before each piece.
            known: names of interactions that need no demonstration: pieces that show no other are left out.

        Raises:
            InputError: on a piece whose commands are not the hand's.
        """
        pieces, names = self._needed(known), tuple(self.graph.objects)
        together = _recorded_together([(self, pieces)])
        for run, piece in pieces:
            ticks = len(piece.commands)
            if progress:
                progress(f"{piece.name}: {ticks} ticks ({self.physics})")
            if together is None:
                yield record(self.build_world(piece.start, run), Commands(piece.commands), ticks, names, piece.name)
            else:
                yield next(together)

    def _needed(self, known: Collection[str] = ()) -> list[tuple[int, ScriptedPiece[StartT]]]:
        """Pieces that show what is not known, each with the number of the run that it is recorded in."""
        if {e.name for e in self.graph.interactions} <= set(known):
            return []
        rng = np.random.default_rng([self.seed, self.script_purpose])
        pieces = []
        for number, piece in enumerate(self.script(rng)):
            piece.check(self.graph)
            if piece.is_needed(known):
                pieces.append((FIRST_DEMONSTRATION + number, piece))
        return pieces

    def drawn_plant(self) -> Diagram | None:
        """The arm and what stands there; None in `ideal`."""
        if self.physics == "ideal":
            return None
        world = self.build_world(self.start(0), 0)
        return world.robot if isinstance(world.robot, Diagram) else None

    def seats(self) -> Mapping[str, Seat]:
        """The hand; of several each by itself, while the others stay."""
        return {n: hand_seat(self, lambda run: self.build_world(self.start(run), run), n) for n in self.graph.roots}


def record_seeds(scenarios: Sequence[Scenario]) -> list[list[Demonstration]]:
    """The demonstrations of each of several scenarios, in `ideal` physics recorded all at once where that can be.

    Args:
        scenarios: differ in their seeds alone.

    Raises:
        InputError: as `record_demonstrations`.
    """
    own = GraphScenario.record_demonstrations
    scripts = [
        (s, s._needed()) for s in scenarios if isinstance(s, GraphScenario) and type(s).record_demonstrations is own
    ]
    together = _recorded_together(scripts) if len(scripts) == len(scenarios) else None
    if together is None:
        return [list(s.record_demonstrations()) for s in scenarios]
    return [list(itertools.islice(together, len(pieces))) for _, pieces in scripts]


def _recorded_together(
    scripts: Sequence[tuple[GraphScenario[Any], Sequence[tuple[int, ScriptedPiece[Any]]]]],
) -> Iterator[Demonstration] | None:
    """All pieces at once, which takes a fraction of the time; None where they can't, or somebody looks."""
    first, pieces = scripts[0][0], [piece for _, script in scripts for _, piece in script]
    if first.physics != "ideal" or len(pieces) < 2 or not nobody_looks():  # noqa: PLR2004 - several
        return None
    worlds = [scenario.build_world(piece.start, run) for scenario, script in scripts for run, piece in script]
    commands, names = [p.commands for p in pieces], [p.name for p in pieces]
    try:
        return record_together(worlds, commands, tuple(first.graph.objects), names)
    except NotTogetherError:
        return None


def _drawn_hand(spec: RobotSpec, closes_by: float) -> HandDrawing:
    hand = spec.hand
    if "grip" not in hand.space.names:
        return HandDrawing(lambda state: (hand_pose(hand.full(state)), _OPEN))
    grip = hand.space.index("grip")
    return HandDrawing(lambda state: (hand_pose(hand.full(state)), _OPEN - closes_by * round(state[grip])))
