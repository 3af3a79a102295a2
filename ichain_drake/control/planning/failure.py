"""How near a search came to each condition, and what to say where there is no plan."""

from __future__ import annotations

import math

from ichain_drake.control.planning.goals import gap, kept_by_itself, value_of, words
from ichain_drake.control.planning.model import GraphModel, span
from ichain_drake.control.planning.plan import Condition, Goal, NoPlan, States
from ichain_drake.graph import Interaction


class Nearest:
    """Keeps the nearest value that was predicted for each condition.

    Args:
        model: the learned graph.
        goal: what is wanted.
        start: states at the start, shape (n_variables,) each.
    """

    def __init__(self, model: GraphModel, goal: Goal, start: States) -> None:
        self.model, self.goal = model, goal
        self.closest = [math.inf] * len(goal.conditions)
        self.nearest = [float(value_of(c, start, model.graph)) for c in goal.conditions]
        self.blame: list[Interaction | None] = [None] * len(goal.conditions)
        self.best: tuple[States, tuple[int, ...]] = (start, tuple(range(len(goal.conditions))))

    def note(self, states: States, unmet: tuple[int, ...], edge: Interaction | None) -> None:
        """Take a predicted state into account.

        Args:
            states: shape (n_variables,) each.
            unmet: indices of the conditions that it does not meet by a margin.
            edge: the interaction that led to it.
        """
        for k, c in enumerate(self.goal.conditions):
            value = float(value_of(c, states, self.model.graph))
            away = float(gap(c, value))
            if away < self.closest[k] - 1e-9:
                self.closest[k], self.nearest[k] = away, value
                self.blame[k] = edge if edge is not None and edge.child == c.object else self.blame[k]
        if len(unmet) < len(self.best[1]):
            self.best = (states, unmet)

    def failure(self, expansions: int) -> NoPlan:
        """The condition that was never met, or that is missing where most of the others hold.

        Args:
            expansions: how many states were expanded, for the reason.
        """
        graph, conditions = self.model.graph, self.goal.conditions
        width = [
            float(span(self.model, c.object)[graph.objects[c.object].observable.index(c.variable)]) for c in conditions
        ]
        never = [k for k in range(len(conditions)) if self.closest[k] > 0]
        effort = f"after {expansions} states were expanded"
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
        states, unmet = self.best
        if not conditions or not unmet:
            wanted = "inactive" if self.goal.inactive else "active"
            edge = (*self.goal.inactive, *self.goal.active)[0]
            c = (
                conditions[0]
                if conditions
                else Condition(edge.child, graph.objects[edge.child].names[0], -math.inf, math.inf)
            )
            value = float(value_of(c, states, graph))
            return NoPlan(c, value, edge, f"{edge.name} can't be made {wanted} together with the rest, {effort}")
        k = max(unmet, key=lambda k: float(gap(conditions[k], value_of(conditions[k], states, graph))))
        c, value = conditions[k], float(value_of(conditions[k], states, graph))
        return NoPlan(
            c,
            self.nearest[k],
            self._edge_of(k),
            f"{words(c, graph)} can't be met together with the other conditions: it is {value:.4g} where most of them "
            f"hold, {effort}",
        )

    def _edge_of(self, k: int) -> Interaction | None:
        """The interaction that came nearest, or the first that changes the variable."""
        c = self.goal.conditions[k]
        index = self.model.graph.objects[c.object].observable.index(c.variable)
        acting = [
            e
            for e in self.model.graph.incoming(c.object)
            if any(f.variable == index for f in self.model.edges[e].effects)
        ]
        return self.blame[k] or (acting[0] if acting else None)
