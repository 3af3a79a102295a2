"""The executor as a Drake system: ports, instants, and memory that belongs to the context."""

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context
from small_job import GRAPH, executor, fresh, readings

from ichain_drake.control.execution.controller import GraphController
from ichain_drake.control.execution.tasks import Mode
from ichain_drake.timing import FRAME, FRAMES_PER_TICK

FILL = ["box.water >= 0.4", "not hand->box"]


def ready() -> tuple[GraphController, Simulator, Context]:
    world = fresh()
    states = readings(world)
    system = GraphController(executor(FILL, world), states["hand"])
    simulator = Simulator(system)
    context = simulator.get_mutable_context()
    for name in GRAPH.objects:
        system.GetInputPort(name).FixValue(context, states[name])
        system.GetInputPort(f"{name}.valid").FixValue(context, [1.0])
    return system, simulator, context


def test_it_reads_measured_and_valid_and_nothing_else() -> None:
    system, _, _ = ready()
    inputs = {system.get_input_port(k).get_name() for k in range(system.num_input_ports())}
    assert inputs == {*GRAPH.objects, *(f"{n}.valid" for n in GRAPH.objects)}
    outputs = {system.get_output_port(k).get_name() for k in range(system.num_output_ports())}
    assert outputs == {"hand_command", "mode", "edge", "skill", "plan_step"}
    assert not system.HasAnyDirectFeedthrough()


def test_it_decides_on_each_tenth_frame_and_shows_what_it_does() -> None:
    system, simulator, context = ready()
    seen = []
    for frame in range(1, 12 * FRAMES_PER_TICK + 1):
        before = [system.GetOutputPort(p).Eval(context)[0] for p in ("mode", "edge", "skill", "plan_step")]
        simulator.AdvanceTo((frame + 0.5) * FRAME)
        after = [system.GetOutputPort(p).Eval(context)[0] for p in ("mode", "edge", "skill", "plan_step")]
        if frame % FRAMES_PER_TICK:
            assert before == after
        else:  # the hand is where it was told to be
            command = system.GetOutputPort("hand_command").Eval(context)
            system.GetInputPort("hand").FixValue(context, command)
        seen.append(after)
    assert system.memory(context).tick == 13
    assert seen[0] == [Mode.LOOK, -1, 0, -1]
    assert seen[-1] == [Mode.ACTIVATE, [e.name for e in GRAPH.interactions].index("hand->box"), 1, 0]


def test_memory_belongs_to_the_context() -> None:
    system, simulator, context = ready()
    simulator.AdvanceTo(6 * FRAMES_PER_TICK * FRAME + 0.5 * FRAME)
    other = context.Clone()
    ticks, command = system.memory(context).tick, system.GetOutputPort("hand_command").Eval(context).copy()
    simulator.AdvanceTo(12 * FRAMES_PER_TICK * FRAME + 0.5 * FRAME)
    assert system.memory(other).tick == ticks == 7
    np.testing.assert_array_equal(system.GetOutputPort("hand_command").Eval(other), command)
    again = Simulator(system, other)
    again.AdvanceTo(12 * FRAMES_PER_TICK * FRAME + 0.5 * FRAME)
    np.testing.assert_array_equal(
        system.GetOutputPort("hand_command").Eval(other), system.GetOutputPort("hand_command").Eval(context)
    )


def test_an_invalid_sensor_holds_the_command() -> None:
    system, simulator, context = ready()
    simulator.AdvanceTo(8 * FRAMES_PER_TICK * FRAME + 0.5 * FRAME)
    command = system.GetOutputPort("hand_command").Eval(context).copy()
    system.GetInputPort("box.valid").FixValue(context, [0.0])
    simulator.AdvanceTo(11 * FRAMES_PER_TICK * FRAME + 0.5 * FRAME)
    np.testing.assert_array_equal(system.GetOutputPort("hand_command").Eval(context), command)
    assert system.GetOutputPort("mode").Eval(context)[0] == Mode.BLIND
