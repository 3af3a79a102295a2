"""A scenario's world alone: it starts where a run starts, in any diagram."""

import numpy as np
import pytest
from pydrake.geometry import MeshcatVisualizer, StartMeshcat
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Diagram, DiagramBuilder

from ichain_drake.errors import InputError
from ichain_drake.scenarios import Scenario, build_world
from ichain_drake.scenarios.build import AddWorld
from ichain_drake.scenarios.joystick_game import JoystickGameConfig
from ichain_drake.systems import load_scenario
from ichain_drake.systems.car_game.scenario import CarGame
from ichain_drake.world import World


def states(diagram: Diagram, context) -> list[np.ndarray]:
    return [context.get_discrete_state(i).CopyToVector() for i in range(context.num_discrete_state_groups())]


def starts_at_rest(world: World) -> None:
    """The default context is where `set_hand` would put it, fingers and all, to the last bit."""
    context, put = world.CreateDefaultContext(), world.CreateDefaultContext()
    world.robot.set_hand(put, world.robot.GetOutputPort("setpoint").Eval(world.robot.GetMyContextFromRoot(put)))
    for built, wanted in zip(states(world, context), states(world, put), strict=True):
        np.testing.assert_array_equal(built, wanted)


@pytest.mark.parametrize("physics", ["ideal", "arm", "contact"])
def test_the_default_context_is_the_start_of_a_run(physics) -> None:
    scenario = load_scenario("car_game", physics=physics, seed=3)
    home = dict(scenario.config.robot.home)
    world = build_world(scenario, path="spiral", run=2)
    assert scenario.config.robot.home == home, "the scenario was changed"
    starts_at_rest(world)
    held = world.robot.GetOutputPort("state").Eval(world.robot.GetMyContextFromRoot(world.CreateDefaultContext()))
    assert np.abs(held - scenario.config.robot.hand.reduce(scenario.config.robot.home_hand())).max() > 1e-3


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


def test_an_arm_is_seen_in_anybodys_meshcat() -> None:
    builder, meshcat = DiagramBuilder(), StartMeshcat()
    world = AddWorld(builder, load_scenario("car_game", physics="contact"), "spiral", run=1)
    MeshcatVisualizer.AddToBuilder(builder, world.GetOutputPort("query"), meshcat)
    builder.ExportInput(world.GetInputPort("hand_command"), "hand_command")
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()
    diagram.GetInputPort("hand_command").FixValue(context, [0.5, 0.0])
    diagram.ForcedPublish(context)
    assert meshcat.HasPath("/drake/visualizer/arm")
    assert meshcat.HasPath("/drake/visualizer/joystick")


def test_an_unknown_path_is_named() -> None:
    with pytest.raises(InputError, match="car_game has no path 'circle'; it has eight, spiral, cursive"):
        build_world(load_scenario("car_game", physics="ideal"), path="circle")


@pytest.mark.parametrize("physics", ["ideal", "arm", "contact"])
def test_a_world_towards_a_goal_starts_where_its_run_starts(physics) -> None:
    scenario = load_scenario("kettle", physics=physics, seed=3)
    world = build_world(scenario, run=2)
    starts_at_rest(world)
    hand = world.robot.GetOutputPort("setpoint").Eval(world.robot.GetMyContextFromRoot(world.CreateDefaultContext()))
    np.testing.assert_array_equal(hand, scenario.start_hand(scenario.start(2)))
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
