"""A controller for a model and a task in anybody's diagram; worlds and controllers are wired here, and nowhere else."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder, System

from ichain_drake.control.execution.controller import GraphController
from ichain_drake.control.execution.course import RobotMotion
from ichain_drake.control.execution.executor import Executor, ExecutorSettings, Planner
from ichain_drake.control.planning.goals import parse_goal
from ichain_drake.control.planning.plan import Goal, States
from ichain_drake.control.planning.planner import PLANNERS, GraphPlanner, SearchSettings
from ichain_drake.control.planning.skills import OwnSkills, Skills
from ichain_drake.control.tracking.chain import ChainController, make_controller
from ichain_drake.control.tracking.foresight import foreseen
from ichain_drake.control.tracking.path import TimedPath
from ichain_drake.control.tracking.systems import Controller, PathController
from ichain_drake.errors import InputError
from ichain_drake.learning.chain.chain import LearnedChain
from ichain_drake.learning.model import InteractionModel
from ichain_drake.simulation.interruption import deferred_interrupt
from ichain_drake.state import FloatArray
from ichain_drake.timing import FRAME, FRAMES_PER_TICK
from ichain_drake.world.world import World

LOOK = 4
"""Ticks of readings that a goal is read with."""

Task = TimedPath | Goal | str | Sequence[str]
"""What is wanted: a timed path of the last object of a chain; or a goal, as it is or as text."""


def wire(builder: DiagramBuilder, world: World, commander: System, truth: Sequence[str] = ()) -> None:
    """Connect a world and whatever sends its hand commands, both in the same builder.

    Args:
        builder: has both.
        world: the world.
        commander: a system with an output port `hand_command`; its inputs `<object>` and `<object>.measured` are
            connected to what is measured of that object, `<object>.valid` to whether that is valid, and `delay` to
            how late a command acts, in a world that knows it.
        truth: names of objects whose full state is connected to the input of their name; only an oracle reads it.
    """
    for name in world.graph.objects:
        read = "state" if name in truth else "measured"
        for port, source in ((name, read), (f"{name}.measured", "measured"), (f"{name}.valid", "valid")):
            if commander.HasInputPort(port):
                builder.Connect(world.GetOutputPort(f"{name}.{source}"), commander.GetInputPort(port))
    if commander.HasInputPort("delay") and world.HasOutputPort("delay"):
        builder.Connect(world.GetOutputPort("delay"), commander.GetInputPort("delay"))
    builder.Connect(commander.GetOutputPort("hand_command"), world.GetInputPort("hand_command"))


def path_controller(chain: LearnedChain, controller: ChainController, path: TimedPath) -> PathController:
    """The system that follows a path with a learned chain."""
    spaces = {n: chain.graph.objects[n].observable for n in chain.names}
    middle = (chain.command_lower + chain.command_upper) / 2
    decides = Controller(controller.policy, spaces, len(chain.targets), middle, foresee=partial(foreseen, chain))
    return PathController(decides, path, chain.names[-1], spaces[chain.names[-1]], chain.targets)


def goal_executor(
    model: InteractionModel,
    goal: Goal,
    *,
    motion: RobotMotion | None = None,
    own_skills: OwnSkills | None = None,
    settings: ExecutorSettings | None = None,
    planner: Planner | str = "fast",
) -> Executor:
    """What brings about a goal with a learned graph; arguments as for `AddController`."""
    planner = make_planner(model, planner).plan if isinstance(planner, str) else planner
    return Executor(model, Skills.of(model, own_skills), planner, goal, settings, motion)


def make_planner(model: InteractionModel, name: str = "fast") -> GraphPlanner:
    """The planner of a run towards a goal, for what was learned or loaded.

    Args:
        model: the learned graph.
        name: `fast` finds a plan of few steps; `optimal` goes on to the one of least expected time, and proves it.

    Raises:
        InputError: on another name.
    """
    if name not in PLANNERS:
        raise InputError(f"planner: {name!r} is none; give {' or '.join(PLANNERS)}, or a function")
    return GraphPlanner(model, SearchSettings(optimal=name == "optimal"))


def AddController(  # noqa: N802 - named as Drake names what adds systems to a builder
    builder: DiagramBuilder,
    world: World,
    model: InteractionModel,
    task: Task,
    *,
    motion: RobotMotion | None = None,
    own_skills: OwnSkills | None = None,
    settings: ExecutorSettings | None = None,
    planner: Planner | str = "fast",
    controller: ChainController | None = None,
    progress: Callable[[str], None] | None = None,
) -> System:
    """Add a controller to a diagram, connected to a world in it: what is measured goes in, hand commands come out.

    Ports: output `hand_command`. For a path: `progress`, the index of the path's point that has been reached, and
    `wanted`, the states wanted of every object but the last. For a goal: `mode`, `edge`, `skill` and `plan_step`; see
    `GraphController`.

    Args:
        builder: the world is in it; see `AddWorld`.
        world: the world.
        model: learned (see `learn`), for paths where the task is one.
        task: see `Task`; text is read with what is measured of the world in its first ticks.
        motion: goals: lays out the hand's ways around what it may hit; straight lines without. A scenario's
            `make_motion` gives it.
        own_skills: goals: a designer's functions in place of learned skills.
        settings: goals: of the execution.
        planner: goals: `fast`, `optimal` (see `make_planner`), or a function of your own (a `Planner`): from measured
            states, goal and what the execution has shown so far (`Experience`) to a `Plan` of steps or `NoPlan`.
        controller: paths: one that was chosen before; by default the predictive one is chosen by validation.
        progress: paths: called with a line before each option of the validation.

    Returns:
        The controller.

    Raises:
        InputError: on a model that was learned for the other kind of task, or a goal that can't be read.
    """
    if isinstance(task, TimedPath):
        chain = model.for_paths()
        chosen = controller or make_controller(chain, "predictive", task.limits, progress=progress)
        system: System = path_controller(chain, chosen, task)
    else:
        model.for_goals()
        texts = [task] if isinstance(task, str) else task
        goal = texts if isinstance(texts, Goal) else parse_goal(texts, model, look(world))
        executor = goal_executor(model, goal, motion=motion, own_skills=own_skills, settings=settings, planner=planner)
        system = GraphController(executor, start_command(world))
    builder.AddSystem(system)
    wire(builder, world, system)
    return system


def look(world: World) -> States:
    """What is measured at the start of a run, averaged over the `LOOK` ticks that a controller looks too.

    Args:
        world: no part of a diagram that was built already.
    """
    simulator = Simulator(world)
    world.GetInputPort("hand_command").FixValue(simulator.get_mutable_context(), start_command(world))
    simulator.Initialize()
    readings = []
    with deferred_interrupt() as pressed:
        for tick in range(LOOK):
            if tick:
                simulator.AdvanceTo(tick * FRAMES_PER_TICK * FRAME)
            if pressed():
                raise KeyboardInterrupt
            context = simulator.get_context()
            readings.append({n: world.GetOutputPort(f"{n}.measured").Eval(context).copy() for n in world.graph.objects})
    return {n: np.mean([r[n] for r in readings], axis=0) for n in world.graph.objects}


def start_command(world: World) -> FloatArray:
    """The robot's state at the start of a run, shape (n_root,); of several robots, one after the other."""
    context, graph, parts = world.CreateDefaultContext(), world.graph, {}
    for name in graph.roots:
        state = np.asarray(world.GetOutputPort(f"{name}.state").Eval(context), dtype=float)
        parts[name] = state[graph.objects[name].observable_indices]
    return graph.join_command(parts)
