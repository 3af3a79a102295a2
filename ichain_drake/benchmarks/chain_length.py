"""How cost grows with the length of a chain: synthetic chains whose every child mirrors its parent."""

from __future__ import annotations

import functools
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, ClassVar

import numpy as np
import pandas as pd
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource

from ichain_drake.benchmarks.measure import line_fit, seconds_a_call
from ichain_drake.control.tracking.chain import ControlCandidates, make_controller
from ichain_drake.control.tracking.path import PathLimits
from ichain_drake.demonstrations.columns import TIME, column
from ichain_drake.demonstrations.table import Demonstration
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning.chain.chain import LearnedChain, LearnedLink, LinkCandidates, learn_link
from ichain_drake.learning.chain.link import EstimatorSpec
from ichain_drake.objects.base import ObjectSettings, ParentStates, WorldObject
from ichain_drake.robot import HandSpec, RobotSpec, build_robot
from ichain_drake.state import FloatArray, Role, StateSpace, Variable
from ichain_drake.timing import TICK
from ichain_drake.world.world import World

_SPACE = StateSpace(
    "dial",
    tuple(Variable(axis, "1", -1.0, 1.0, role=Role("position", "dial", axis)) for axis in ("x", "y")),
)
_SAMPLES = 200
_NOISE = 0.005


def mirrored(parent: FloatArray) -> FloatArray:
    """What a dial shows for its parent's two variables, shape (..., 2): a mild bend, invertible."""
    return parent + 0.1 * np.sin(2.0 * parent[..., ::-1])


class Dial(WorldObject):
    """A synthetic object that shows its parent's first two variables, bent and with noise."""

    state_space: ClassVar[StateSpace] = _SPACE
    process_noise_size: ClassVar[int] = 2

    def step(
        self, state: FloatArray, parents: ParentStates, active: Mapping[str, FloatArray], noise: FloatArray, dt: float
    ) -> FloatArray:
        """Shows the parent within one frame."""
        (parent,) = parents.values()
        return self.state_space.clip(mirrored(parent[..., :2]) + _NOISE * noise)


def learn_dial(seed: int = 0) -> LearnedLink:
    """One link, learned from transitions at random places."""
    random = np.random.default_rng(seed)
    parent = random.uniform(-0.8, 0.8, (_SAMPLES + 1, 2))
    child = mirrored(parent) + _NOISE * random.standard_normal(parent.shape)
    data = {TIME: TICK * np.arange(len(parent))}
    for name, values in (("o0", parent), ("o1", child)):
        data |= {column(name, axis): values[:, i] for i, axis in enumerate("xy")}
    graph = InteractionGraph({"o0": _SPACE, "o1": _SPACE}, ["o0->o1"])
    piece = Demonstration(pd.DataFrame(data), {c: "1" for c in data if c != TIME})
    one = EstimatorSpec("polynomial", {"degree": 3})
    candidates = LinkCandidates((one,), (one,), ("none",), ("next",))
    return learn_link([piece], graph, Interaction("o0", "o1"), candidates, [0, 1])


def synthetic_chain(link: LearnedLink, length: int) -> LearnedChain:
    """A chain of that many objects, the robot included, with the same learned link everywhere."""
    names = [f"o{i}" for i in range(length)]
    edges = [Interaction(a, b) for a, b in zip(names[:-1], names[1:], strict=True)]
    graph = InteractionGraph(dict.fromkeys(names, _SPACE), edges)
    links = tuple(replace(link, interaction=edge) for edge in edges)
    limit = link.parent_upper - link.parent_lower
    return LearnedChain(graph, links, (0, 1), None, link.parent_lower, link.parent_upper, limit)


def synthetic_world(length: int) -> Simulator:
    """A world of that many objects, the robot included, under a constant command."""
    spec = RobotSpec(hand=HandSpec(["x", "y"], {"z": 0.2}), home={"x": 0.3, "y": 0.1})
    robot = build_robot(spec, "ideal")
    spaces = {"o0": robot.space} | {f"o{i}": _SPACE for i in range(1, length)}
    graph = InteractionGraph(spaces, [(f"o{i}", f"o{i + 1}") for i in range(length - 1)])
    objects = {
        f"o{i}": Dial(f"o{i}", {f"o{i - 1}": spaces[f"o{i - 1}"]}, settings=ObjectSettings(i)) for i in range(1, length)
    }
    builder = DiagramBuilder()
    world = builder.AddSystem(World(graph, robot, objects))
    command = builder.AddSystem(ConstantVectorSource([0.3, 0.1]))
    builder.Connect(command.get_output_port(), world.GetInputPort("hand_command"))
    simulator = Simulator(builder.Build())
    robot.set_hand(simulator.get_mutable_context(), spec.home_hand())
    simulator.Initialize()
    return simulator


def benchmark_chain_length(lengths: Sequence[int], methods: Sequence[str], repeats: int) -> dict[str, Any]:
    """Time of one decision and of one tick of the world against the number of objects.

    Args:
        lengths: numbers of objects, the robot included, >= 2.
        methods: control methods of the last object.
        repeats: rounds.

    Returns:
        Times [ms] per length, and for each a fitted line in ms an object.
    """
    link = learn_dial()
    limits = PathLimits(speed=0.3)
    states = np.array([[0.1, -0.2]])
    rows: dict[str, list[float]] = {key: [] for key in (*(f"decision_{m}" for m in methods), "world_tick")}
    for length in lengths:
        chain = synthetic_chain(link, length)
        for method in methods:
            policy = make_controller(chain, method, limits, ControlCandidates(efforts=(0.05,))).policy
            wanted = np.full((1, policy.lookahead, 2), 0.3)
            memory = np.zeros((1, policy.memory_size))
            decide = functools.partial(policy.decide, [states] * length, wanted, memory)
            seconds = seconds_a_call(decide, repeats, 5)
            rows[f"decision_{method}"].append(1000.0 * seconds)
        rows["world_tick"].append(1000.0 * _tick_seconds(synthetic_world(length), repeats))
    fits = {key: line_fit(list(lengths), values) for key, values in rows.items()}
    return {"lengths": list(lengths), "ms": rows, "fit": fits}


def _tick_seconds(simulator: Simulator, repeats: int) -> float:
    def tick() -> None:
        simulator.AdvanceTo((round(simulator.get_context().get_time() / TICK) + 1) * TICK)

    return seconds_a_call(tick, repeats, 3)
