"""Probabilities and costs of plans, beside the same in plain words of statistics."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.stats import norm
from toy_models import TAP_START, tap

from ichain_drake.control.planning.plan import Condition, Goal, PlanStep
from ichain_drake.control.planning.risk import goal_probability, plan_cost, step_cost, success_probability
from ichain_drake.graph import Interaction

TAKE, FALL = Interaction("robot", "cup"), Interaction("tank", "cup")
STD = math.hypot(3e-3, 4e-3)


def model():
    toy = tap()
    toy.noise["cup"] = np.array([1e-4, 4e-3])
    toy.spread = lambda child, active: np.array([1e-4, 3e-3]) if FALL in active else np.zeros(2)
    return toy


def steps(water: float, *probabilities: float) -> list[PlanStep]:
    after = {**TAP_START, "cup": np.array([0.2, water])}
    return [PlanStep((FALL,), predicted=after, ticks=10 * (k + 1), probability=p) for k, p in enumerate(probabilities)]


@pytest.mark.parametrize("water", [0.39, 0.4, 0.405, 0.41, 0.45, 0.5, 0.51])
def test_a_condition_holds_by_its_margin(water: float) -> None:
    toy, goal = model(), Goal((Condition("cup", "water", 0.4, 0.5),))
    expected = norm.cdf((water - 0.4) / STD) * norm.cdf((0.5 - water) / STD)
    assert goal_probability(toy, goal, steps(water, 1.0)) == pytest.approx(expected)
    half = Goal((Condition("cup", "water", 0.4, math.inf),))
    assert goal_probability(toy, half, steps(water, 1.0)) == pytest.approx(norm.cdf((water - 0.4) / STD))
    both = Goal((*half.conditions, *goal.conditions))
    assert goal_probability(toy, both, steps(water, 1.0)) == pytest.approx(expected * norm.cdf((water - 0.4) / STD))


def test_what_no_step_changes_holds_as_it_did() -> None:
    goal = Goal((Condition("tank", "water", 0.9, 1.0),))
    assert goal_probability(model(), goal, steps(0.45, 1.0)) == 1.0
    assert goal_probability(model(), goal, []) == 1.0


def test_steps_are_independent_and_what_fails_is_tried_again() -> None:
    toy, goal, plan = model(), Goal((Condition("cup", "water", 0.4, math.inf),)), steps(0.405, 0.5, 0.8)
    holds = norm.cdf(0.005 / STD)
    assert success_probability(toy, goal, plan) == pytest.approx(0.75 * 0.96 * (1.0 - (1.0 - holds) ** 2))
    assert [step_cost(s) for s in plan] == pytest.approx([20.0, 25.0])
    assert plan_cost(toy, goal, plan) == pytest.approx(45.0 / holds)
    assert plan_cost(toy, goal, []) == 0.0


def test_nothing_is_impossible_to_a_cost() -> None:
    assert step_cost(steps(0.4, 0.0)[0]) == pytest.approx(1e4)
    goal = Goal((Condition("cup", "water", 0.9, math.inf),))
    assert plan_cost(model(), goal, steps(0.1, 1.0)) == pytest.approx(1e4)
