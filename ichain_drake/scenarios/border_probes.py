"""States around the borders of a scenario's interactions, for the evaluation of classifiers alone.

A held-out state in which an interaction acts is moved to a place drawn from its region blown up by half, together with
whatever holds or is held; the world's own rules then say whether it still acts. What the demonstrations' sweeps show is
not used, and nothing of this reaches learning or control.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from ichain_drake.demonstrations import Demonstration
from ichain_drake.graph import Interaction
from ichain_drake.objects import WorldObject
from ichain_drake.scenarios.appliance import Appliance
from ichain_drake.scenarios.probes import Probes
from ichain_drake.state import FloatArray

NEAR = 1.5
"""How far a near miss may lie from a region's middle, in half-widths."""

_TRIES = 400  # a probe wanted
_PURPOSE = 3

State = dict[str, FloatArray]
Move = Callable[[State, np.random.Generator], bool]
"""Moves what a state holds, in place; False if that can't be there."""


class BorderProbes(ABC):
    """Makes the probes of one scenario; a subclass says what is moved, and where to.

    Args:
        scenario: an appliance; its world's rules are the truth.
    """

    def __init__(self, scenario: Appliance[Any]) -> None:
        self.scenario, self.graph, self.camera = scenario, scenario.graph, scenario.camera()
        # The rules are those of `ideal`; `arm` has the same, and in `contact` only some edges are asked about.
        world = scenario.build_world(scenario.start(0), 0, "ideal")
        self.objects: dict[str, WorldObject] = {n: world.system(n) for n in self.graph.objects if n != self.graph.root}
        hand = scenario.config.robot.hand
        self.hand = self.graph.root
        self.hand_place = [int(i) for i in self.graph.objects[self.hand].observable.role_indices("position")]
        self._hand_noise = np.array([hand.noise_std.get(n, 0.0) for n in hand.space.names])

    @abstractmethod
    def borders(self, edge: Interaction) -> Mapping[str, Move]:
        """What moves a state across each border of an interaction, by the object that is moved.

        Empty where there is no border that could be missed narrowly.
        """

    @abstractmethod
    def reread(self, system: WorldObject, value: FloatArray, full: FloatArray, rng: np.random.Generator) -> None:
        """Let an object's sensors read what was moved anew, in place.

        Args:
            system: the object.
            value: its observable state, shape (n_observable,).
            full: its full state, shape (n_variables,).
            rng: draws the sensors' noise.
        """

    def make(self, edge: Interaction, pieces: Sequence[Demonstration], count: int) -> Probes | None:
        """See `HasProbes.probes`; as many for each border."""
        bases = self._bases(edge, pieces)
        rng = np.random.default_rng([self.scenario.seed, _PURPOSE, self.graph.interactions.index(edge)])
        true: list[State] = []
        active: list[bool] = []
        border: list[str] = []
        borders = self.borders(edge)
        if len(borders) > 1:  # what is beyond one of them is to be within the others
            bases = [b for b in bases if self._truth(edge, b)]
        for name, move in borders.items():
            inside, outside = self._around(edge, move, bases, count, rng)
            if outside:
                true += [*inside, *outside]
                active += [True] * len(inside) + [False] * len(outside)
                border += [name] * (len(inside) + len(outside))
        if not true:
            return None
        read = [self._read(edge, state, rng) for state in true]
        gate = np.array([self._truth(edge, state) for state in read])
        names = (edge.child, *self.graph.parents(edge.child))
        stacked = [{n: np.array([s[n] for s in states]) for n in names} for states in (true, read)]
        return Probes(stacked[0], stacked[1], np.array(active), gate, tuple(border))

    def _around(
        self, edge: Interaction, move: Move, bases: Sequence[State], count: int, rng: np.random.Generator
    ) -> tuple[list[State], list[State]]:
        """States inside and outside, `count` of each, or fewer where there are hardly any."""
        found: dict[bool, list[State]] = {True: [], False: []}
        for _ in range(_TRIES * count if bases else 0):
            if min(len(v) for v in found.values()) >= count:
                break
            state = {n: v.copy() for n, v in bases[int(rng.integers(len(bases)))].items()}
            if move(state, rng):
                on = self._truth(edge, state)
                if len(found[on]) < count:
                    found[on].append(state)
        return found[True], found[False]

    def full(self, state: State) -> State:
        """Full states, shape (n_variables,) each; what is hidden is 0."""
        out = {}
        for name, value in state.items():
            system = self.objects.get(name)
            space = self.graph.objects[name] if system is None else system.state_space
            out[name] = np.zeros(len(space))
            out[name][space.observable_indices] = value
        return out

    def _bases(self, edge: Interaction, pieces: Sequence[Demonstration]) -> list[State]:
        """Measured states of held-out rows in which the interaction acts."""
        out: list[State] = []
        for piece in pieces:
            rows = np.flatnonzero(piece.table[edge.name].to_numpy(dtype=float) > 0.5)  # noqa: PLR2004 - a flag
            states = {n: piece.states(n, s) for n, s in self.graph.objects.items()}
            out += [{n: s[r] for n, s in states.items()} for r in rows]
        return out

    def _truth(self, edge: Interaction, state: State) -> bool:
        """Whether the interaction begins in a state, by the world's own rules."""
        full, child = self.full(state), self.objects[edge.child]
        parents = self.graph.parents(edge.child)
        return bool(child.decide_active(full[edge.child], full, dict.fromkeys(parents, False), None)[edge.parent])

    def _read(self, edge: Interaction, state: State, rng: np.random.Generator) -> State:
        """What sensors give of what was moved; the rest was read in a piece already."""
        out = {n: v.copy() for n, v in state.items()}
        full = self.full(state)
        for name in (edge.child, *self.graph.parents(edge.child)):
            if name == self.hand:
                place, scale = self.hand_place, self.scenario.config.noise.scale
                out[name][place] += scale * self._hand_noise[place] * rng.standard_normal(3)
            else:
                self.reread(self.objects[name], out[name], full[name], rng)
        return out


def drawn(
    middle: Sequence[float] | FloatArray, half: Sequence[float], rng: np.random.Generator, *, round: bool = False
) -> FloatArray:
    """A point of a region blown up to `NEAR` half-widths, shape (n,): a box, or round in its first two axes."""
    while True:
        share = rng.uniform(-1.0, 1.0, len(half))
        if not round or np.hypot(share[0], share[1]) <= 1.0:
            return np.asarray(middle) + NEAR * np.asarray(half) * share
