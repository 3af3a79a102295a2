"""How near a search came to each condition, and what to say where there is no plan."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ichain_drake.control.planning.drive_option import DriveOption
from ichain_drake.control.planning.goals import gap, kept_by_itself, value_of, words
from ichain_drake.control.planning.model import span
from ichain_drake.control.planning.plan import Condition, Goal, NoPlan, States
from ichain_drake.graph import Interaction
from ichain_drake.learning.model import InteractionModel


@dataclass(frozen=True)
class Tried:
    """What a search found of a drive.

    Attributes:
        times: that it was simulated.
        probability: that its chain becomes active, at best.
        end: the furthest value that it drove its variable to; None where it never began.
        lost: the interaction that was inactive in the likeliest try; None where none was.
    """

    times: int
    probability: float
    end: float | None
    lost: Interaction | None


class Nearest:
    """Keeps the nearest value that was predicted for each condition.

    Args:
        model: the learned graph.
        goal: what is wanted.
        start: states at the start, shape (n_variables,) each.
    """

    def __init__(self, model: InteractionModel, goal: Goal, start: States) -> None:
        self.model, self.goal = model, goal
        self.closest = [math.inf] * len(goal.conditions)
        self.nearest = [float(value_of(c, start, model.graph)) for c in goal.conditions]
        self.blame: list[Interaction | None] = [None] * len(goal.conditions)
        self.best: tuple[States, tuple[int, ...]] = (start, tuple(range(len(goal.conditions))))
        self.tried: dict[tuple[tuple[Interaction, ...], int, int], Tried] = {}
        self.blocked: dict[tuple[str, int, int], tuple[int, float, Interaction]] = {}

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

    def note_tried(self, drive: DriveOption, end: float, probability: float, lost: Interaction | None) -> None:
        """Take any try of a drive into account; kept is the likeliest, and the furthest that it came.

        Args:
            drive: that was simulated.
            end: value of its variable where it stopped.
            probability: that its chain becomes active.
            lost: the interaction that was inactive, if it could not begin.
        """
        key = (drive.chain, drive.variable, drive.direction)
        new = Tried(1, probability, None if lost is not None else end, lost)
        old = self.tried.get(key)
        if old is not None:
            ends = [x for x in (old.end, new.end) if x is not None]
            furthest = max(ends, key=lambda x: drive.direction * x) if ends else None
            likelier = new if new.probability > old.probability else old
            new = Tried(old.times + 1, likelier.probability, furthest, likelier.lost)
        self.tried[key] = new

    def note_blocked(self, drive: DriveOption, edge: Interaction, margin: float) -> None:
        """Take a drive into account that could not begin; kept is the one that came furthest along its chain.

        Args:
            drive: that could not begin.
            edge: the interaction that was inactive.
            margin: its decision value, below 0.
        """
        key = (drive.chain[-1].child, drive.variable, drive.direction)
        found = (drive.chain.index(edge), margin, edge)
        self.blocked[key] = max(self.blocked.get(key, found), found, key=lambda f: f[:2])

    def failure(self, expansions: int, *, exhausted: bool) -> NoPlan:
        """The condition that was never met, or that is missing where most of the others hold.

        Args:
            expansions: how many states were expanded, for the reason.
            exhausted: whether nothing that can be done was left out: else it was not found, and may yet be possible.
        """
        graph, conditions = self.model.graph, self.goal.conditions
        width = [
            float(span(self.model, c.object)[graph.objects[c.object].observable.index(c.variable)]) for c in conditions
        ]
        never = [k for k in range(len(conditions)) if self.closest[k] > 0]
        effort = f"in all {expansions} states that can be reached" if exhausted else f"within {expansions} states"
        verdict, may = ("can't be met", "can't") if exhausted else ("was not found to be met", "was not found to")
        if never:
            k = max(never, key=lambda k: self.closest[k] / width[k])
            c, edge = conditions[k], self._edge_of(k)
            index = graph.objects[c.object].observable.index(c.variable)
            tail = "" if kept_by_itself(self.model, c) else "; it does not keep its value once it is let go"
            direction = 1 if self.nearest[k] < c.lower else -1
            blocked = self.blocked.get((c.object, index, direction))
            if blocked is not None and self.blame[k] is None and not self._began(c.object, index, direction):
                edge = blocked[2]
                tail = f"; {edge.name} never became active on the way, its nearest decision value is {blocked[1]:.2g}"
            blame = self.blame[k]
            by = "as it is" if blame is None else f"by {blame.name}"
            return NoPlan(
                c,
                self.nearest[k],
                edge,
                f"{words(c, graph)} {verdict}: {self.nearest[k]:.4g} is the nearest that was predicted, {by}, "
                f"{effort}{tail}",
            )
        states, unmet = self.best
        edges = (*self.goal.inactive, *self.goal.active)
        if not edges and (not unmet or len(conditions) == 1):  # it was met, and is not over
            c = conditions[0]
            value, text = (
                float(value_of(c, states, graph)),
                f"{words(c, graph)} holds only while something is kept hold of",
            )
            return NoPlan(c, value, None, f"{text}, {effort}")
        if not conditions or not unmet:
            wanted, edge = "inactive" if self.goal.inactive else "active", edges[0]
            c = (
                conditions[0]
                if conditions
                else Condition(edge.child, graph.objects[edge.child].names[0], -math.inf, math.inf)
            )
            value = float(value_of(c, states, graph))
            return NoPlan(
                c,
                value,
                edge,
                f"{edge.name} {may} be made {wanted} together with the rest, {effort}",
            )
        k = max(unmet, key=lambda k: float(gap(conditions[k], value_of(conditions[k], states, graph))))
        c, value = conditions[k], float(value_of(conditions[k], states, graph))
        return NoPlan(
            c,
            self.nearest[k],
            self._edge_of(k),
            f"{words(c, graph)} {verdict} together with the other conditions: it is {value:.4g} where most of them "
            f"hold, {effort}",
        )

    def _began(self, obj: str, variable: int, direction: int) -> bool:
        """Whether any drive of a variable could begin."""
        ends = (t.end for key, t in self.tried.items() if (key[0][-1].child, *key[1:]) == (obj, variable, direction))
        return any(end is not None for end in ends)

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
