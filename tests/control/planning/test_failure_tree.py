"""Without a plan it is told for each condition what was tried; with one, how likely it is."""

from types import SimpleNamespace

import numpy as np
import pytest
from toy_models import LAMP_START, TAP_START, lamp, tap

from ichain_drake.control.planning.failure import Nearest
from ichain_drake.control.planning.failure_tree import failure_tree
from ichain_drake.control.planning.format import format_plan
from ichain_drake.control.planning.goals import parse_goal
from ichain_drake.control.planning.plan import NoPlan, Plan
from ichain_drake.control.planning.planner import GraphPlanner
from ichain_drake.graph import Interaction


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


SWITCH, DIM, LIT, ON = (
    Interaction.parse(t) for t in ("robot->switch", "robot->dimmer", "dimmer->lamp", "switch->lamp")
)


@pytest.mark.parametrize(
    ("text", "up", "near"), [("0.9 <= lamp.light <= 1", True, 0.6), ("lamp.light <= -0.5", False, 0)]
)
def test_the_tree_has_what_was_tried_in_the_direction_that_was_missing_and_what_it_waited_for(text, up, near):
    nearest = Nearest(lamp(), parse_goal([text], lamp(), LAMP_START), LAMP_START)

    def tried(chain, direction, end, probability, lost=None):
        nearest.note_tried(SimpleNamespace(chain=chain, variable=0, direction=direction), end, probability, lost)

    tried((DIM, LIT), 1, 0.4, 0.7)
    tried((DIM, LIT), 1, 0.6, 0.5)
    tried((SWITCH, ON), 1, 0.1, 0.9, ON)
    tried((SWITCH,), 1, 0.3, 0.25)
    tried((DIM, LIT), -1, 0.2, 0.8)
    nearest.note({**LAMP_START, "lamp": np.array([near])}, (0,), LIT)
    head, *rest = failure_tree(nearest)
    assert head.endswith(f": never met, nearest {near:g}, {0.3 if up else 0.5:g} short")
    assert rest == (
        [
            "  robot->switch->lamp: tried 1 times, never began, probability at best 0.9; "
            "at best switch->lamp was inactive",
            "    robot->switch: tried 1 times, drove it to 0.3, probability at best 0.25",
            "  robot->dimmer->lamp: tried 2 times, drove it to 0.6, probability at best 0.7",
        ]
        if up
        else ["  robot->dimmer->lamp: tried 1 times, drove it to 0.2, probability at best 0.8"]
    )


def test_a_condition_that_holds_or_that_nothing_drives_says_so():
    goal = parse_goal(["dimmer.x <= 0.35", "lamp.light >= 0.5"], lamp(), LAMP_START)
    nearest = Nearest(lamp(), goal, LAMP_START)
    nearest.note(LAMP_START, (1,), None)
    assert failure_tree(nearest) == (
        "dimmer.x <= 0.35 m: met by itself, nearest 0.3",
        "lamp.light >= 0.5: never met, nearest 0, 0.5 short",
        "  nothing drives it up",
    )
