"""What an episode is worth: reward and end, from a scenario's goal or path, in truth."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ichain_drake.control.execution.memory import ExecutorSettings
from ichain_drake.control.planning.goal_text import Bound, check_goal_text, read_goal_text
from ichain_drake.control.tracking.path import TimedPath
from ichain_drake.errors import InputError
from ichain_drake.graph import InteractionGraph
from ichain_drake.scenarios.base import PathScenario
from ichain_drake.simulation.path_watch import PathWatch
from ichain_drake.state import FloatArray
from ichain_drake.timing import TICK

States = Mapping[str, FloatArray]


@dataclass(frozen=True)
class Verdict:
    """What a tick was worth.

    Attributes:
        reward: of the tick.
        terminated: whether the task is over.
        success: whether it was done.
    """

    reward: float
    terminated: bool
    success: bool


class Judge(ABC):
    """Watches one episode after another.

    Attributes:
        names: of what it adds to observations.
        limit: ticks after which an episode is cut short.
    """

    names: tuple[str, ...] = ()
    limit: int

    @abstractmethod
    def begin(self, truth: States, active: States) -> None:
        """An episode begins.

        Args:
            truth: true states by object, shape (n_variables,) each.
            active: true flags of every object's incoming interactions, shape (n_parents,) each.
        """

    @abstractmethod
    def see(self, measured: States, frames: Sequence[States], active: States) -> Verdict:
        """A tick is over.

        Args:
            measured: readings at its end, shape (n_observable,) each.
            frames: true states at its start and at the end of each of its frames.
            active: flags at its end.
        """

    def observe(self, measured: States) -> FloatArray:
        """What it adds to an observation, shape (len(names),)."""
        return np.empty(0)


class GoalJudge(Judge):
    """A goal over the graph: rewards are changes of the share of its conditions that hold, so they sum to at most 1.

    Args:
        expressions: see `ichain run --goal`; `start` and `keep` refer to the true states at the start.
        graph: has the names.

    Raises:
        InputError: on an expression that can't be read, or asks a real number to be equal to something: how near is
            equal is told from demonstrations, which an environment has none of.
    """

    limit = ExecutorSettings.ticks

    def __init__(self, expressions: Sequence[str], graph: InteractionGraph) -> None:
        check_goal_text(expressions, graph)
        clauses = [read_goal_text(text, graph) for text in expressions]
        self._graph = graph
        self._bounds = [b for c in clauses for b in c.bounds]
        self._active = [e for c in clauses for e in c.active]
        self._inactive = [e for c in clauses for e in c.inactive]
        for b in self._bounds:
            space = graph.objects[b.object]
            if b.sign == "==" and space.variables[space.index(b.variable)].kind not in ("binary", "integer"):
                raise InputError(
                    f"goal: {b.object}.{b.variable} is a real number, and nothing tells here how near is equal; write "
                    f"low <= {b.object}.{b.variable} <= high"
                )

    def begin(self, truth: States, active: States) -> None:
        """Remember the start."""
        self._start = [self._value(b, truth) for b in self._bounds]
        self._share = self._held(truth, active)

    def see(self, measured: States, frames: Sequence[States], active: States) -> Verdict:
        """The change of the share; over when all hold."""
        before, self._share = self._share, self._held(frames[-1], active)
        done = self._share == 1.0
        return Verdict(self._share - before, done, done)

    def _value(self, bound: Bound, truth: States) -> float:
        return float(truth[bound.object][self._graph.objects[bound.object].index(bound.variable)])

    def _held(self, truth: States, active: States) -> float:
        held = [_holds(b, self._value(b, truth), start) for b, start in zip(self._bounds, self._start, strict=True)]
        for edges, wanted in ((self._active, True), (self._inactive, False)):
            for e in edges:
                flag = active[e.child][self._graph.parents(e.child).index(e.parent)]
                held.append(bool(flag > 0.5) == wanted)  # noqa: PLR2004 - a flag
        return sum(held) / len(held)


def _holds(bound: Bound, value: float, start: float) -> bool:
    wanted = start if bound.value is None else bound.value
    holds = {
        ">=": value >= wanted,
        ">": value > wanted,
        "<=": value <= wanted,
        "<": value < wanted,
        "==": value == wanted,
        "within": abs(value - start) <= wanted,
    }
    return holds[bound.sign]


class PathJudge(Judge):
    """A path to follow: a tick's reward is the progress in ticks of the path's time, less the distance in corridors.

    Who keeps to the path at its pace gets 1 a tick; who stands still on it, 0. Observations get the wanted positions of
    the coming ticks, relative to where the object is measured.

    Args:
        scenario: its target follows.
        path: the timed path.
        lookahead: ticks of wanted positions, from 1.
    """

    def __init__(self, scenario: PathScenario, path: TimedPath, lookahead: int) -> None:
        if lookahead < 1:
            raise InputError(f"lookahead {lookahead}: give a number of ticks from 1")
        space = scenario.graph.objects[scenario.target]
        self.path, self._target = path, scenario.target
        self._measured = list(scenario.target_indices())
        self._true = list(space.indices(scenario.target_variables))
        self._ahead = TICK * np.arange(1, lookahead + 1)
        self.names = tuple(f"wanted.{v}+{k}" for k in range(1, lookahead + 1) for v in scenario.target_variables)
        self.limit = PathWatch(path).allowed

    def begin(self, truth: States, active: States) -> None:
        """At the path's first point."""
        self._watch = PathWatch(self.path)

    def see(self, measured: States, frames: Sequence[States], active: States) -> Verdict:
        """Progress less distance; over when the end is reached or passed, or the path is lost."""
        passed = np.array([truth[self._target][self._true] for truth in frames])
        last = self._watch.progress
        over = self._watch.see(measured[self._target][self._measured], passed, self.path, last)
        reached = self._watch.progress
        made = float(self.path.time[reached] - self.path.time[last]) / TICK
        away = math.dist(self.path.points[reached], passed[-1]) / self.path.limits.corridor
        return Verdict(made - away, over, self._watch.arrival.arrived)

    def observe(self, measured: States) -> FloatArray:
        """Wanted positions less the measured one, shape (2 x lookahead,)."""
        wanted = self.path.at_time(self.path.time[self._watch.progress] + self._ahead)
        return np.asarray(wanted - measured[self._target][self._measured], dtype=float).ravel()
