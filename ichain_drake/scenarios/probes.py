"""States around the border of an interaction's region, with the truth, for the evaluation of classifiers alone."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from ichain_drake.demonstrations import Demonstration
from ichain_drake.graph import Interaction
from ichain_drake.state import BoolArray, FloatArray

States = Mapping[str, FloatArray]


@dataclass(frozen=True)
class Probes:
    """States around the border of where an interaction acts, as many inside as outside.

    A near miss is a state outside, but within 1.5 times the true region's half-width.

    Attributes:
        true: states of the child and its parents, observable part, without noise where a probe was moved.
        read: the same as sensors give them.
        active: the truth, shape (n,).
        gate: what the true region says of the readings, shape (n,): as well as they can be told.
        border: which border each probe is about, by the object that was moved, length n; empty if there is but one.
    """

    true: States
    read: States
    active: BoolArray
    gate: BoolArray
    border: tuple[str, ...] = ()


@runtime_checkable
class HasProbes(Protocol):
    """A scenario that knows the true regions of its interactions."""

    def probes(self, edge: Interaction, pieces: Sequence[Demonstration], count: int) -> Probes | None:
        """Probes of an interaction; None where its physics has no region that could be missed narrowly.

        Args:
            edge: the interaction.
            pieces: held-out pieces, whose states the probes are moved from.
            count: of probes inside, and of near misses.
        """
