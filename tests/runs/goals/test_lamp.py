"""A second graph is learned, planned and driven by the same code, and by the public interface alone."""

import json

import numpy as np
import pytest
from lamp import Lamp, LampScenario, Slider
from linked_library import CHAIN
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

import ichain_drake as ic
from ichain_drake.control.execution.tasks import Mode
from ichain_drake.control.tracking.path import PathLimits
from ichain_drake.learning import KnownParts


@pytest.fixture(scope="module")
def model() -> ic.InteractionModel:
    scenario = LampScenario()
    return ic.learn(scenario, scenario.record_demonstrations())


def run(model: ic.InteractionModel, *goal: str, number: int = 0) -> dict:
    ran = ic.GraphRun(LampScenario(), goal, number=number)
    ic.run_graph(ran, known=model)
    report = ran.report()
    json.dumps(report, allow_nan=False)
    return report


def test_what_acts_when_is_learned(model: ic.InteractionModel) -> None:
    edges = model.report()["interactions"]
    for name, edge in edges.items():
        assert edge["status"]["f1"] >= 0.85, name  # whole pieces are left out, and only few show a switch
    # Both act while the switch is on; how bright the lamp is then says nothing about it.
    for name in ("dimmer->lamp", "switch->lamp"):
        assert edges[name]["status"]["columns"] == ["position of switch"]


@pytest.mark.parametrize("number", [0, 1])
@pytest.mark.parametrize(
    "goal", [("0.55 <= lamp.light <= 0.65",), ("lamp.light >= 0.7", "not hand->dimmer", "not hand->switch")]
)
def test_a_wanted_brightness_needs_both(model: ic.InteractionModel, goal: tuple[str, ...], number: int) -> None:
    report = run(model, *goal, number=number)
    assert report["goal_reached"], report["reason"]
    assert sorted(step["chain"][-1] for step in report["metrics"]["plan"]) == ["hand->dimmer", "hand->switch"]


def test_brighter_than_bright_is_refused(model: ic.InteractionModel) -> None:
    report = run(model, "lamp.light >= 1.5")
    assert not report["goal_reached"]
    assert "lamp.light goes from 0 to 1 and is bounded there" in report["reason"]


def test_a_simulator_of_ones_own_does_the_same_to_the_last_bit(model: ic.InteractionModel) -> None:
    """The default context of anybody's Diagram is the start of the run, whoever looked at the world before."""
    goal = ["0.55 <= lamp.light <= 0.65", "keep dimmer.x within 0.2"]
    ran = ic.run(LampScenario(), goal, known=model, number=2)
    assert ran.goal_reached, ran.reason
    builder = DiagramBuilder()
    world = builder.AddSystem(LampScenario().make_world(2))
    controller = ic.AddController(builder, world, model, goal)
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(ran.log.times[-1])
    context = simulator.get_context()
    for name, states in ran.log.states.items():
        now = world.GetOutputPort(f"{name}.state").Eval(world.GetMyContextFromRoot(context))
        np.testing.assert_array_equal(now, states[-1])
    mode = controller.GetOutputPort("mode").Eval(controller.GetMyContextFromRoot(context))
    assert mode == [Mode.REACHED]
    for port in range(controller.num_input_ports()):
        assert controller.get_input_port(port).HasValue(controller.GetMyContextFromRoot(context))


def test_a_path_is_not_for_what_was_learned_for_goals(model: ic.InteractionModel) -> None:
    path = ic.TimedPath(np.array([[0.0, 0.0], [1.0, 0.0]]), PathLimits(0.1, spacing=0.1))
    with pytest.raises(ic.InputError, match="the model was learned for goals; for a path, give `learn` a target"):
        ic.AddController(DiagramBuilder(), LampScenario().make_world(0), model, path)


def test_a_goal_is_not_for_what_was_learned_about_a_chain() -> None:
    chain = ic.InteractionModel.of_chain(CHAIN, [], KnownParts())
    with pytest.raises(ic.InputError, match="learned for following paths; for a goal, give `learn` no target"):
        ic.AddController(DiagramBuilder(), LampScenario().make_world(0), chain, "lamp.light >= 0.5")


class Optimistic(Lamp):
    """Its sensor shows more light than there is."""

    def measure(self, state, noise):
        return np.clip(state + 0.3 + 0.005 * noise, 0.0, 1.0)


class Sticky(Slider):
    """Once taken it goes along with an open hand, too."""

    def decide_active(self, state, parents, active, touch):
        return {"hand": active["hand"] or super().decide_active(state, parents, active, touch)["hand"]}


class WithOptimist(LampScenario):
    kinds = {**LampScenario.kinds, "lamp": Optimistic}


class WithSticky(LampScenario):
    kinds = {**LampScenario.kinds, "dimmer": Sticky}


@pytest.mark.parametrize(
    ("scenario", "goal", "reason"),
    [
        (WithOptimist, ["lamp.light >= 0.2"], "lamp.light >= 0.2 is not true: it is 0"),
        (WithSticky, ["lamp.light >= 0.5", "not hand->dimmer"], "hand->dimmer is still active"),
    ],
)
def test_a_goal_is_judged_in_truth_whatever_sensors_and_models_say(
    model: ic.InteractionModel, scenario: type[LampScenario], goal: list[str], reason: str
) -> None:
    ran = ic.GraphRun(scenario(), goal)
    ic.run_graph(ran, known=model)
    assert ran.memory is not None
    assert ran.memory.mode == Mode.REACHED, "the controller believes it"
    report = ran.report()
    assert not report["goal_reached"]
    assert report["reason"].startswith(f"taken as reached, but {reason}")
    assert report["metrics"]["failure_cause"] == "misjudged"
