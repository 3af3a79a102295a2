"""A scenario's world alone: it starts where a run starts, in any diagram."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Diagram, DiagramBuilder

from ichain_drake.control.tracking.path import TimedPath
from ichain_drake.errors import InputError
from ichain_drake.scenarios import Scenario, build_world
from ichain_drake.scenarios.joystick_game import JoystickGameConfig
from ichain_drake.systems import load_scenario
from ichain_drake.systems.car_game.scenario import CarGame


def states(diagram: Diagram, context) -> list[np.ndarray]:
    return [context.get_discrete_state(i).CopyToVector() for i in range(context.num_discrete_state_groups())]


@pytest.mark.parametrize("physics", ["ideal", "arm", "contact"])
def test_the_default_context_is_the_start_of_a_run(physics) -> None:
    scenario = load_scenario("car_game", physics=physics, seed=3)
    home = dict(scenario.config.robot.home)
    world = build_world(scenario, path="spiral", run=2)
    assert scenario.config.robot.home == home, "the scenario was changed"
    expected, prepare = scenario.make_world(TimedPath(scenario.reference_paths()["spiral"], scenario.path_limits()), 2)
    context = expected.CreateDefaultContext()
    prepare(context)
    for built, wanted in zip(states(world, world.CreateDefaultContext()), states(expected, context), strict=True):
        np.testing.assert_array_equal(built, wanted)


def test_the_arm_holds_the_stick_inside_another_diagram() -> None:
    builder = DiagramBuilder()
    world = builder.AddSystem(build_world(load_scenario("car_game", physics="contact")))
    builder.ExportInput(world.GetInputPort("hand_command"), "hand_command")
    diagram = builder.Build()
    simulator = Simulator(diagram)
    hand = world.GetOutputPort("hand.state").Eval(world.GetMyContextFromRoot(simulator.get_context()))
    diagram.GetInputPort("hand_command").FixValue(simulator.get_mutable_context(), hand)
    simulator.AdvanceTo(0.5)
    context = world.GetMyContextFromRoot(simulator.get_context())
    assert world.GetOutputPort("joystick.active").Eval(context)[0] == 1.0
    assert world.GetOutputPort("joystick.state").Eval(context)[2:] == pytest.approx([0.0, 0.4], abs=0.03)


def test_an_unknown_path_is_named() -> None:
    with pytest.raises(InputError, match="car_game has no path 'circle'; it has eight, spiral, cursive"):
        build_world(load_scenario("car_game", physics="ideal"), path="circle")


@pytest.mark.parametrize("physics", ["ideal", "arm", "contact"])
def test_a_world_towards_a_goal_starts_where_its_run_starts(physics) -> None:
    scenario = load_scenario("kettle", physics=physics, seed=3)
    expected, prepare = scenario.make_world(2)
    context = expected.CreateDefaultContext()
    prepare(context)
    world = build_world(scenario, run=2)
    for built, wanted in zip(states(world, world.CreateDefaultContext()), states(expected, context), strict=True):
        np.testing.assert_array_equal(built, wanted)
    with pytest.raises(InputError, match="kettle has no paths; leave path 'eight' out"):
        build_world(scenario, path="eight")


class Still(Scenario):
    """The car game's objects, without a path to follow."""

    name = "car_game"
    config_class = JoystickGameConfig

    def make_graph(self):
        return CarGame(physics="ideal").graph

    def record_demonstrations(self, progress=None, known=()):
        yield from ()

    def drawings(self):
        return {}


def test_a_scenario_of_neither_kind_is_refused() -> None:
    with pytest.raises(InputError, match="car_game has neither paths nor a goal"):
        build_world(Still(physics="ideal"))
