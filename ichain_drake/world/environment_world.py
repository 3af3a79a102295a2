"""An environment as a world: its robot is the root, its objects are objects, all of its state lies in the context."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from pydrake.systems.framework import BasicVector, Context, DiscreteValues, LeafSystem

from ichain_drake.noise import NoiseStream
from ichain_drake.objects.base import ObjectSettings, ParentStates, WorldObject
from ichain_drake.state import FloatArray
from ichain_drake.timing import FRAME, FRAMES_PER_TICK
from ichain_drake.world.open_environment import OpenEnvironment
from ichain_drake.world.world import World

_ROOT_ID = 0  # keys the root's noise; objects follow in the graph's order


def environment_world(opened: OpenEnvironment, start: int, seed: int = 0, noise_scale: float = 1.0) -> World:
    """A world whose default context is the environment's start.

    Args:
        opened: the environment; worlds that share it must not step at the same time.
        start: seed of the environment's reset.
        seed: of the readings' noise.
        noise_scale: factor on it.
    """
    state, graph = opened.start(start), opened.spec.graph
    root = _Root(opened, state, seed, noise_scale)
    objects: dict[str, WorldObject] = {}
    for number, name in enumerate(n for n in graph.objects if n != graph.root):
        space = graph.objects[name]
        kind = type("EnvironmentObject", (_Thing,), {"state_space": space, "noise_std": opened.spec.noise_of(name)})
        settings = ObjectSettings(_ROOT_ID + 1 + number, seed, noise_scale, body_size=len(space))
        parents = {p: graph.objects[p] for p in graph.parents(name)}
        objects[name] = kind(name, parents, state[opened.places[name]], settings)
    return World(graph, root, objects)


class _Root(LeafSystem):
    """The environment. Its root's state is a port of its own; the others' are sampled as bodies are from a plant."""

    def __init__(self, opened: OpenEnvironment, state: FloatArray, seed: int, noise_scale: float) -> None:
        super().__init__()
        self._opened, self._scale = opened, noise_scale
        graph = opened.spec.graph
        observable = graph.objects[graph.root].observable
        self._std = opened.spec.noise_of(graph.root)
        self._readings = NoiseStream(seed, _ROOT_ID, "measurement", tuple(range(len(observable))))
        self._process = NoiseStream(seed, _ROOT_ID, "process", (0,))
        self._command = self.DeclareVectorInputPort("hand_command", len(observable))
        self._state = self.DeclareDiscreteState(state)
        self._frame = self.DeclareDiscreteState(1)
        held = {self.xd_ticket()}
        place = opened.places[graph.root]
        self.DeclareVectorOutputPort("state", place.stop - place.start, self._shows(place), held)
        self.DeclareVectorOutputPort("measured", len(observable), self._measure, held)
        self.DeclareVectorOutputPort("valid", 1, lambda _, out: out.SetFromVector([1.0]), {self.nothing_ticket()})
        for name in (n for n in graph.objects if n != graph.root):
            place = opened.places[name]
            self.DeclareVectorOutputPort(f"{name}_body", place.stop - place.start, self._shows(place), held)
            self.DeclareVectorOutputPort(f"{name}_touch", 1, lambda _, out: out.SetFromVector([0.0]),
                                         {self.nothing_ticket()})  # fmt: skip
        self.DeclarePeriodicDiscreteUpdateEvent(FRAME, 0.0, self._advance)

    def _shows(self, place: slice) -> Callable[[Context, BasicVector], None]:
        return lambda context, output: output.SetFromVector(context.get_discrete_state(self._state).value()[place])

    def _measure(self, context: Context, output: BasicVector) -> None:
        begin = self._opened.places[self._opened.spec.graph.root].start
        truth = context.get_discrete_state(self._state).value()[begin : begin + len(self._std)]
        frame = int(context.get_discrete_state(self._frame).value()[0])
        output.SetFromVector(truth + self._scale * self._std * self._readings.at(frame))

    def _advance(self, context: Context, discrete: DiscreteValues) -> None:
        """A tick of the environment in the first frame of each of ours; then it rests."""
        frame = int(context.get_discrete_state(self._frame).value()[0])
        discrete.set_value(self._frame, [frame + 1])
        if frame % FRAMES_PER_TICK == 0:
            state = context.get_discrete_state(self._state).value().copy()
            wanted = self._command.Eval(context)
            discrete.set_value(self._state, self._opened.tick(state, wanted, self._process.at(frame)))


class _Thing(WorldObject):
    """An object of the environment: what it is, and what acts on it, is sampled."""

    noise_std: FloatArray

    def sample_body(self, body: FloatArray) -> FloatArray:
        """All of it."""
        return body

    def step(
        self, state: FloatArray, parents: ParentStates, active: Mapping[str, FloatArray], noise: FloatArray, dt: float
    ) -> FloatArray:
        """It has no motion of its own."""
        return np.array(state, dtype=float)

    def decide_active(
        self, state: FloatArray, parents: ParentStates, active: Mapping[str, bool], touch: float | None
    ) -> dict[str, bool]:
        """As the environment tells, in the variables behind those that are measured."""
        flags = state[..., len(self.state_space) - len(self.parents) :]
        return {p: bool(flag > 0.5) for p, flag in zip(self.parents, flags, strict=True)}  # noqa: PLR2004

    def measure(self, state: FloatArray, noise: FloatArray) -> FloatArray:
        """With the declared noise."""
        return state[..., self.state_space.observable_indices] + self.noise_std * noise
