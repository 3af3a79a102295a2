"""A scenario whose world somebody else simulates: an environment with objects, its robot as the root."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
from pydrake.systems.framework import Diagram

from ichain_drake.graph import InteractionGraph
from ichain_drake.objects.base import WorldObject
from ichain_drake.robot import Physics
from ichain_drake.scenarios.graph_scenario import GraphScenario
from ichain_drake.scenarios.hand_commands import HandCommands
from ichain_drake.scenarios.object_maker import ObjectMaker
from ichain_drake.state import FloatArray
from ichain_drake.visualization import Camera, Drawing
from ichain_drake.visualization.plain_drawing import PlainDrawing, places
from ichain_drake.world.environment_spec import EnvironmentSpec
from ichain_drake.world.environment_world import environment_world
from ichain_drake.world.open_environment import OpenEnvironment
from ichain_drake.world.world import World

_RUNS_PER_SEED = 1000
_STARTS = 2**31  # seeds of resets are drawn below this
_BLOCKS = 30  # blocks that fit beside each other into the room
_LOOKED = 3  # starts that are looked at for its size
_LEAST = 0.1  # of its sides [m]


class EnvironmentScenario(GraphScenario[int]):
    """A goal in somebody else's environment; see `GraphScenario`.

    A subclass has a `name`, may have a `config_class`, and provides `environment` and `script`. A start is the seed of
    the environment's reset, a command the wanted state of the root: what it exposes, in its order.

    Args:
        overrides: `--set` settings.
        physics: `environment`; `contact`, which is asked for where nothing is, means the same.
        seed: seed of the run.

    Raises:
        InputError: see `Scenario`; and if the environment doesn't fit what is declared of it.
    """

    physics_kinds: ClassVar[tuple[Physics, ...]] = ("environment",)

    def __init__(self, overrides: str | Sequence[str] = (), physics: Physics = "environment", seed: int = 0) -> None:
        super().__init__(overrides, "environment" if physics == "contact" else physics, seed)

    @abstractmethod
    def environment(self) -> EnvironmentSpec:
        """The environment, and how it is to be understood; from the configuration."""

    @cached_property
    def opened(self) -> OpenEnvironment:
        """The open environment."""
        return OpenEnvironment(self.environment())

    def make_graph(self) -> InteractionGraph:
        """As declared, with what is hidden."""
        return self.opened.spec.graph

    def draw_start(self, rng: np.random.Generator) -> int:
        """The seed of a reset."""
        return int(rng.integers(_STARTS))

    def make_objects(self, start: int, make: ObjectMaker) -> Mapping[str, WorldObject]:
        """None of its own: the environment has them."""
        return {}

    def build_world(self, start: int, run: int, physics: Physics | None = None, *, faulty: bool = False) -> World:
        """The environment's world, started by a seed; arguments as those of `GraphScenario`."""
        seed = self.seed * _RUNS_PER_SEED + run
        return environment_world(self.opened, start, seed, self.config.noise.scale)

    def start_states(self, start: int) -> dict[str, FloatArray]:
        """True states of all objects after a reset, what is observable, for scripts that look before they act.

        Args:
            start: its seed.
        """
        state = self.opened.start(start)
        spaces = self.graph.objects
        return {n: state[p][spaces[n].observable_indices] for n, p in self.opened.places.items()}

    def hand_commands(self, start: FloatArray | Sequence[float] | None = None) -> HandCommands:
        """What a script lays its commands out with, for roots that have a hand's variables.

        Args:
            start: the root's state at the start, shape (n_root,); default: that of run 0.
        """
        root = self.graph.root
        at_start = self.start_states(self.start(0))[root] if start is None else start
        return HandCommands(self.graph.objects[root].observable.names, at_start)

    def given(self) -> dict[str, Any]:
        """As `Scenario`; in place of a robot of ours, what is declared of the environment."""
        spec = self.opened.spec
        actions = {f"{k}: {t.variable}": t.scale for k, t in enumerate(spec.actions)}
        about = {"name": self.opened.where, "steps_per_tick": spec.steps_per_tick, "actions": actions}
        plain = {k: v for k, v in super().given().items() if k != "robot"}
        return {**plain, "environment": {**about, "noise_std": dict(spec.noise_std)}}

    def drawn_plant(self) -> Diagram | None:
        """None: no arm of ours is there."""
        return None

    def drawings(self) -> Mapping[str, Drawing]:
        """A block for everything that has a place; how it really looks nobody declared."""
        low, high = self._room
        placed = {n: s for n, s in self.graph.objects.items() if places(s)}
        size = float(np.max(high - low)) / _BLOCKS
        return {n: PlainDrawing(n, s, size, k) for k, (n, s) in enumerate(placed.items())}

    def view(self) -> Camera:
        """All of the room, from above and a little from the side of low y."""
        low, high = self._room
        middle, far = (low + high) / 2, float(np.max(high - low))
        x, y, z = (float(v) for v in middle)
        return Camera((x, y - 0.9 * far, z + 1.3 * far), (x, y, z), ground=None)

    @cached_property
    def _room(self) -> tuple[FloatArray, FloatArray]:
        """Corners of the box in which things are at some starts, or may be by their bounds, shape (3,) each [m]."""
        ends: dict[int, list[float]] = {0: [0.0], 1: [0.0], 2: [0.0]}
        starts = [self.start_states(self.start(run)) for run in range(_LOOKED)]
        for name, space in self.graph.objects.items():
            for axis, i in places(space.observable).items():
                bounds = (space.observable.lower[i], space.observable.upper[i])
                ends[axis] += [float(b) for b in bounds if np.isfinite(b)] + [float(s[name][i]) for s in starts]
        low, high = (np.array([f(ends[axis]) for axis in range(3)]) for f in (min, max))
        return low, np.maximum(high, low + _LEAST)
