"""One episode towards a goal over an interaction graph, and the look at a world that comes before it."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from pydrake.systems.framework import DiagramBuilder, LeafSystem
from pydrake.systems.primitives import LogVectorOutput

from ichain_drake.control.execution.controller import GraphController
from ichain_drake.control.execution.executor import Memory
from ichain_drake.control.planning.plan import States
from ichain_drake.graph import InteractionGraph
from ichain_drake.simulation.episode import Episode, Prepare
from ichain_drake.state import FloatArray
from ichain_drake.timing import FRAME
from ichain_drake.world.world import World

_PORTS = ("mode", "edge", "skill", "plan_step")
_LOOK = 4  # ticks of readings that a plan is made from


class MakesWorlds(Protocol):
    """What a look asks of a scenario, which every `GoalScenario` offers."""

    graph: InteractionGraph

    def make_world(self, run: int) -> tuple[World, Prepare]: ...  # noqa: D102


class GraphEpisode(Episode):
    """An episode under a `GraphController`: sensors' validity reaches it, what it does is logged.

    Args:
        world: the world.
        controller: closes the loop.
        prepare: puts the world into its start state.
    """

    def __init__(self, world: World, controller: GraphController, prepare: Prepare) -> None:
        self.controller = controller
        super().__init__(world, controller, prepare)

    def _add_logs(self, builder: DiagramBuilder, commander: LeafSystem) -> dict[str, LeafSystem]:
        for name in self.world.graph.objects:
            builder.Connect(self.world.GetOutputPort(f"{name}.valid"), commander.GetInputPort(f"{name}.valid"))
        sinks = super()._add_logs(builder, commander)
        return sinks | {p: LogVectorOutput(commander.GetOutputPort(p), builder, FRAME) for p in _PORTS}

    @property
    def memory(self) -> Memory:
        """What the controller remembers now."""
        return self.controller.memory(self.controller.GetMyContextFromRoot(self.context))

    def doing(self) -> dict[str, FloatArray]:
        """Logged ports of the controller, shape (n,) each."""
        return {p: np.array(self._sinks[p].FindLog(self.context).data())[0].copy() for p in _PORTS}


def look(scenario: MakesWorlds, number: int = 0) -> States:
    """What is measured at the start of a run, averaged over the ticks that the controller looks too.

    Args:
        scenario: makes the world.
        number: of the run.
    """
    world, prepare = scenario.make_world(number)
    episode = Episode(world, _Still(start_command(world, prepare)), prepare, log=False)
    readings = [{n: episode.value(n) for n in scenario.graph.objects}]
    for _ in range(_LOOK - 1):
        episode.run(1)
        readings.append({n: episode.value(n) for n in scenario.graph.objects})
    return {n: np.mean([r[n] for r in readings], axis=0) for n in scenario.graph.objects}


class _Still(LeafSystem):
    """Sends one command for ever."""

    def __init__(self, command: FloatArray) -> None:
        super().__init__()
        self._command = self.DeclareDiscreteState(command)
        self.DeclareStateOutputPort("hand_command", self._command)


def start_command(world: World, prepare: Prepare) -> FloatArray:
    """The robot's state at the start of a run, shape (n_root,)."""
    context = world.CreateDefaultContext()
    prepare(context)
    robot = world.robot
    state = robot.GetOutputPort("state").Eval(robot.GetMyContextFromRoot(context))
    space = world.graph.objects[world.graph.root]
    return np.asarray(state, dtype=float)[space.observable_indices]
