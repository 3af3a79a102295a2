"""A scenario's graph in random words and another order, and its own world driven by what was learned of it."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import MatrixGain

from ichain_drake.control.execution.controller import GraphController
from ichain_drake.control.execution.executor import Executor, Memory
from ichain_drake.control.planning.goals import parse_goal
from ichain_drake.control.planning.plan import Plan
from ichain_drake.control.planning.planner import GraphPlanner
from ichain_drake.control.planning.skills import Skills
from ichain_drake.demonstrations import Demonstration, column
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning import InteractionModel
from ichain_drake.simulation.wiring import look
from ichain_drake.state import FloatArray, StateSpace
from ichain_drake.systems.water_dispenser.scenario import WaterDispenser
from ichain_drake.timing import TICK


class OtherWords:
    """Renames objects, variables and types, and shuffles the order of objects, variables and interactions."""

    def __init__(self, graph: InteractionGraph, seed: int) -> None:
        self.old, rng = graph, np.random.default_rng(seed)
        words = iter(f"q{k}w" for k in rng.permutation(10_000))
        self.objects = {n: next(words) for n in graph.objects}
        self.variables = {(n, v): next(words) for n, s in graph.objects.items() for v in s.names}
        self.order = {n: rng.permutation(len(s.observable)) for n, s in graph.objects.items()}
        spaces = {}
        for name in rng.permutation(list(graph.objects)).tolist():
            parts = [self._variable(name, v) for v in graph.objects[name].observable.variables]
            spaces[self.objects[name]] = StateSpace(next(words), tuple(parts[i] for i in self.order[name]))
        edges = [self.edge(e) for e in graph.interactions]
        self.graph = InteractionGraph(spaces, [edges[i] for i in rng.permutation(len(edges))])
        self.pieces_order = rng.permutation(100)

    def _variable(self, obj: str, variable):  # noqa: ANN001, ANN202
        role = variable.role
        if role is not None and role.of:
            role = replace(role, of=self.variables[obj, role.of])
        return replace(variable, name=self.variables[obj, variable.name], role=role)

    def edge(self, edge: Interaction) -> Interaction:
        return Interaction(self.objects[edge.parent], self.objects[edge.child])

    def pieces(self, shown: Sequence[Demonstration]) -> list[Demonstration]:
        names = {column(o, v): column(self.objects[o], w) for (o, v), w in self.variables.items()}
        names |= {e.name: self.edge(e).name for e in self.old.interactions}
        names |= {column("command", v): column("command", self.variables[self.old.root, v]) for v in self._root_names()}
        renamed = [Demonstration(p.table.rename(columns=names), {}, f"{k}") for k, p in enumerate(shown)]
        return [renamed[k] for k in self.pieces_order if k < len(renamed)]

    def _root_names(self) -> Sequence[str]:
        return self.old.objects[self.old.root].names

    def goal(self, expressions: Sequence[str]) -> list[str]:
        def variable(found: re.Match[str]) -> str:
            return column(self.objects[found[1]], self.variables[found[1], found[2]])

        def edge(found: re.Match[str]) -> str:
            return self.edge(Interaction(found[1], found[2])).name

        edges = [re.sub(r"(\w+)->(\w+)", edge, text) for text in expressions]
        return [re.sub(r"([a-z]+)\.([a-z]\w*)", variable, text) for text in edges]

    def states(self, states: dict[str, FloatArray]) -> dict[str, FloatArray]:
        return {self.objects[n]: v[self.order[n]] for n, v in states.items()}

    def matrix(self, obj: str) -> FloatArray:
        """Turns an object's vector into its renamed and shuffled one."""
        return np.eye(len(self.order[obj]))[self.order[obj]]

    def plan(self, plan: Plan) -> list[list[str]]:
        """Chains of a plan over the old graph, in the new words."""
        return [[self.edge(e).name for e in step.chain] for step in plan.steps]


def drive(scenario: WaterDispenser, words: OtherWords, model: InteractionModel, goal: Sequence[str]) -> Memory:
    """Execute with a renamed model in the scenario's own world; signals are put into the other order on their way."""
    world = scenario.make_world(0)
    start = words.states(dict(look(world)))
    wanted = parse_goal(words.goal(goal), model, start)
    executor = Executor(model, Skills.of(model), GraphPlanner(model).plan, wanted)
    root = words.old.root
    home = np.array(scenario.start(0).hand)[words.order[root]]
    builder = DiagramBuilder()
    builder.AddSystem(world)
    controller = builder.AddSystem(GraphController(executor, home))
    for old, new in words.objects.items():
        turn = builder.AddSystem(MatrixGain(words.matrix(old)))
        builder.Connect(world.GetOutputPort(f"{old}.measured"), turn.get_input_port())
        builder.Connect(turn.get_output_port(), controller.GetInputPort(new))
        builder.Connect(world.GetOutputPort(f"{old}.valid"), controller.GetInputPort(f"{new}.valid"))
    back = builder.AddSystem(MatrixGain(words.matrix(root).T))
    builder.Connect(controller.GetOutputPort("hand_command"), back.get_input_port())
    builder.Connect(back.get_output_port(), world.GetInputPort("hand_command"))
    simulator = Simulator(builder.Build())
    context = simulator.get_mutable_context()
    simulator.Initialize()
    tick = 0
    while not (memory := controller.memory(controller.GetMyContextFromRoot(context))).stopped and tick < 1500:
        tick += 1
        simulator.AdvanceTo(tick * TICK)
    return memory
