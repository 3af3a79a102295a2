"""Without a plan it is told for each condition what was tried; with one, how likely it is."""

import numpy as np
from toy_models import LAMP_START, TAP_START, lamp, tap

from ichain_drake.control.planning.format import format_plan
from ichain_drake.control.planning.goals import parse_goal
from ichain_drake.control.planning.plan import NoPlan, Plan
from ichain_drake.control.planning.planner import GraphPlanner


def test_a_plan_says_how_likely_it_is():
    model = tap()
    goal = parse_goal(["cup.water >= 0.3"], model, TAP_START)
    found = GraphPlanner(model).plan(TAP_START, goal)
    assert isinstance(found, Plan)
    assert 0.5 < found.probability < 1.0
    assert found.probability <= np.prod([s.probability for s in found.steps]) + 1e-12
    text = format_plan(found, model.graph, likely=True)
    assert f"success {found.probability:.2f}" in text
    assert text.count("(probability ") == len(found.steps)


def test_what_was_tried_for_a_condition_that_is_never_met():
    model = lamp()
    goal = parse_goal(["lamp.light >= 0.99"], model, LAMP_START)
    found = GraphPlanner(model).plan(LAMP_START, goal)
    assert isinstance(found, NoPlan)
    assert found.tree[0].startswith("lamp.light >= 0.99: never met, nearest ")
    assert all(line.startswith("  ") for line in found.tree[1:])
    assert "short" in found.tree[0]
