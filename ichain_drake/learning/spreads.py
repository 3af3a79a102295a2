"""Predictive spreads of one tick, and what each is decided by."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from ichain_drake.graph import Interaction
from ichain_drake.learning.passive import PassiveDynamics
from ichain_drake.learning.tick import LearnedInteraction
from ichain_drake.state import FloatArray


def spread_of(
    passive: PassiveDynamics, active: Mapping[Interaction, LearnedInteraction], noise: FloatArray
) -> tuple[FloatArray, tuple[Interaction | None, ...]]:
    """Standard deviation of a one-tick prediction of an object from readings, against the next reading.

    Args:
        passive: its passive dynamics.
        active: the interactions that act on it.
        noise: standard deviation of a reading, shape (n_variables,).

    Returns:
        shape (n_variables,), and for each variable the interaction whose effect has the largest spread of all that
        act; None where its passive dynamics have.
    """
    variance = np.array([v.std**2 for v in passive.variables])
    source: list[Interaction | None] = [None] * len(variance)
    for edge, learned in active.items():
        for effect in learned.effects:
            theirs = effect.regression.std**2
            if theirs > variance[effect.variable]:
                variance[effect.variable], source[effect.variable] = theirs, edge
    for i, v in enumerate(passive.variables):
        if v.kind == "change":
            # Two readings of the amount are in its own residual, and none in that of the change: it has one of its own.
            unread = max(variance[v.amount] - 2.0 * noise[v.amount] ** 2, 0.0)
            variance[i], source[i] = unread + noise[i] ** 2, source[v.amount]
    return np.sqrt(variance), tuple(source)


def acted_on(
    passive: PassiveDynamics, edges: Iterable[Interaction], learned: Mapping[Interaction, LearnedInteraction]
) -> dict[Interaction, frozenset[int]]:
    """Indices of the variables that each interaction changes, changes of changed amounts included."""
    out = {}
    for edge in edges:
        own = {effect.variable for effect in learned[edge].effects}
        out[edge] = frozenset(
            i for i, v in enumerate(passive.variables) if (v.amount if v.kind == "change" else i) in own
        )
    return out
