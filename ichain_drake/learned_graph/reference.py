"""The learned graph in plain numpy: all learned objects advanced by one tick, in batches or row by row."""

from __future__ import annotations

import heapq
from collections.abc import Mapping, Sequence

import networkx as nx
import numpy as np

from ichain_drake.errors import ActiveCycleError
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning.chain.models import ForwardModel
from ichain_drake.state import FloatArray, StateSpace


def sweep_order(members: Sequence[str], active: Sequence[Interaction], time: float | None = None) -> list[str]:
    """An order in which every member comes after its active parents among the members.

    Args:
        members: objects, in declared order.
        active: the active interactions; those from outside are ignored.
        time: named in the error [s].

    Raises:
        ActiveCycleError: if the active interactions among the members form a cycle.
    """
    place = {name: k for k, name in enumerate(members)}
    inside = [e for e in active if e.parent in place and e.child in place]
    parents = dict.fromkeys(members, 0)
    children: dict[str, list[str]] = {name: [] for name in members}
    for e in inside:
        parents[e.child] += 1
        children[e.parent].append(e.child)
    ready, order = [k for name, k in place.items() if not parents[name]], []
    while ready:  # the first of those that are: ascending places are a heap
        name = members[heapq.heappop(ready)]
        order.append(name)
        for child in children[name]:
            parents[child] -= 1
            if not parents[child]:
                heapq.heappush(ready, place[child])
    if len(order) < len(place):
        done = set(order)
        stuck = [(e.parent, e.child) for e in inside if e.parent not in done and e.child not in done]
        edges = ", ".join(Interaction(*e).name for e in nx.find_cycle(nx.DiGraph(stuck)))
        when = "" if time is None else f" at t = {time:.3f} s"
        raise ActiveCycleError(f"active interactions form a cycle{when}: {edges}; deactivate one of them")
    return order


class LearnedGraphReference:
    """Advances learned objects: the passive state, plus the effect of every active interaction.

    An object without active interactions keeps its state. Each active one adds the change that its forward model
    predicts, given the parent's state at t and at t + 1.

    Args:
        graph: the interaction graph.
        models: forward model of every interaction.
    """

    def __init__(self, graph: InteractionGraph, models: Mapping[Interaction, ForwardModel]) -> None:
        self.graph = graph
        self.models = dict(models)

    def tick(
        self,
        states: Mapping[str, FloatArray],
        root_next: FloatArray,
        active: Mapping[Interaction, bool] | None = None,
        normal: Mapping[str, FloatArray] | None = None,
        scale: Mapping[Interaction, FloatArray] | None = None,
    ) -> dict[str, FloatArray]:
        """One tick for a batch.

        Args:
            states: observable state of every object and the robot, shape (n, n_variables) each.
            root_next: the robot's state at t + 1, shape (n, n_root).
            active: which interactions are active; default all.
            normal, scale: noise of the coded change: standard normals per object (n, n_variables), and standard
                deviation per interaction (n_variables,).

        Returns:
            The states at t + 1.
        """
        on = [e for e in self.graph.interactions if active is None or active[e]]
        after = {name: np.asarray(states[name]) for name in self.graph.roots} | {self.graph.root: np.asarray(root_next)}
        for name in sweep_order([n for n in self.graph.objects if n not in self.graph.roots], on):
            effects = []
            for edge in (e for e in self.graph.incoming(name) if active is None or active[e]):
                model, child = self.models[edge], states[name]
                parents = (states[edge.parent], after[edge.parent])
                if normal is not None and scale is not None:
                    value = model.sample(child, *parents, normal[name], scale[edge])
                else:
                    value = model.predict(child, *parents)
                effects.append(value)
            after[name] = combine(self.graph.objects[name].observable, states[name], effects)
        return after


def combine(space: StateSpace, state: FloatArray, effects: Sequence[FloatArray]) -> FloatArray:
    """The next state from the predictions of each active interaction: their changes add up.

    Args:
        space: the object's observable state space.
        state: the object's state at t, shape (..., n_variables).
        effects: its next state as each active interaction alone predicts it, same shape.

    Returns:
        Same shape; the state itself where nothing is active.
    """
    if not effects:
        return state
    if len(effects) == 1:
        return effects[0]
    total = state.copy()
    for value in effects:
        total = total + space.difference(value, state)
    return total
