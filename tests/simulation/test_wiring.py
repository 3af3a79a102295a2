"""The look at a world before a run: what sensors say, never what is."""

import numpy as np
import pytest
from lamp import Lamp, LampScenario
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

import ichain_drake as ic
from ichain_drake.control.planning.plan import States
from ichain_drake.runs.goals.run import own_goal
from ichain_drake.simulation.wiring import look, make_planner, start_command
from ichain_drake.systems.water_dispenser.scenario import WaterDispenser


class DimLamp(Lamp):
    """Its sensor shows 0.3 more than there is."""

    def measure(self, state, noise):
        return state + 0.3 + 0.01 * noise


class Lying(LampScenario):
    kinds = {**LampScenario.kinds, "lamp": DimLamp}


def test_a_start_is_what_was_measured_averaged_over_a_few_ticks() -> None:
    start = look(Lying().make_world(3))
    assert start["lamp"] == pytest.approx(0.3, abs=0.02)
    assert start["lamp"] != pytest.approx(0.3, abs=1e-6)
    assert start["lamp"] == look(Lying().make_world(3))["lamp"] != look(Lying().make_world(4))["lamp"]
    assert {n: v.shape for n, v in start.items()} == {"hand": (3,), "dimmer": (1,), "switch": (1,), "lamp": (1,)}
    many = [look(Lying().make_world(k))["dimmer"][0] - 0.4 for k in range(12)]
    assert np.std(many) < 0.8e-3, "of one reading it is 1e-3"


def test_the_first_command_is_where_the_hand_is() -> None:
    scenario = Lying()
    assert own_goal(scenario) == ()
    home = scenario.spec.hand.reduce(scenario.spec.home_hand())
    np.testing.assert_allclose(start_command(scenario.make_world(0)), home, atol=1e-9)


def test_a_planner_of_ones_own_makes_the_plans(dispenser_model: ic.InteractionModel) -> None:
    asked: list[tuple[ic.Goal, ic.Experience]] = []

    def wait(now: States, goal: ic.Goal, experience: ic.Experience) -> ic.Plan | ic.NoPlan:
        asked.append((goal, experience))
        return make_planner(dispenser_model).plan(now, goal, experience)

    builder = DiagramBuilder()
    world = ic.AddWorld(builder, WaterDispenser((), "ideal", 3))
    ic.AddController(builder, world, dispenser_model, ["cup.water >= 0.6"], planner=wait)
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(8.0)
    ((goal, experience),) = asked
    (condition,) = goal.conditions
    assert (condition.object, condition.variable) == ("cup", "water")
    assert condition.lower == pytest.approx(0.6, abs=0.02), "by which readings may be off"
    assert (experience.contradictions, experience.cautious) == ((), ())
