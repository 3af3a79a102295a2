"""Parts of an interaction graph that are known before, beside which only the rest is learned."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TypeVar

import numpy as np

from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning.chain.chain import LearnedLink
from ichain_drake.learning.chain.command import LearnedCommand
from ichain_drake.learning.passive import PassiveDynamics
from ichain_drake.learning.settings import LEARNING
from ichain_drake.learning.status.events import EdgeExamples, Switching, Windows
from ichain_drake.learning.tick import LearnedInteraction
from ichain_drake.state import FloatArray

KeptT = TypeVar("KeptT")


@dataclass(frozen=True)
class KnownObject:
    """What is known about an object.

    Attributes:
        passive: its passive dynamics; None for the robot.
        low, high: range of its states in the demonstrations that it is known from, shape (n_variables,).
        step_limit: largest change in a tick there, shape (n_variables,).
        noise: standard deviation of a reading, shape (n_variables,).
        typical: one of its states there, shape (n_variables,).
    """

    passive: PassiveDynamics | None
    low: FloatArray
    high: FloatArray
    step_limit: FloatArray
    noise: FloatArray
    typical: FloatArray


@dataclass(frozen=True)
class KnownParts:
    """Interactions and objects of a graph that are known before anything is learned, from a library say.

    Attributes:
        edges: known interactions, under the names of the graph at hand.
        objects: at least the ends of these; the rest of the graph's objects are learned with the rest.
        elsewhere: those of the interactions that were shown in another scene. What they do holds here too; the places
            at which they were begun and ended are only used where no piece shows any here.
        activations, deactivations: demonstrated events of those that are the robot's.
        sources: where each was found: the saved graph's folder, and its name there where that is another.
        robot_seconds: what recording its demonstrations took of the robot then, with all others of its graph [s].
        reasons: why each of the other interactions was not taken.
        links: of a chain, by interaction name, for following paths.
        command: what was learned about commanding the hand, where the chain's first link is known.
    """

    edges: Mapping[Interaction, LearnedInteraction] = field(default_factory=dict)
    objects: Mapping[str, KnownObject] = field(default_factory=dict)
    elsewhere: tuple[Interaction, ...] = ()
    activations: Windows = field(default_factory=dict)
    deactivations: Windows = field(default_factory=dict)
    sources: Mapping[Interaction, str] = field(default_factory=dict)
    robot_seconds: Mapping[Interaction, float] = field(default_factory=dict)
    reasons: Mapping[Interaction, str] = field(default_factory=dict)
    links: Mapping[str, LearnedLink] = field(default_factory=dict)
    command: LearnedCommand | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the known interactions, which need no demonstration."""
        return (*(e.name for e in self.edges), *self.links)

    def without(self, reasons: Mapping[Interaction, str]) -> KnownParts:
        """The same, without some interactions, for these reasons; an object all of whose known ones go is forgotten."""
        kept = {e for e in self.edges if e not in reasons}
        gone = {e.child for e in reasons} - {e.child for e in kept}
        names = {e.name for e in reasons}
        first = next(iter(self.links), None)

        def only(found: Mapping[Interaction, KeptT]) -> dict[Interaction, KeptT]:
            return {e: value for e, value in found.items() if e in kept}

        return KnownParts(
            only(self.edges),
            {n: known for n, known in self.objects.items() if n not in gone},
            tuple(e for e in self.elsewhere if e in kept),
            only(self.activations),
            only(self.deactivations),
            only(self.sources),
            only(self.robot_seconds),
            {**self.reasons, **reasons},
            {n: link for n, link in self.links.items() if n not in names},
            None if first in names else self.command,
        )

    def is_whole(self, graph: InteractionGraph) -> bool:
        """Whether nothing of a graph is left to be learned."""
        passive = all(
            n in self.objects and self.objects[n].passive is not None for n in graph.objects if n not in graph.roots
        )
        robots = all(n in self.objects for n in graph.roots)
        return passive and robots and all(e in self.edges for e in graph.interactions)


def typical_row(states: FloatArray) -> FloatArray:
    """The state that is nearest to the medians of all variables, shape (n_variables,), of states (n, n_variables)."""
    spread = np.maximum(np.ptp(states, axis=0), 1e-12)
    return np.asarray(states[np.argmin((np.abs(states - np.median(states, axis=0)) / spread).sum(axis=1))])


def joined_examples(
    known: EdgeExamples, shown: EdgeExamples | None, typical: Mapping[str, FloatArray], *, elsewhere: bool
) -> EdgeExamples:
    """Examples of a known interaction together with those that the pieces at hand show of it.

    Args:
        known: from before.
        shown: from the pieces; None where there are none.
        typical: a state for each of the graph's objects, which stands in for one that wasn't there before.
        elsewhere: see `KnownParts`.
    """
    before = EdgeExamples(
        _filled_events(known.activations, typical),
        _filled_events(known.deactivations, typical),
        _filled(known.active, typical),
        _filled(known.inactive, typical),
    )
    if shown is None:
        return before
    return EdgeExamples(
        _joined_events(before.activations, shown.activations, elsewhere=elsewhere),
        _joined_events(before.deactivations, shown.deactivations, elsewhere=elsewhere),
        _joined(before.active, shown.active),
        _joined(before.inactive, shown.inactive),
    )


def _filled(states: Mapping[str, FloatArray], typical: Mapping[str, FloatArray]) -> dict[str, FloatArray]:
    rows = len(next(iter(states.values())))
    return {n: states[n] if n in states else np.tile(row, (rows, 1)) for n, row in typical.items()}


def _filled_events(events: Switching, typical: Mapping[str, FloatArray]) -> Switching:
    return replace(events, before=_filled(events.before, typical), after=_filled(events.after, typical))


def _joined(known: Mapping[str, FloatArray], shown: Mapping[str, FloatArray]) -> dict[str, FloatArray]:
    rows = {n: np.vstack([shown[n], known[n]]) for n in shown}
    count = len(next(iter(rows.values())))
    if count <= LEARNING.examples:
        return rows
    drawn = np.linspace(0, count - 1, LEARNING.examples).round().astype(int)
    return {n: values[drawn] for n, values in rows.items()}


def _joined_events(known: Switching, shown: Switching, *, elsewhere: bool) -> Switching:
    if elsewhere and len(shown):
        return shown
    return Switching(
        {n: np.vstack([shown.before[n], known.before[n]]) for n in shown.before},
        {n: np.vstack([shown.after[n], known.after[n]]) for n in shown.after},
        (*shown.pieces, *known.pieces),
        (*shown.rows, *known.rows),
    )
