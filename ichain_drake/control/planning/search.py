"""One search over options: breadth first, whole layers simulated at once.

A tick of the learned models costs nearly the same for one state as for hundreds. So many states are expanded at a time,
those first that are new and meet much of the goal, and the plan found is one of few steps.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

import networkx as nx
import numpy as np

from ichain_drake.control.planning.carries import CarryOption
from ichain_drake.control.planning.drive_option import DriveOption
from ichain_drake.control.planning.experience import Record, expected_ticks
from ichain_drake.control.planning.failure import Nearest
from ichain_drake.control.planning.failure_tree import failure_tree
from ichain_drake.control.planning.goals import inside, value_of
from ichain_drake.control.planning.heuristics import Alike, Landmarks, unmet_conditions
from ichain_drake.control.planning.holding import can_hold, hold_margin, hold_probability
from ichain_drake.control.planning.letting_go import in_hand, stays
from ichain_drake.control.planning.model import Batch, row, stack, take
from ichain_drake.control.planning.places import carry_targets, wanted_place
from ichain_drake.control.planning.plan import Goal, NoPlan, PlanStep
from ichain_drake.control.planning.risk import step_cost
from ichain_drake.control.planning.search_node import SearchNode, cheaper, mark_of
from ichain_drake.control.planning.search_settings import SearchSettings
from ichain_drake.control.planning.side import Side
from ichain_drake.control.planning.simulate import Outcome, settle, simulate
from ichain_drake.control.settings import PLANNING
from ichain_drake.graph import Interaction
from ichain_drake.learning.model import InteractionModel
from ichain_drake.learning.settings import LEARNING
from ichain_drake.state import FloatArray


class Search:
    """One search.

    Args:
        model: the learned graph.
        settings: how far to search.
        sides: what each robot can do.
        start: states, shape (n_variables,) each.
        goal: what is wanted.
        objects: those whose states tell states of the search apart; None for all.
        touching: interactions of robots that are active at the start.
        record: what executions contradicted.
    """

    def __init__(
        self,
        model: InteractionModel,
        settings: SearchSettings,
        sides: Sequence[Side],
        start: Mapping[str, FloatArray],
        goal: Goal,
        objects: Collection[str] | None,
        touching: tuple[Interaction, ...],
        record: Record | None = None,
    ) -> None:
        self.model, self.settings = model, settings
        self.sides = tuple(sides)
        self.goal = goal
        self.surer = tuple(inside(c, self.model, LEARNING.clear, LEARNING.near) for c in goal.conditions)
        self.alike = Alike(model, objects)
        self.landmarks = Landmarks(model, self.surer)
        self.expansions = self.rollouts = 0
        self.dropped = False  # whether a state was left out that might have led on
        self.barred = False  # whether one was left out since what led to it failed before
        self.closed: set[tuple[object, ...]] = set()
        self.nearest = Nearest(self.model, goal, start)
        self.start = dict(start)
        self.touching = touching
        self.record = record or Record(model)
        self.in_hand: dict[Interaction, bool] = {}
        self.kept = {k.edge for side in sides for k in side.options.keeps}

    def run(self) -> SearchNode | NoPlan:
        """The node that a plan of few steps ends at, or why there is none."""
        held = tuple(e for side in self.sides for e in [e for e in side.touching if e in side.holds][:1])
        first = SearchNode(self.start, (), 0, unmet_conditions(self.goal.conditions, self.start, self.model), held)
        self.nearest.note(first.states, first.unmet, None)
        if not first.unmet and not self._forbidden([first])[0]:
            return first
        self.closed.add(self._key(first))
        for side in self.sides:
            if side.touching and first.held_by(side.robot) is None:  # a button under the hand: a step of its own
                first = self._let_go(side, first, side.touching[0])
                if not first.unmet and not self._forbidden([first])[0]:
                    return first
        found = self._from(first)
        if found is not None:
            return found
        failure = self.nearest.failure(self.expansions, exhausted=not self.dropped)
        return replace(failure, tree=failure_tree(self.nearest))

    def _from(self, first: SearchNode) -> SearchNode | None:
        """The node of a plan with few steps, layer by layer; None if none is found within the settings."""
        layer, reserve = [first], list[SearchNode]()
        while layer and self.expansions < self.settings.expansions:
            children = self._expand(layer)
            done = self._done(children)
            if done:
                return min(done, key=lambda n: (len(n.unmet), n.ticks, mark_of(n)))
            queue = sorted([*reserve, *children], key=lambda n: (len(n.unmet) + len(n.open), n.ticks, n.mark))
            kept = [n for n in queue if len(n.steps) < self.settings.steps]
            self.dropped |= len(kept) < len(queue)
            layer, reserve = kept[: self.settings.width], kept[self.settings.width :]
        self.dropped |= bool(layer)
        return None

    def _let_go(self, side: Side, node: SearchNode, edge: Interaction) -> SearchNode:
        """A state once a robot has let go of what it touches or keeps hold of."""
        states, _ = settle(side.model, stack([node.states]), side.parked)
        free = {n: v[0] for n, v in states.items()}
        step = PlanStep((edge,), predicted=free, ticks=PLANNING.retake // 2)
        unmet, held = unmet_conditions(self.surer, free, self.model), tuple(e for e in node.held if e != edge)
        ticks, cost = node.ticks + step.ticks, node.cost + step_cost(step)
        return SearchNode(free, (*node.steps, step), ticks, unmet, held, cost=cost)

    def _key(self, node: SearchNode) -> tuple[object, ...]:
        return (*self.alike.key(node.states), node.unmet, node.held)

    def _done(self, nodes: Sequence[SearchNode]) -> list[SearchNode]:
        """The nodes in which the goal holds."""
        return [
            n
            for n, bad in zip(nodes, self._forbidden(nodes), strict=True)
            if not bad and not unmet_conditions(self.goal.conditions, n.states, self.model)
        ]

    def _forbidden(self, nodes: Sequence[SearchNode]) -> list[bool]:
        """Whether an interaction is active that must not be, or not active that must be, or one is only kept so."""
        goal = self.goal
        if not (goal.inactive or goal.active) or not nodes:
            return [not self.kept.isdisjoint(n.held) for n in nodes]
        batch = stack([n.states for n in nodes])
        on = [self.model.decide(e, batch) >= 0 for e in goal.inactive]
        off = [self.model.decide(e, batch) < 0 for e in goal.active]
        kept = np.array([any(e in self.kept and e not in goal.active for e in n.held) for n in nodes])
        return [bool(x) for x in np.any([*on, *off, kept], axis=0)]

    def _expand(self, layer: Sequence[SearchNode]) -> list[SearchNode]:
        kept: dict[tuple[object, ...], SearchNode] = {}
        for node in self._children(layer):
            key = self._key(node)
            if key in self.closed:
                continue
            if key not in kept or cheaper(node, kept[key]):
                kept[key] = node
        self.closed |= set(kept)
        return sorted((replace(n, mark=mark_of(n)) for n in kept.values()), key=lambda n: (n.ticks, n.mark))

    def _children(self, layer: Sequence[SearchNode]) -> list[SearchNode]:
        """Where the options lead from some nodes, all simulated at once."""
        self.expansions += len(layer)
        out: list[SearchNode] = []
        for side in self.sides:
            out += self._carried(side, layer) + self._driven(side, layer)
            if len(self.sides) > 1:
                out += self._keeping(side, layer) + self._letting_go(side, layer)
        return out

    def _keeping(self, side: Side, layer: Sequence[SearchNode]) -> list[SearchNode]:
        """A robot takes what it can keep hold of for the others."""
        moves = [
            (n, k)
            for k in side.options.keeps
            for n in layer
            if n.held_by(side.robot) is None and not n.is_taken(k.edge.child, side.robot)
        ]
        if not moves:
            return []
        batch = stack([n.states for n, _ in moves])
        batch[side.robot] = np.array([k.robot for _, k in moves])
        for r, (_, k) in enumerate(moves):
            batch[k.edge.child][r] = k.child
        after, status = settle(side.model, batch, batch[side.robot])
        self.rollouts += len(moves)
        out, limit = [], np.maximum(side.model.step_limit[side.robot], 1e-9)
        for r, (node, k) in enumerate(moves):
            if not status[k.edge][r]:
                continue
            states = row(after, r)
            likely = float(side.model.probability(k.edge, states))
            ticks = PLANNING.retake + int(np.ceil(np.max(np.abs(k.robot - side.parked) / limit)))
            step = PlanStep((k.edge,), hold=k.robot, release=False, predicted=states, ticks=ticks, probability=likely)
            out += self._child(node, step, states, (*node.held, k.edge))
        return out

    def _letting_go(self, side: Side, layer: Sequence[SearchNode]) -> list[SearchNode]:
        """A robot lets go of what it kept hold of for the others."""
        holding = [(n, n.held_by(side.robot)) for n in layer]
        return [self._let_go(side, n, e) for n, e in holding if e is not None and e in self.kept]

    def _carried(self, side: Side, layer: Sequence[SearchNode]) -> list[SearchNode]:
        model, root = side.model, side.robot
        moves: list[tuple[SearchNode, CarryOption, FloatArray, FloatArray | None]] = []
        for carry in side.options.movable({c.object for c in self.goal.conditions}):
            nodes = [n for n in layer if n.held_by(root) in (None, carry.edge)]
            nodes = [n for n in nodes if not n.is_taken(carry.edge.child, root)]
            free = can_hold(model, carry.edge, [n.states for n in nodes])
            nodes = [n for n, ok in zip(nodes, free, strict=True) if ok or n.held_by(root) is not None]
            before, enabling = [n.states for n in nodes], side.options.enabling[carry.edge]
            doubted = [self.record.doubted(s) for s in before]
            targets = carry_targets(model, carry, before, self.start, self.surer, enabling, doubted)
            moves += [(n, carry, t, None) for n, places in zip(nodes, targets, strict=True) for t in places]
            here = [(n, n.states[carry.edge.child][carry.follow]) for n in nodes if n.held_by(root) is not None]
            moves += [(n, carry, place, None) for n, place in here if stays(model, carry, place)]  # let go of
            if self._ends_in_hand(side, carry):
                ends = [(n, in_hand(model, carry, n.states, self.surer)) for n in nodes]
                moves += [(n, carry, *end) for n, end in ends if end is not None]
        if not moves:
            return []
        batch = stack([n.states for n, _, _, _ in moves])
        batch[root] = np.repeat(side.parked[None], len(moves), axis=0)
        for k, (_, carry, place, robot) in enumerate(moves):
            batch[carry.edge.child][k, carry.follow] = place
            batch[root][k] = side.parked if robot is None else robot
        held = np.ones(len(moves))  # there too, before it is let go
        for carry in side.options.carries:
            mine = [k for k, (_, c, _, _) in enumerate(moves) if c is carry]
            held[mine] = hold_probability(model, carry.edge, [row(batch, k) for k in mine])
        kept = np.flatnonzero(held >= PLANNING.likely)
        moves, batch, held = [moves[k] for k in kept], take(batch, kept), held[kept]
        if not moves:
            return []
        after, _ = settle(model, batch, batch[root])
        self.rollouts += len(moves)
        out = []
        for k, (node, carry, place, robot) in enumerate(moves):
            states = {n: v[k] for n, v in after.items()}
            wanted = self._pose(carry, place)
            ticks = PLANNING.retake + self._way(carry, node.states[carry.edge.child][carry.follow], place)
            likely = float(held[k])
            step = PlanStep((carry.edge,), wanted, after=wanted, predicted=states, ticks=ticks, probability=likely)
            others = tuple(e for e in node.held if e.parent != root)
            if robot is None:
                out += self._child(node, step, states, others)
            else:
                out += self._child(node, replace(step, release=False), states, (*others, carry.edge))
        return out

    def _ends_in_hand(self, side: Side, carry: CarryOption) -> bool:
        """Whether the goal wants an object held, or where it would not stay if let go of; asked once a search."""
        if carry.edge not in self.in_hand:
            place = wanted_place(side.model, carry, self.start, self.surer)
            falls = place is not None and not stays(side.model, carry, place)
            self.in_hand[carry.edge] = falls or carry.edge in self.goal.active
        return self.in_hand[carry.edge]

    def _driven(self, side: Side, layer: Sequence[SearchNode]) -> list[SearchNode]:
        free = [n for n in layer if n.held_by(side.robot) is None]
        states = [n.states for n in free]
        taken = {c.edge: hold_probability(side.model, c.edge, states) for c in side.options.carries}
        placed = []
        for k, node in enumerate(free):
            for drive in side.options.drives:
                if node.is_taken(drive.chain[0].child, side.robot):
                    continue
                edge = None if drive.carry is None else drive.carry.edge
                if edge is None or taken[edge][k] >= PLANNING.likely:
                    placed.append((node, drive.placed(side.frames, node.states)))
                else:  # the robot can't take it where it is
                    margin = hold_margin(side.model, edge, node.states)
                    self.nearest.note_tried(drive, np.nan, float(taken[edge][k]), edge)
                    self.nearest.note_blocked(drive, edge, margin)
        rows = [(n, d) for n, d in placed if d is not None]
        self.dropped |= len(rows) < len(placed)  # between what was shown there may be one that is within reach
        started = [(n.states, d) for n, d in rows]
        results = simulate(side.model, started, side.parked, self.surer, side.options.borders)
        self.rollouts += len(rows)
        out = []
        for (node, drive), outcomes in zip(rows, results, strict=True):
            for outcome in outcomes:
                self.nearest.note_tried(drive, outcome.end, outcome.probability, outcome.lost)
                if outcome.lost is not None:
                    self.nearest.note_blocked(drive, outcome.lost, outcome.margin)
                elif drive.direction * (outcome.end - node.states[drive.chain[-1].child][drive.variable]) > 0.0:
                    step = replace(self._step(node, drive, outcome), probability=outcome.probability)
                    out += self._child(node, step, outcome.states, node.held)
        return out

    def _step(self, node: SearchNode, drive: DriveOption, outcome: Outcome) -> PlanStep:
        target = drive.chain[-1].child
        name = self.model.graph.objects[target].observable.names[drive.variable]
        until = (target, name, drive.direction, outcome.end)
        if drive.motion is not None:
            return self._moving(node, drive, outcome, until)
        wanted, before, after, ticks = {}, {}, {}, PLANNING.retake + outcome.ticks
        if drive.carry is not None:
            obj, part = drive.carry.edge.child, drive.carry.follow
            back = node.states[obj][part]
            wanted, before = (
                self._pose(drive.carry, drive.hold[obj][part]),
                self._pose(drive.carry, drive.before[obj][part]),
            )
            after = self._pose(drive.carry, back)
            ticks += 2 * self._way(drive.carry, back, drive.before[obj][part])
        wanted = wanted | {(target, name): outcome.end}
        hold = drive.hold[drive.chain[0].parent]
        return PlanStep(drive.chain, wanted, until, hold, before, after, predicted=outcome.states, ticks=ticks)

    def _moving(
        self, node: SearchNode, drive: DriveOption, outcome: Outcome, until: tuple[str, str, int, float]
    ) -> PlanStep:
        """A step by motion; where it ends at a condition, what that is about is watched, however far down the chain."""
        graph, chain = self.model.graph, drive.chain
        if outcome.met is not None:
            c = self.surer[outcome.met]
            end = float(value_of(c, outcome.states, graph))
            sign = 1 if end >= float(value_of(c, node.states, graph)) else -1
            for more in nx.all_simple_paths(graph.digraph, chain[-1].child, c.object):
                chain = (*chain, *(Interaction(a, b) for a, b in zip(more[:-1], more[1:], strict=True)))
                until = (c.object, c.variable, sign, end)
                break
        ticks = PLANNING.retake + outcome.ticks
        wanted = {until[:2]: until[3]}
        return PlanStep(chain, wanted, until, predicted=outcome.states, ticks=ticks, motion=drive.motion)

    def _child(
        self, node: SearchNode, step: PlanStep, states: Batch, held: tuple[Interaction, ...]
    ) -> list[SearchNode]:
        """The node that a step leads to, with what is held there, if it is not known to fail."""
        failures = self.record.failures(step, node.states)
        if failures is None:
            self.barred = self.dropped = True  # that it failed is no proof that it can't work
            return []
        if failures:
            step = replace(step, variant=failures, ticks=expected_ticks(step.ticks, failures))
        unmet = unmet_conditions(self.surer, states, self.model)
        steps, ticks, cost = (*node.steps, step), node.ticks + step.ticks, node.cost + step_cost(step)
        child = SearchNode(states, steps, ticks, unmet, held, open=self.landmarks.open(states, unmet), cost=cost)
        self.nearest.note(child.states, child.unmet, step.chain[-1])
        return [child]

    def _pose(self, carry: CarryOption, values: FloatArray) -> dict[tuple[str, str], float]:
        obj = carry.edge.child
        names = self.model.graph.objects[obj].observable.names
        return {(obj, names[i]): float(x) for i, x in zip(carry.follow, values, strict=True)}

    def _way(self, carry: CarryOption, start: FloatArray, end: FloatArray) -> int:
        limit = np.maximum(self.model.step_limit[carry.edge.child][carry.follow], 1e-9)
        return int(np.ceil(np.max(np.abs(end - start) / limit)))
