"""A plan as text, word for word."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from toy_models import TAP_START, tap

from ichain_drake.control.planning.format import format_plan
from ichain_drake.control.planning.plan import Condition, NoPlan, Plan, PlanStep
from ichain_drake.graph import Interaction

GRAPH = tap().graph
TAKE, PRESS, RUN, FALL = (Interaction.parse(e) for e in ("robot->cup", "robot->tap", "tap->tank", "tank->cup"))
PLACED = {**TAP_START, "robot": np.array([2.0, 0.0]), "cup": np.array([1.0, 0.0549])}
FULL = {**PLACED, "tank": np.array([0.5, -0.02]), "cup": np.array([1.0051, 0.35])}


def test_each_step_says_what_is_brought_where_and_what_changes() -> None:
    """Changes of less than a two-hundredth, of the value or of 1, are left out, and the robot's own."""
    carry = PlanStep((TAKE,), {("cup", "x"): 1.0}, predicted=PLACED, ticks=6, probability=0.75)
    until = ("cup", "water", 1, 0.35)
    drive = PlanStep((PRESS, RUN, FALL), {("cup", "water"): 0.35}, until, predicted=FULL, ticks=9, release=False)
    plan = Plan((carry, drive), 15, 3, 40, probability=0.7, cost=18.4)
    text = format_plan(plan, GRAPH, TAP_START)
    assert text.splitlines() == [
        "2 steps, about 15 ticks (5 s), success 0.70, cost 18 ticks; 3 states expanded, 40 options simulated",
        "1. robot->cup: carry it to x 1 m; let go",
        "   6 ticks, until 2 s: cup.x 0.2 -> 1 m",
        "2. robot->tap->tank->cup: raise cup.water to 0.35",
        "   9 ticks, until 5 s: tank.water 0.8 -> 0.5, tank.change 0 -> -0.02, cup.x 1 -> 1.01 m, "
        "cup.water 0.0549 -> 0.35",
    ]
    likely = format_plan(plan, GRAPH, likely=True).splitlines()
    assert likely[1].endswith("let go (probability 0.750 a try)")
    assert likely[2] == "   6 ticks, until 2 s", "nothing is known of the start"
    held = format_plan(Plan((replace(carry, release=False),), 6), GRAPH).splitlines()
    assert held[1] == "1. robot->cup: carry it to x 1 m; hold it"
    one = format_plan(Plan((carry,), 6, optimal=True), GRAPH)
    assert one.startswith("1 step, about 6 ticks (2 s), success 1.00, cost 0 ticks (none is cheaper); 0 states")


def test_a_carried_thing_that_drives_is_brought_turned_and_put() -> None:
    x, water = ("cup", "x"), ("cup", "water")
    step = PlanStep((TAKE, FALL), {x: 0.9, water: 0.2}, ("cup", "water", -1, 0.2), before={x: 0.5}, after={x: 0.1})
    assert format_plan(Plan((step,), 0), GRAPH).splitlines()[1] == (
        "1. robot->cup->cup: carry cup to x 0.5 m; turn it to x 0.9 m; lower cup.water to 0.2; put it at x 0.1 m; "
        "let go"
    )
    same = PlanStep((TAKE,), {x: 0.5}, before={x: 0.5}, after={x: 0.5})
    assert format_plan(Plan((same,), 0), GRAPH).splitlines()[1] == "1. robot->cup: turn it to x 0.5 m; let go"


def test_no_plan_says_where_and_why() -> None:
    c = Condition("cup", "x", 0.0, 1.0)
    assert format_plan(NoPlan(c, 0.0, FALL, "too far"), GRAPH) == "no plan (at tank->cup): too far"
    assert format_plan(NoPlan(c, 0.0, None, "too far"), GRAPH) == "no plan: too far"


def test_of_what_nothing_was_predicted_or_is_known_no_change_is_written() -> None:
    step = PlanStep((TAKE,), {("cup", "x"): 1.0}, predicted={"cup": PLACED["cup"]}, ticks=6)
    for start, change in ((TAP_START, ": cup.x 0.2 -> 1 m"), ({"tank": TAP_START["tank"]}, "")):
        assert format_plan(Plan((step,), 6), GRAPH, start).splitlines()[2] == f"   6 ticks, until 2 s{change}"
