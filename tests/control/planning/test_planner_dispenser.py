"""The water dispenser, learned from its own demonstrations on `ideal`: the order of the job is found, not written."""

import numpy as np
import pytest

from ichain_drake.control.planning.goals import gap, parse_goal, value_of
from ichain_drake.control.planning.plan import NoPlan, Plan, States
from ichain_drake.control.planning.planner import GraphPlanner
from ichain_drake.demonstrations import Demonstration
from ichain_drake.graph import Interaction
from ichain_drake.learning import InteractionModel, learn_interactions
from ichain_drake.systems.water_dispenser.scenario import WaterDispenser

pytestmark = pytest.mark.slow

GOAL = ["cup.water >= 0.6", "cup.temperature >= 0.9", "cup.x == start", "cup.y == start", "cup.z == start"]


@pytest.fixture(scope="module")
def model(dispenser_pieces: list[Demonstration]) -> InteractionModel:
    return learn_interactions(dispenser_pieces, WaterDispenser(physics="ideal", seed=0).graph)


@pytest.fixture(scope="module")
def start() -> States:
    scenario = WaterDispenser(physics="ideal", seed=0)
    begin = scenario.start(1)
    place = scenario.camera().from_robot(np.array([*begin.cup, 0.1]))
    return {
        "hand": np.array(begin.hand),
        "cup": np.array([*place, 0.0, begin.water, begin.temperature, 0.0]),
        "power": np.zeros(1),
        "dispense": np.zeros(1),
        "tank": np.array([begin.tank_amount, begin.tank_temperature, 0.0]),
    }


def test_a_cup_of_hot_water_is_poured_heated_dispensed_and_brought_back(model: InteractionModel, start: States) -> None:
    goal = parse_goal([*GOAL, "not hand->cup"], model, start)
    found = GraphPlanner(model).plan(start, goal)
    assert isinstance(found, Plan), found
    chains = [[e.name for e in s.chain] for s in found.steps]
    pour, heat = chains.index(["hand->cup", "cup->tank"]), chains.index(["hand->power", "power->tank"])
    dispense = next(k for k, c in enumerate(chains) if c[0] == "hand->dispense")
    assert max(pour, heat) < dispense < len(chains) - 1
    assert chains[-1] == ["hand->cup"]
    end = found.steps[-1].predicted
    assert all(gap(c, value_of(c, end, model.graph)) == 0 for c in goal.conditions)


def test_what_would_fall_is_held_in_the_end_as_it_was_held(model: InteractionModel, start: States) -> None:
    """Nobody ever let go of the cup in the air."""
    goal = parse_goal(["cup.z >= 0.3", "tank.temperature >= 0.5"], model, start)
    planner = GraphPlanner(model)
    found = planner.plan(start, goal)
    assert isinstance(found, Plan), found
    assert [s.release for s in found.steps] == [*[True] * (len(found.steps) - 1), False]
    end = found.steps[-1].predicted
    assert end["cup"][2] >= 0.3
    assert model.decide(Interaction("hand", "cup"), end) >= 0
    # From there: it is put down, for the hand is needed, and taken again; where it hung it can't be let go of.
    onward = planner.plan(end, parse_goal(["cup.z >= 0.3", "tank.temperature >= 0.9"], model, end))
    assert isinstance(onward, Plan), onward
    assert [s.release for s in onward.steps] == [*[True] * (len(onward.steps) - 1), False]
    refused = planner.plan(start, parse_goal(["cup.z >= 0.3", "not hand->cup"], model, start))
    assert isinstance(refused, NoPlan)


def test_more_water_than_there_is_and_colder_than_anything_are_refused(model: InteractionModel, start: States) -> None:
    planner = GraphPlanner(model)
    for text, edge in (("cup.water >= 0.95", "tank->cup"), ("cup.temperature <= 0.01", "tank->cup")):
        found = planner.plan(start, parse_goal([text], model, start))
        assert isinstance(found, NoPlan)
        assert found.edge is not None
        assert found.edge.name == edge


@pytest.mark.parametrize(("x", "planned"), [(0.79, True), (0.84, False)])
def test_a_cup_is_poured_from_where_the_hand_gets_to_it_alone(
    model: InteractionModel, start: States, x: float, planned: bool
) -> None:
    """The hand's bounds end at x = 0.8 m, wherever grasps were shown."""
    there = start["cup"].copy()
    there[:3] = WaterDispenser(physics="ideal", seed=0).camera().from_robot(np.array([x, -0.2, 0.1]))
    now = start | {"cup": there}
    found = GraphPlanner(model).plan(now, parse_goal(["tank.amount >= 0.3"], model, now))
    assert isinstance(found, Plan) == planned
    if isinstance(found, NoPlan):
        assert any("at best hand->cup was inactive" in line for line in found.tree)
