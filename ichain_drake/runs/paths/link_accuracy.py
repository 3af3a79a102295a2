"""How well a chain's first link brings its child to wanted states: inverse model, command map, hand, child.

The measurement behind a chain's floor: whatever the first link is off, every further link inherits.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from pydrake.systems.framework import Context, State

from ichain_drake.control.ticks import TickSystem
from ichain_drake.control.tracking.levels import InverseLevel
from ichain_drake.control.tracking.move_to import MoveTo, RobotLevel
from ichain_drake.control.tracking.path import TimedPath
from ichain_drake.demonstrations.table import Demonstration
from ichain_drake.errors import InputError
from ichain_drake.graph import InteractionGraph
from ichain_drake.learning.chain.chain import LearnedChain, LinkCandidates, learn_chain
from ichain_drake.scenarios.base import PathScenario
from ichain_drake.simulation.episode import Episode
from ichain_drake.state import FloatArray, StateSpace
from ichain_drake.timing import FRAMES_PER_TICK

WANTED = 100
"""Held-out wanted states that a measurement asks for."""

_TICKS_EACH = 2  # the first ends while the child has just been moved, the second finds it at rest
_RUN = 904  # number of the run, which keys its noise: one that no demonstration and no path has


@runtime_checkable
class HasWantedStates(Protocol):
    """A scenario that says which states of the first link's child to ask for."""

    def held_out_wanted(self, count: int) -> FloatArray:
        """Wanted observable states of the first link's child, within reach and not from demonstrations, (count, n)."""


@dataclass(frozen=True)
class LinkAccuracy:
    """Root mean square differences between wanted and reached child states, over all variables, in the child's units.

    Attributes:
        edge: name of the interaction.
        samples: transitions that it was learned from.
        moving: what the sensor reads at the end of the tick in which the wanted state was first asked for.
        rest: the same one tick later.
        true_moving, true_rest: the same of the child's true state: without read noise and rounding.
        held: whether the interaction was active from the first tick's end to the last.
    """

    edge: str
    samples: int
    moving: float
    rest: float
    true_moving: float
    true_rest: float
    held: bool


class _Asker(TickSystem):
    """Asks a policy for one wanted child state after the other, each for some ticks.

    Ports: inputs named after robot and child for their `measured`; output `hand_command`.
    """

    def __init__(self, policy: MoveTo, spaces: Sequence[tuple[str, StateSpace]], wanted: FloatArray) -> None:
        super().__init__("asker")
        self._policy, self._wanted = policy, wanted
        self._ports = [self.DeclareVectorInputPort(name, len(space)) for name, space in spaces]
        self._command = self.DeclareDiscreteState((policy.robot.lower + policy.robot.upper) / 2)
        self.DeclareStateOutputPort("hand_command", self._command)

    def decide(self, context: Context, state: State, tick: int) -> None:
        """Ask for the tick's wanted state, or the last."""
        row = min(tick // _TICKS_EACH, len(self._wanted) - 1)
        states = [port.Eval(context)[None] for port in self._ports]
        command, _, _ = self._policy.decide(states, self._wanted[row][None, None], np.zeros((1, 0)))
        state.get_mutable_discrete_state().set_value(self._command, command[0])


def first_link_graph(graph: InteractionGraph, target: str) -> InteractionGraph:
    """Robot and first child of a chain alone."""
    robot, child = graph.chain(target)[:2]
    origins = {child: graph.origins[child]} if child in graph.origins else {}
    return InteractionGraph({n: graph.objects[n] for n in (robot, child)}, [(robot, child)], origins)


def learn_first_link(
    scenario: PathScenario, pieces: Sequence[Demonstration], candidates: dict[str, LinkCandidates]
) -> LearnedChain:
    """Learn the first link of a scenario's chain, as a chain of its own.

    Raises:
        InputError: if it can't be learned.
    """
    graph = first_link_graph(scenario.graph, scenario.target)
    child = graph.chain(next(n for n in graph.objects if n != graph.root))[-1]
    usable = [p for p in pieces if p.has(graph.root, graph.objects[graph.root])]
    return learn_chain(usable, graph, child, graph.objects[child].observable.names, candidates)


def measure_first_link(scenario: PathScenario, chain: LearnedChain, count: int = WANTED) -> LinkAccuracy:
    """Ask for held-out wanted states of the first child, by the learned inverse and command map, and see what comes.

    Args:
        scenario: makes the world; must say which states to ask for (`HasWantedStates`).
        chain: a learned chain; its first link is measured.
        count: number of wanted states.

    Raises:
        InputError: if the scenario doesn't say what to ask for, or gives states of a wrong shape.
    """
    if not isinstance(scenario, HasWantedStates):
        raise InputError(f"{scenario.name} does not say which states of the first link to ask for (held_out_wanted)")
    link = chain.links[0]
    robot, child = link.interaction.parent, link.interaction.child
    space = chain.graph.objects[child].observable
    wanted = np.asarray(scenario.held_out_wanted(count), dtype=float)
    if wanted.shape != (count, len(space)):
        raise InputError(f"held_out_wanted gave shape {wanted.shape}; {child} needs {(count, len(space))}")

    inverse = link.best_inverse.model
    level = InverseLevel(inverse, link.child_limit[list(inverse.targets)])
    hand = chain.graph.objects[robot].observable
    limits = (chain.command_lower, chain.command_upper)
    reach = RobotLevel(hand, chain.hand_limit, chain.command, *limits, chain.command_origin)
    targets = list(inverse.targets)
    asker = _Asker(MoveTo((level,), reach), [(robot, hand), (child, space)], wanted[:, targets])

    points = next(iter(scenario.reference_paths().values()))
    world = scenario.make_world(TimedPath(points, scenario.path_limits()), _RUN)
    episode = Episode(world, asker)
    episode.run(_TICKS_EACH * count)
    log = episode.log()

    ends = FRAMES_PER_TICK * np.arange(1, _TICKS_EACH * count + 1)
    full = chain.graph.objects[child]
    read = log.measured[child][ends].reshape(count, _TICKS_EACH, -1)
    true = log.states[child][ends][:, full.observable_indices].reshape(count, _TICKS_EACH, -1)
    column = world.graph.parents(child).index(robot)

    def rms(values: FloatArray) -> float:
        return float(np.sqrt(np.mean(space.difference(values, wanted)[:, targets] ** 2)))

    return LinkAccuracy(
        link.interaction.name,
        link.forward.samples,
        moving=rms(read[:, 0]),
        rest=rms(read[:, -1]),
        true_moving=rms(true[:, 0]),
        true_rest=rms(true[:, -1]),
        held=bool((log.active[child][ends, column] > 0.5).all()),
    )
