"""The cheapest plan: never dearer than the fast planner's, found where that one is dearer, and said to be proved."""

from dataclasses import replace

import numpy as np
import pytest
from toy_models import LAMP_START, TAP_START, ToyModel, lamp, tap

from ichain_drake.control.planning.goals import parse_goal
from ichain_drake.control.planning.optimal import OptimalSearch
from ichain_drake.control.planning.plan import NoPlan, Plan, PlanStep, States
from ichain_drake.control.planning.planner import GraphPlanner, SearchSettings
from ichain_drake.control.planning.risk import plan_cost, step_cost, success_probability
from ichain_drake.control.planning.search import Search
from ichain_drake.control.planning.search_node import SearchNode
from ichain_drake.errors import InputError
from ichain_drake.learning import InteractionModel
from ichain_drake.simulation.wiring import look, make_planner
from ichain_drake.systems.water_dispenser.scenario import WaterDispenser

GOALS = [
    (tap(), TAP_START, ["cup.water >= 0.5", "cup.x == start", "not robot->cup"]),
    (tap(), TAP_START, ["0.3 <= cup.water <= 0.4"]),
    (lamp(), LAMP_START, ["0.55 <= lamp.light <= 0.65"]),
]


@pytest.mark.parametrize(("model", "start", "texts"), GOALS)
def test_it_costs_no_more_and_says_that_none_is_cheaper(model: ToyModel, start: States, texts: list[str]) -> None:
    goal = parse_goal(texts, model, start)
    fast, best = (GraphPlanner(model, SearchSettings(optimal=o)).plan(start, goal) for o in (False, True))
    assert isinstance(fast, Plan)
    assert isinstance(best, Plan)
    assert best.cost <= fast.cost + 1e-9
    assert best.optimal
    assert not fast.optimal
    assert best.cost == pytest.approx(plan_cost(model, goal, best.steps))


def test_a_detour_is_found_to_be_one(monkeypatch: pytest.MonkeyPatch) -> None:
    """With a first plan that carries the cup away and back before it does anything, a cheaper one is looked for."""
    model, start = tap(), TAP_START
    goal = parse_goal(["cup.water >= 0.5"], model, start)
    planner = GraphPlanner(model, SearchSettings(optimal=True))
    best = planner.plan(start, goal)
    assert isinstance(best, Plan)
    real = Search.run

    def with_detour(search: Search) -> SearchNode | NoPlan:
        found = real(search)
        if isinstance(search, OptimalSearch) or isinstance(found, NoPlan):
            return found
        return replace(found, steps=(found.steps[0], found.steps[0], *found.steps), ticks=3 * found.ticks)

    monkeypatch.setattr(Search, "run", with_detour)
    again = planner.plan(start, goal)
    assert isinstance(again, Plan)
    assert [s.chain for s in again.steps] == [s.chain for s in best.steps]
    assert again.cost == pytest.approx(best.cost)
    fast = GraphPlanner(model).plan(start, goal)
    assert isinstance(fast, Plan)
    assert fast.cost > best.cost


def test_a_goal_about_no_interaction_may_have_nothing_cheaper(dispenser_model: InteractionModel) -> None:
    world = WaterDispenser((), "ideal", 3).make_world(0)
    start = look(world)
    for text in ("cup.water <= 0.5", "tank.amount >= 0.5"):
        goal = parse_goal([text], dispenser_model, start)
        found = make_planner(dispenser_model, "optimal").plan(start, goal)
        assert isinstance(found, Plan)
        assert found.optimal


def test_out_of_breath_it_keeps_the_plan_and_claims_nothing() -> None:
    model, start = tap(), TAP_START
    goal = parse_goal(["cup.water >= 0.5", "cup.x == start"], model, start)
    found = GraphPlanner(model, SearchSettings(optimal=True, most=0)).plan(start, goal)
    assert isinstance(found, Plan)
    assert not found.optimal


def test_what_can_not_be_reached_is_refused_as_by_the_fast_one() -> None:
    model, start = tap(), TAP_START
    found = make_planner(model, "optimal").plan(start, parse_goal(["cup.water <= 0.01"], model, start))
    assert isinstance(found, NoPlan)
    assert found.edge is not None
    assert found.edge.name == "tank->cup"


def test_risk_is_paid_in_time() -> None:
    """An option that works every other time takes two tries in the mean."""
    step = PlanStep((tap().graph.interactions[0],), predicted=TAP_START, ticks=30, probability=0.5)
    assert step_cost(step) == 60
    assert np.isfinite(step_cost(replace(step, probability=0.0)))
    model = tap()
    goal = parse_goal(["cup.x <= 0.5"], model, TAP_START)
    sure = replace(step, probability=1.0)
    assert plan_cost(model, goal, [sure, sure]) == pytest.approx(60 / success_probability(model, goal, [sure, sure]))


def test_another_name_is_refused() -> None:
    with pytest.raises(InputError, match="planner: 'quick' is none; give fast or optimal, or a function"):
        make_planner(tap(), "quick")
