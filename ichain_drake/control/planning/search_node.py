"""A predicted state of a search with the steps to it, and which of two is better."""

from __future__ import annotations

from dataclasses import dataclass

from ichain_drake.control.planning.model import Batch
from ichain_drake.control.planning.plan import PlanStep
from ichain_drake.control.settings import PLANNING
from ichain_drake.graph import Interaction

_DIGITS = 6


@dataclass(frozen=True, eq=False)
class SearchNode:
    """A predicted state and the steps to it.

    Attributes:
        states: predicted, shape (n_variables,) each.
        steps: that lead there.
        ticks: that they take.
        unmet: indices of unmet conditions.
        held: interactions by which robots hold objects, at most one of each robot.
        open: indices of unmet conditions whose landmarks are not met either.
        mark: breaks ties.
        cost: expected time of the steps [ticks]; see `risk`.
    """

    states: Batch
    steps: tuple[PlanStep, ...]
    ticks: int
    unmet: tuple[int, ...]
    held: tuple[Interaction, ...] = ()
    open: tuple[int, ...] = ()
    mark: tuple[float, ...] = ()
    cost: float = 0.0

    def held_by(self, robot: str) -> Interaction | None:
        """The interaction by which a robot holds something; None where it is free."""
        return next((e for e in self.held if e.parent == robot), None)

    def is_taken(self, obj: str, robot: str) -> bool:
        """Whether another robot holds an object."""
        return any(e.child == obj and e.parent != robot for e in self.held)


def mark_of(node: SearchNode) -> tuple[float, ...]:
    """Numbers of a node's steps that depend on no name and no order of objects or variables: they break ties."""
    out: list[float] = []
    for step in node.steps:
        out += [float(step.ticks), float(len(step.chain))]
        out += sorted(round(float(x), _DIGITS) for v in step.predicted.values() for x in v)
    return tuple(out)


def cheaper(one: SearchNode, other: SearchNode) -> bool:
    """Whether a way to the same state is shorter; of nearly equal ones, that which watches more interactions."""
    mine, theirs = len(one.steps[-1].chain), len(other.steps[-1].chain)
    if len(one.steps) == len(other.steps) and mine != theirs:
        more = PLANNING.cheaper
        return one.ticks <= more * other.ticks if mine > theirs else one.ticks * more < other.ticks
    return (one.ticks, mark_of(one)) < (other.ticks, mark_of(other))
