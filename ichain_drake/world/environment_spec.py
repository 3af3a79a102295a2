"""What has to be said about somebody else's environment before it is a world."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from ichain_drake.errors import InputError
from ichain_drake.graph import InteractionGraph
from ichain_drake.objects.gymnasium.snapshot import Snapshot
from ichain_drake.state import FloatArray, StateSpace, Variable

ENDED = ("reward", "terminated", "truncated")
"""Hidden variables of the root: reward of the last tick, and whether the environment's episode is over."""


@dataclass(frozen=True)
class RootTerm:
    """One number of the environment's action, from where the root is wanted and where it is.

    Attributes:
        variable: of the root.
        scale: action per unit of the variable.
        relative: whether it is the way from where the root is read to be; otherwise where it is wanted.
    """

    variable: str
    scale: float = 1.0
    relative: bool = True


@dataclass(frozen=True)
class EnvironmentSpec:
    """An environment with objects, and how its state, time and actions are to be understood.

    Attributes:
        make: makes the environment, a `gymnasium.Env` without a time limit of its own.
        objects: state space of each object, by name; the one that nothing acts on is the root, and what is commanded.
        interactions: between them, as `parent->child`.
        actions: one term for each number of an action, clipped to the action space. They are worked out anew in every
            step, from what is read then.
        read: (unwrapped environment) -> values of the variables of every object.
        active: (unwrapped environment) -> whether each interaction, by name, is in effect; for labels and scoring.
        snapshot: how to read the whole state and put it back; by default looked for in the environment.
        steps_per_tick: steps of the environment in a tick (1/3 s).
        reset_options: passed to `reset`.
        stochastic: whether it draws random numbers while it steps; its generator is then seeded in every tick by that
            tick's noise of the world.
        noise_std: standard deviation of readings, by `object.variable`, in its unit; 0 where not named.
    """

    make: Callable[[], Any]
    objects: Mapping[str, StateSpace]
    interactions: Sequence[str]
    actions: tuple[RootTerm, ...]
    read: Callable[[Any], Mapping[str, FloatArray]]
    active: Callable[[Any], Mapping[str, bool]]
    snapshot: Snapshot | None = None
    steps_per_tick: int = 1
    reset_options: Mapping[str, Any] | None = None
    stochastic: bool = False
    noise_std: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.steps_per_tick < 1:
            raise InputError(f"steps_per_tick is {self.steps_per_tick}; give a whole number from 1")
        root = self.objects[self.declared.root]
        for term in self.actions:
            root.index(term.variable)
        for name, std in self.noise_std.items():
            obj, _, variable = name.partition(".")
            if obj not in self.objects or variable not in self.objects[obj].names or not 0 <= std < np.inf:
                raise InputError(f"noise_std of {name!r}: name object.variable, and give a number from 0")

    @cached_property
    def declared(self) -> InteractionGraph:
        """The graph as it was declared."""
        return InteractionGraph(self.objects, list(self.interactions))

    @cached_property
    def graph(self) -> InteractionGraph:
        """The graph with what the world hides: of the root how the episode goes, of the others what acts on them."""
        spaces = {}
        for name, space in self.declared.objects.items():
            if name == self.declared.root:
                kinds = {"reward": "real", "terminated": "binary", "truncated": "binary"}
                more = [Variable(n, kind=kinds[n], hidden=True) for n in ENDED]  # type: ignore[arg-type]
                spaces[name] = StateSpace(space.type, (*space.variables, *more))
                continue
            flags = [
                Variable(f"active_{p}", kind="binary", hidden=True, measured_in="plant")
                for p in self.declared.parents(name)
            ]
            own = [replace(v, measured_in="plant") for v in space.variables]
            spaces[name] = StateSpace(space.type, (*own, *flags))
        return InteractionGraph(spaces, list(self.interactions))

    def action(self, wanted: FloatArray, now: FloatArray) -> FloatArray:
        """The environment's action, not yet clipped, shape (n_actions,).

        Args:
            wanted: state of the root, shape (n_root,).
            now: the one that is read, shape (n_root,).
        """
        space = self.objects[self.declared.root]
        way = space.difference(wanted, now)
        at = [(space.index(t.variable), t) for t in self.actions]
        return np.array([t.scale * float(way[i] if t.relative else wanted[i]) for i, t in at])

    def noise_of(self, name: str) -> FloatArray:
        """Standard deviations of the readings of an object, shape (n_observable,)."""
        return np.array([self.noise_std.get(f"{name}.{v}", 0.0) for v in self.objects[name].observable.names])
