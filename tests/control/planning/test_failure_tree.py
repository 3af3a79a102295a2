"""Without a plan it is told for each condition what was tried; with one, how likely it is."""

import numpy as np
from toy_models import LAMP_START, TAP_START, lamp, tap

from ichain_drake.control.planning.failure import Nearest, Tried
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
    tried = [1.0 - (1.0 - s.probability) ** 2 for s in found.steps]
    assert found.probability <= np.prod(tried) + 1e-12, "steps work at the first or second try"
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


def test_only_drives_of_the_variable_in_the_direction_that_was_needed_are_told_likeliest_first():
    model = lamp()
    goal = parse_goal(["lamp.light >= 0.99"], model, LAMP_START)
    nearest = Nearest(model, goal, LAMP_START)
    light = model.graph.objects["lamp"].observable.index("light")
    chains = [(a, b) for b in model.graph.incoming("lamp") for a in model.graph.incoming(b.parent)]
    first, *_ = chains
    longer = (*first, first[-1])
    before = (first[0],)
    nearest.tried = {
        (first, light, 1): Tried(2, 0.25, 0.5, None),
        (longer, light, 1): Tried(3, 0.75, None, first[-1]),
        (first, light, -1): Tried(4, 0.9, 0.1, None),
        (before, 0, 1): Tried(5, 0.5, 0.3, None),
    }
    nearest.closest = [0.4]
    head, *lines = failure_tree(nearest)
    assert "never met" in head and head.endswith("0.4 short")
    way, lost = "->".join([first[0].parent, first[0].child, first[-1].child]), first[-1]
    assert lines == [
        f"  {way}->{lost.child}: tried 3 times, never began, probability at best 0.75; "
        f"at best {lost.name} was inactive",
        f"    {first[0].name}: tried 5 times, drove dimmer.x up to 0.3, probability at best 0.5",
        f"  {way}: tried 2 times, drove it to 0.5, probability at best 0.25",
        f"    {first[0].name}: tried 5 times, drove dimmer.x up to 0.3, probability at best 0.5",
    ]
    nearest.tried = {}
    assert failure_tree(nearest)[1:] == ("  nothing drives it up",)


def test_what_could_never_begin_is_told_beside_the_conditions_it_says_nothing_of():
    model = lamp()
    goal = parse_goal(["lamp.light >= 0.99"], model, LAMP_START)
    nearest = Nearest(model, goal, LAMP_START)
    light = model.graph.objects["lamp"].observable.index("light")
    to_lamp = model.graph.incoming("lamp")[0]
    first, beside = model.graph.incoming(to_lamp.parent)[0], Interaction("robot", "lamp")
    nearest.tried = {
        ((first, to_lamp), light, 1): Tried(1, 0.9, 0.5, None),
        ((beside,), light, -1): Tried(2, 0.01, None, beside),
        ((first,), 0, -1): Tried(2, 0.8, 0.1, None),
    }
    nearest.closest = [0.4]
    assert failure_tree(nearest)[-3:] == (
        f"    {first.name}: tried 2 times, drove dimmer.x down to 0.1, probability at best 0.8",
        "beside these never began:",
        f"  {beside.name}: tried 2 times, never began, probability at best 0.01; at best {beside.name} was inactive",
    )
    nearest.closest = [0.0]
    assert len(failure_tree(nearest)) == 3, "what is met needs nothing, but is told of all that could not begin"
