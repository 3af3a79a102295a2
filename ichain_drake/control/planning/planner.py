"""Planning over a learned interaction graph (paper sec. V, VI): stages by object, each searched on its own."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TypeVar

import networkx as nx
import numpy as np

from ichain_drake.control.planning.experience import Experience, Record
from ichain_drake.control.planning.goals import gap, impossible, value_of
from ichain_drake.control.planning.keeping import missing_hand
from ichain_drake.control.planning.model import span
from ichain_drake.control.planning.optimal import OptimalSearch
from ichain_drake.control.planning.plan import Condition, Goal, NoPlan, Plan, States
from ichain_drake.control.planning.repertoire import find_repertoire
from ichain_drake.control.planning.risk import plan_cost, success_probability
from ichain_drake.control.planning.search import Search
from ichain_drake.control.planning.search_node import SearchNode
from ichain_drake.control.planning.search_settings import SearchSettings
from ichain_drake.control.planning.side import Side
from ichain_drake.graph import Interaction
from ichain_drake.learning.model import InteractionModel
from ichain_drake.state import FloatArray

__all__ = ["PLANNERS", "GraphPlanner", "SearchSettings"]

PLANNERS = ("fast", "optimal")
"""Names of the planners that come with the library."""

_SearchT = TypeVar("_SearchT", bound=Search)


@dataclass
class _Effort:
    """What one plan takes into account, and what it cost."""

    record: Record
    stood: Mapping[str, Sequence[FloatArray]] = field(default_factory=dict)
    expansions: int = 0
    rollouts: int = 0
    barred: bool = False  # whether experience kept a search from something


class GraphPlanner:
    """Plans with one learned graph.

    Args:
        model: the learned graph.
        settings: how far to search.
    """

    def __init__(self, model: InteractionModel, settings: SearchSettings | None = None) -> None:
        self.model = model
        self.settings = settings or SearchSettings()
        self.options = find_repertoire(model)
        others = [model.acting(robot) for robot in model.graph.roots if robot != model.graph.root]
        self._views = {model.graph.root: (model, self.options)}
        self._views |= {view.graph.root: (view, find_repertoire(view)) for view in others}
        self._observed = model
        self._cautious: dict[tuple[Interaction, ...], GraphPlanner] = {}

    def plan(
        self,
        start: States,
        goal: Goal,
        experience: Experience | None = None,
    ) -> Plan | NoPlan:
        """Find a plan.

        Args:
            start: measured states, shape (n_variables,) each.
            goal: ranges wanted at the same time.
            experience: what this execution has shown so far; nothing without.

        Returns:
            A plan, empty if the goal is met, or why there is none.
        """
        began = time.perf_counter()
        experience = experience or Experience()
        shown = tuple(e for e in self.model.graph.interactions if e in experience.cautious and self.model.customary(e))
        if shown:
            careful = self._keeping_to(shown).plan(start, goal, replace(experience, cautious=()))
            if isinstance(careful, Plan):
                return replace(careful, cautious=shown, seconds=time.perf_counter() - began)
        known = {n: np.asarray(start[n], dtype=float) for n in self.model.graph.objects}
        refused = self._not_in_hand(goal) or impossible(goal, self.model, known)
        if refused is not None:
            return refused
        effort = _Effort(Record(self.model, experience.contradictions), experience.stood)
        found = self._in_stages(known, goal, effort)
        if isinstance(found, NoPlan) and effort.barred:  # where there was no way, there may be one by another reading
            effort.record, effort.barred = Record(self.model, experience.contradictions, final=False), False
            found = self._in_stages(known, goal, effort)
        proved = False
        if self.settings.optimal:
            found, proved = self._cheapest(known, goal, effort, found)
        if isinstance(found, NoPlan):
            why = missing_hand(self.model, found.condition)
            return replace(found, reason=f"{found.reason}; {why}") if why else found
        return Plan(
            found.steps,
            found.ticks,
            effort.expansions,
            effort.rollouts,
            time.perf_counter() - began,
            probability=success_probability(self.model, goal, found.steps),
            cost=plan_cost(self.model, goal, found.steps),
            optimal=proved,
        )

    def _not_in_hand(self, goal: Goal) -> NoPlan | None:
        """Refuse a goal in which the robot touches something that it can't hold, or holds two things."""
        mine = [e for e in goal.active if self.model.graph.by_robot(e)]
        holds = {e for _, options in self._views.values() for e in options.holds}
        for k, edge in enumerate(mine):
            several = any(e.parent == edge.parent for e in mine[:k])
            if several or edge not in holds:
                one = "it holds one object at a time"
                why = one if several else f"it can't carry {edge.child}; ask for what it is to do"
                condition = Condition(edge.child, self.options.names[edge.child][0], -math.inf, math.inf)
                text = f"{edge.name}: {edge.parent} ends away from everything but what it holds, and {why}"
                return NoPlan(condition, math.nan, edge, text)
        return None

    def _keeping_to(self, shown: tuple[Interaction, ...]) -> GraphPlanner:
        """A planner with the customary conditions of some interactions; what is active now is seen without them."""
        if shown not in self._cautious:
            careful = GraphPlanner(self.model.cautious(shown), self.settings)
            careful._observed = self.model
            self._cautious[shown] = careful
        return self._cautious[shown]

    def _in_stages(self, start: Mapping[str, FloatArray], goal: Goal, effort: _Effort) -> SearchNode | NoPlan:
        """One object's conditions after the other, nearest first, without spoiling what holds; else all at once."""
        first = SearchNode({n: v.copy() for n, v in start.items()}, (), 0, ())
        node, waiting = first, self._open_objects(start, goal)
        every = set(self.model.graph.objects)
        whole = len(waiting) > 1  # whether a refusal needs a search over all there is
        while waiting:
            failed: NoPlan | None = None
            for obj in waiting:
                stage = _stage(goal, obj, node.states, self.model)
                found = self._search(node.states, stage, self._relevant(obj), effort)
                if isinstance(found, SearchNode):
                    node = SearchNode(found.states, (*node.steps, *found.steps), node.ticks + found.ticks, found.unmet)
                    failed = None
                    break
                failed = failed or found
                if effort.barred or self._relevant(obj) != every:
                    whole = True  # what the object itself acts on may be what takes from it
                elif found.condition.object == obj and node is first and not _touches(found):
                    return found  # nothing that there is ever brought it there
            if failed is not None:
                return self._search(start, goal, None, effort) if whole else failed
            waiting = self._open_objects(node.states, goal)
        if node is first:  # only interactions may be left to deactivate
            return self._search(start, goal, None, effort)
        return node

    def _cheapest(
        self, start: Mapping[str, FloatArray], goal: Goal, effort: _Effort, found: SearchNode | NoPlan
    ) -> tuple[SearchNode | NoPlan, bool]:
        """The cheapest plan, below one that was found, and whether none is cheaper."""
        search = self._make_search(OptimalSearch, start, goal, None, effort)
        if isinstance(found, SearchNode):
            search.below = plan_cost(self.model, goal, found.steps)
        cheaper = self._run(search, effort)
        return (cheaper if isinstance(found, NoPlan) or isinstance(cheaper, SearchNode) else found), search.proved

    def _search(
        self, start: Mapping[str, FloatArray], goal: Goal, objects: frozenset[str] | None, effort: _Effort
    ) -> SearchNode | NoPlan:
        return self._run(self._make_search(Search, start, goal, objects, effort), effort)

    def _make_search(
        self,
        kind: type[_SearchT],
        start: Mapping[str, FloatArray],
        goal: Goal,
        objects: frozenset[str] | None,
        effort: _Effort,
    ) -> _SearchT:
        active, graph = self._observed.active(start), self.model.graph
        touching = tuple(e for e in graph.interactions if graph.by_robot(e) and bool(active[e]))
        if objects is not None:  # what is held has to be put down first, whatever it is
            held = {e for _, options in self._views.values() for e in options.holds}
            objects |= {e.child for e in held if e in touching}
        about = graph.objects if objects is None else objects
        sides = [
            Side(view, r.about(about, goal).having_stood(effort.stood), start, touching)
            for view, r in self._views.values()
        ]
        return kind(self.model, self.settings, sides, start, goal, objects, touching, effort.record)

    def _run(self, search: Search, effort: _Effort) -> SearchNode | NoPlan:
        found = search.run()
        effort.expansions += search.expansions
        effort.rollouts += search.rollouts
        effort.barred |= search.barred
        return found

    def _open_objects(self, states: States, goal: Goal) -> list[str]:
        """Objects with unmet conditions, those with the least to do first."""
        todo: dict[str, float] = {}
        for c in goal.conditions:
            away = float(gap(c, value_of(c, states, self.model.graph)))
            if away > 0:
                index = self.model.graph.objects[c.object].observable.index(c.variable)
                todo[c.object] = todo.get(c.object, 0.0) + away / float(span(self.model, c.object)[index])
        return sorted(todo, key=lambda n: todo[n])

    def _relevant(self, obj: str) -> frozenset[str]:
        """Objects whose states can act on an object, itself included."""
        return frozenset({obj, *nx.ancestors(self.model.graph.digraph, obj)})


def _touches(failure: NoPlan) -> bool:
    """Whether some predicted state met the condition that a search failed for."""
    return float(gap(failure.condition, failure.closest)) == 0


def _stage(goal: Goal, obj: str, states: States, model: InteractionModel) -> Goal:
    """The conditions on one object, and those on others that hold already."""
    mine = [c for c in goal.conditions if c.object == obj or gap(c, value_of(c, states, model.graph)) == 0]
    return replace(goal, conditions=tuple(mine))
