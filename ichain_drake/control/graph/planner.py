"""Planning over a learned interaction graph: breadth first over macro-actions, whole layers simulated at once.

A tick of the learned models costs nearly the same for one state as for hundreds. So the search expands many states at
a time, those first that are new and meet much of the goal, and finds a plan of few steps.
"""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ichain_drake.control.graph.goals import gap, impossible, kept_by_itself, value_of, words
from ichain_drake.control.graph.heuristics import Novelty, unmet_conditions
from ichain_drake.control.graph.macros import Carry, Drive, find_carries, find_drives
from ichain_drake.control.graph.model import Batch, BoolArray, GraphModel, span, stack
from ichain_drake.control.graph.places import carry_targets
from ichain_drake.control.graph.plan import Condition, Goal, NoPlan, Plan, PlanStep, States
from ichain_drake.control.graph.simulate import Outcome, settle, simulate
from ichain_drake.graph import Interaction
from ichain_drake.state import FloatArray

_NOISES = 3.0  # that a goal is to be met by, where it can be
_MARGIN = 0.05  # of the demonstrated range, the same
_SHARE = 0.25  # of a range, at most
_ALIKE = 1.2
_SWITCH_TICKS = 20  # to reach an object and take it, or press it, and to let go


@dataclass(frozen=True)
class SearchSettings:
    """How far a search goes.

    Attributes:
        width: states that are expanded at a time.
        steps: of a plan at most.
        novelty: 1 to expand only states with a new value, 2 also those with a new pair of values, 3 all.
        expansions: states that are expanded at most.
    """

    width: int = 48
    steps: int = 24
    novelty: int = 2
    expansions: int = 600


@dataclass(frozen=True, eq=False)
class _Node:
    states: Batch
    steps: tuple[PlanStep, ...]
    ticks: int
    unmet: tuple[int, ...]
    held: Interaction | None = None
    rank: int = 0


class GraphPlanner:
    """Plans with one learned graph.

    Args:
        model: the learned graph.
        settings: how far to search.
    """

    def __init__(self, model: GraphModel, settings: SearchSettings | None = None) -> None:
        self.model = model
        self.settings = settings or SearchSettings()
        self.carries = find_carries(model)
        self.drives = find_drives(model, self.carries)

    def plan(self, start: States, goal: Goal) -> Plan | NoPlan:
        """Find a plan.

        Args:
            start: measured states, shape (n_variables,) each.
            goal: ranges wanted at the same time.

        Returns:
            A plan, empty if the goal is met, or why there is none.
        """
        began = time.perf_counter()
        known = {n: np.asarray(start[n], dtype=float) for n in self.model.graph.objects}
        refused = impossible(goal, self.model, known)
        if refused is not None:
            return refused
        search = _Search(self, known, goal)
        found = search.run()
        if isinstance(found, NoPlan):
            return found
        effort = {"expansions": search.expansions, "rollouts": search.rollouts}
        return Plan(found.steps, found.ticks, **effort, seconds=time.perf_counter() - began)


class _Search:
    def __init__(self, planner: GraphPlanner, start: Mapping[str, FloatArray], goal: Goal) -> None:
        self.model, self.settings = planner.model, planner.settings
        self.carries, self.drives = planner.carries, planner.drives
        self.goal = goal
        self.surer = tuple(_inside(c, self.model) for c in goal.conditions)
        self.novelty = Novelty(self.model)
        self.expansions = self.rollouts = 0
        self.closed: set[tuple[object, ...]] = set()
        self.closest = [math.inf] * len(goal.conditions)
        self.nearest = [float(value_of(c, start, self.model.graph)) for c in goal.conditions]
        self.blame: list[Interaction | None] = [None] * len(goal.conditions)
        self.best: _Node | None = None
        self.start = dict(start)
        active = self.model.active(start)
        on = [e for e in self.model.graph.interactions if e.parent == self.model.graph.root and bool(active[e])]
        self.touching = tuple(on)
        self.parked = self._parked(bool(on))

    def _parked(self, busy: bool) -> FloatArray:
        """A state of the robot in which it acts on nothing: where it is, or where it was in a demonstration."""
        root = self.model.graph.root
        if not busy:
            return self.start[root]
        mine = [e for e in self.model.graph.interactions if e.parent == root]
        rows = np.concatenate([self.model.edges[e].examples.deactivations.after[root] for e in mine])
        states = {n: np.repeat(v[None], len(rows), axis=0) for n, v in self.start.items()} | {root: rows}
        surest = np.max([self.model.decide(e, states) for e in mine], axis=0)
        return rows[int(np.argmin(surest))]

    def run(self) -> _Node | NoPlan:
        held = next((e for e in self.touching if any(c.edge == e for c in self.carries)), None)
        first = _Node(self.start, (), 0, unmet_conditions(self.goal.conditions, self.start, self.model), held)
        self._note(first, None)
        if not first.unmet and not self._forbidden([first])[0]:
            return first
        layer, reserve = [first], []
        self.closed.add(self._key(first))
        if held is None and self.touching:  # a button under the hand: letting go is a step of its own
            edge = self.touching[0]
            states, _ = settle(self.model, stack([self.start]), self.parked)
            free = {n: v[0] for n, v in states.items()}
            step = PlanStep((edge,), predicted=free, ticks=_SWITCH_TICKS // 2)
            layer = [_Node(free, (step,), step.ticks, unmet_conditions(self.surer, free, self.model))]
            if not layer[0].unmet and not self._forbidden(layer)[0]:
                return layer[0]
        while layer and self.expansions < self.settings.expansions:
            children = self._expand(layer)
            forbidden = self._forbidden(children)
            done = [
                c
                for c, bad in zip(children, forbidden, strict=True)
                if not bad and not unmet_conditions(self.goal.conditions, c.states, self.model)
            ]
            if done:
                return min(done, key=lambda n: (len(n.unmet), n.ticks))
            queue = sorted([*reserve, *children], key=lambda n: (n.rank, len(n.unmet), n.ticks))
            queue = [n for n in queue if len(n.steps) < self.settings.steps and n.rank <= self.settings.novelty]
            layer, reserve = queue[: self.settings.width], queue[self.settings.width :]
        return self._failure()

    def _key(self, node: _Node) -> tuple[object, ...]:
        return (*self.novelty.key(node.states), node.unmet, node.held)

    def _forbidden(self, nodes: Sequence[_Node]) -> list[bool]:
        """Whether an interaction is active that must not be."""
        if not self.goal.inactive or not nodes:
            return [n.held is not None and n.held in self.goal.inactive for n in nodes]
        batch = stack([n.states for n in nodes])
        on = np.any([self.model.decide(e, batch) >= 0 for e in self.goal.inactive], axis=0)
        return [bool(x) for x in on]

    def _expand(self, layer: Sequence[_Node]) -> list[_Node]:
        self.expansions += len(layer)
        out = self._carried(layer) + self._driven(layer)
        kept: dict[tuple[object, ...], _Node] = {}
        for node in out:
            key = self._key(node)
            if key in self.closed:
                continue
            if key not in kept or _cheaper(node, kept[key]):
                kept[key] = node
        self.closed |= set(kept)
        return [replace(n, rank=self.novelty.rank(n.states, n.unmet)) for n in kept.values()]

    def _carried(self, layer: Sequence[_Node]) -> list[_Node]:
        moves: list[tuple[_Node, Carry, FloatArray]] = []
        for carry in self.carries:
            nodes = [n for n in layer if n.held in (None, carry.edge)]
            targets = carry_targets(self.model, carry, [n.states for n in nodes], self.start, self.surer)
            moves += [(n, carry, t) for n, places in zip(nodes, targets, strict=True) for t in places]
        if not moves:
            return []
        batch = stack([n.states for n, _, _ in moves])
        for k, (_, carry, place) in enumerate(moves):
            batch[carry.edge.child][k, carry.follow] = place
        after, _ = settle(self.model, batch, self.parked)
        self.rollouts += len(moves)
        out = []
        for k, (node, carry, place) in enumerate(moves):
            states = {n: v[k] for n, v in after.items()}
            wanted = self._pose(carry, place)
            ticks = _SWITCH_TICKS + self._way(carry, node.states[carry.edge.child][carry.follow], place)
            step = PlanStep((carry.edge,), wanted, after=wanted, predicted=states, ticks=ticks)
            out.append(self._child(node, step, states))
        return out

    def _driven(self, layer: Sequence[_Node]) -> list[_Node]:
        rows = [(n, d) for n in layer if n.held is None for d in self.drives]
        results = simulate(self.model, [(n.states, d) for n, d in rows], self.parked, self._stop)
        self.rollouts += len(rows)
        out = []
        for (node, drive), outcomes in zip(rows, results, strict=True):
            for outcome in outcomes:
                if outcome.lost is None:
                    out.append(self._child(node, self._step(node, drive, outcome), outcome.states))
        return out

    def _step(self, node: _Node, drive: Drive, outcome: Outcome) -> PlanStep:
        target = drive.chain[-1].child
        name = self.model.graph.objects[target].observable.names[drive.variable]
        until = (target, name, drive.direction, outcome.end)
        wanted, before, after, ticks = {}, {}, {}, _SWITCH_TICKS + outcome.ticks
        if drive.carry is not None:
            obj, part = drive.carry.edge.child, drive.carry.follow
            back = node.states[obj][part]
            wanted, before = self._pose(drive.carry, drive.hold[obj][part]), self._pose(drive.carry, drive.before[obj][part])
            after = self._pose(drive.carry, back)
            ticks += 2 * self._way(drive.carry, back, drive.before[obj][part])
        wanted = wanted | {(target, name): outcome.end}
        hold = drive.hold[self.model.graph.root]
        return PlanStep(
            drive.chain, wanted, until, hold, before, after, predicted=outcome.states, ticks=ticks
        )

    def _child(self, node: _Node, step: PlanStep, states: Batch) -> _Node:
        child = _Node(
            states, (*node.steps, step), node.ticks + step.ticks, unmet_conditions(self.surer, states, self.model)
        )
        self._note(child, step.chain[-1])
        return child

    def _pose(self, carry: Carry, values: FloatArray) -> dict[tuple[str, str], float]:
        obj = carry.edge.child
        names = self.model.graph.objects[obj].observable.names
        return {(obj, names[i]): float(x) for i, x in zip(carry.follow, values, strict=True)}

    def _way(self, carry: Carry, start: FloatArray, end: FloatArray) -> int:
        limit = np.maximum(self.model.step_limit[carry.edge.child][carry.follow], 1e-9)
        return int(np.ceil(np.max(np.abs(end - start) / limit)))

    def _stop(self, batch: Batch) -> BoolArray:
        met = [gap(c, value_of(c, batch, self.model.graph)) == 0 for c in self.surer]
        return np.stack(met, axis=1) if met else np.zeros((len(batch[self.model.graph.root]), 0), dtype=bool)

    # What to say where there is no plan.

    def _note(self, node: _Node, edge: Interaction | None) -> None:
        for k, c in enumerate(self.goal.conditions):
            value = float(value_of(c, node.states, self.model.graph))
            away = float(gap(c, value))
            if away < self.closest[k] - 1e-9:
                self.closest[k], self.nearest[k] = away, value
                self.blame[k] = edge if edge is not None and edge.child == c.object else self.blame[k]
        if self.best is None or len(node.unmet) < len(self.best.unmet):
            self.best = node

    def _failure(self) -> NoPlan:
        graph, conditions = self.model.graph, self.goal.conditions
        width = [float(span(self.model, c.object)[graph.objects[c.object].observable.index(c.variable)]) for c in conditions]
        never = [k for k in range(len(conditions)) if self.closest[k] > 0]
        effort = f"after {self.expansions} states were expanded"
        if never:
            k = max(never, key=lambda k: self.closest[k] / width[k])
            c, edge = conditions[k], self._edge_of(k)
            tail = "" if kept_by_itself(self.model, c) else "; it does not keep its value once it is let go"
            return NoPlan(
                c,
                self.nearest[k],
                edge,
                f"{words(c, graph)} can't be met: {self.nearest[k]:.4g} is the nearest that was predicted, "
                f"by {edge.name if edge else 'no interaction'}, {effort}{tail}",
            )
        assert self.best is not None
        if not conditions or not self.best.unmet:
            edge = self.goal.inactive[0]
            c = conditions[0] if conditions else Condition(edge.child, graph.objects[edge.child].names[0], -math.inf, math.inf)
            value = float(value_of(c, self.best.states, graph))
            return NoPlan(c, value, edge, f"{edge.name} can't be made inactive together with the rest, {effort}")
        k = max(self.best.unmet, key=lambda k: float(gap(conditions[k], value_of(conditions[k], self.best.states, graph))))
        c, value = conditions[k], float(value_of(conditions[k], self.best.states, graph))
        return NoPlan(
            c,
            value,
            self._edge_of(k),
            f"{words(c, graph)} can't be met together with the other conditions: it is {value:.4g} where most of them "
            f"hold, {effort}",
        )

    def _edge_of(self, k: int) -> Interaction | None:
        """The interaction that came nearest, or the first that changes the variable."""
        c = self.goal.conditions[k]
        index = self.model.graph.objects[c.object].observable.index(c.variable)
        acting = [e for e in self.model.graph.incoming(c.object) if any(f.variable == index for f in self.model.edges[e].effects)]
        return self.blame[k] or (acting[0] if acting else None)


def _cheaper(one: _Node, other: _Node) -> bool:
    """Whether a way to the same state is shorter; of nearly equal ones, that which watches more interactions."""
    mine, theirs = len(one.steps[-1].chain), len(other.steps[-1].chain)
    if len(one.steps) == len(other.steps) and mine != theirs:
        return one.ticks <= _ALIKE * other.ticks if mine > theirs else one.ticks * _ALIKE < other.ticks
    return one.ticks < other.ticks


def _inside(condition: Condition, model: GraphModel) -> Condition:
    """A condition that is met by a margin over the noise, where its range and the variable's bounds leave room."""
    space = model.graph.objects[condition.object].observable
    i = space.index(condition.variable)
    wide = max(_NOISES * float(model.noise[condition.object][i]), _MARGIN * float(span(model, condition.object)[i]))
    margin = min(wide, _SHARE * (condition.upper - condition.lower))
    low, high = condition.lower + margin, condition.upper - margin
    variable = space.variables[i]
    return replace(condition, lower=min(low, max(variable.upper, condition.lower)), upper=max(high, min(variable.lower, condition.upper)))
