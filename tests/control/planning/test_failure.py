"""What is said where there is no plan: proved or not found, which interaction was missing, and by how much."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
from toy_models import LAMP_START, TAP_START, lamp, tap

from ichain_drake.control.planning.carries import find_carries
from ichain_drake.control.planning.failure import Nearest, Tried
from ichain_drake.control.planning.format import format_plan
from ichain_drake.control.planning.goals import parse_goal
from ichain_drake.control.planning.options import find_drives
from ichain_drake.control.planning.plan import Goal, Plan
from ichain_drake.control.planning.planner import GraphPlanner
from ichain_drake.graph import Interaction

PRESS, FALL = Interaction("robot", "tap"), Interaction("tank", "cup")


def nearest() -> Nearest:
    model = tap()
    drive = next(d for d in find_drives(model, find_carries(model)) if d.chain[-1] == FALL)
    found = Nearest(model, parse_goal(["cup.water >= 0.5"], model, TAP_START), TAP_START)
    found.note_blocked(drive, PRESS, -0.1)
    found.note_blocked(drive, FALL, -0.9)
    found.note_blocked(drive, FALL, -0.4)
    return found


def test_the_interaction_that_a_drive_lacked_is_named_with_its_nearest_decision_value() -> None:
    failure = nearest().failure(7, exhausted=True)
    assert failure.edge == FALL  # it came further along the chain than the one before
    assert failure.reason == (
        "cup.water >= 0.5 can't be met: 0.05 is the nearest that was predicted, as it is, in all 7 states that can be "
        "reached; tank->cup never became active on the way, its nearest decision value is -0.4"
    )


def test_an_interaction_is_not_said_to_be_missing_where_the_drive_began_from_another_state() -> None:
    found = nearest()
    drive = next(d for d in find_drives(found.model, find_carries(found.model)) if d.chain[-1] == FALL)
    found.note_tried(drive, 0.05, 0.9, None)
    assert found.failure(7, exhausted=True).reason.endswith("as it is, in all 7 states that can be reached")


def test_a_search_that_stopped_proves_nothing() -> None:
    assert "was not found to be met: 0.05 is the nearest" in nearest().failure(7, exhausted=False).reason
    assert "within 7 states" in nearest().failure(7, exhausted=False).reason


def test_chains_and_counts_are_written_as_they_are_said() -> None:
    model = tap()
    found = GraphPlanner(model).plan(TAP_START, parse_goal(["tank.water <= 0.5"], model, TAP_START))
    assert isinstance(found, Plan)
    text = format_plan(found, model.graph)
    assert text.startswith("1 step, ")
    assert "robot->tap->tank: " in text


def of(*goal: str, **more: Any) -> Nearest:
    model: Any = tap()
    return Nearest(model, replace(parse_goal(goal, model, TAP_START), **more), TAP_START)


def filled(x: float, water: float) -> dict[str, np.ndarray]:
    return {**TAP_START, "cup": np.array([x, water])}


def test_the_nearest_value_of_each_condition_is_kept_with_who_brought_it_there() -> None:
    found = of("cup.water >= 0.5", "cup.x >= 0.9")
    assert (found.nearest, found.closest, found.blame) == ([0.05, 0.2], [math.inf, math.inf], [None, None])
    found.note(filled(0.2, 0.05), (0, 1), None)
    np.testing.assert_allclose(found.closest, [0.45, 0.7])
    assert found.blame == [None, None]
    found.note(filled(0.5, 0.3), (0, 1), FALL)
    assert (found.nearest, found.blame) == ([0.3, 0.5], [FALL, FALL])
    found.note(filled(0.6, 0.2), (0, 1), PRESS)
    assert found.nearest == [0.3, 0.6], "each by itself"
    assert found.blame == [FALL, FALL], "what does not act on the object is not to blame"
    found.note(filled(0.6 + 1e-12, 0.3), (0, 1), Interaction("robot", "cup"))
    assert found.blame == [FALL, FALL], "what is no nearer changes nothing"
    best = filled(0.95, 0.1)
    found.note(best, (0,), None)
    found.note(filled(0.97, 0.1), (0,), None)
    assert found.best == (best, (0,)), "the first that leaves fewest"


def test_of_all_tries_of_a_drive_the_likeliest_and_the_furthest_are_kept() -> None:
    model: Any = tap()
    up = next(d for d in find_drives(model, find_carries(model)) if d.chain[-1] == FALL)
    down = replace(up, direction=-1)
    found = of("cup.water >= 0.5")
    key = (up.chain, up.variable, 1)
    found.note_tried(up, 0.2, 0.3, PRESS)
    assert found.tried == {key: Tried(1, 0.3, None, PRESS)}, "what never began came nowhere"
    found.note_tried(up, 0.4, 0.9, None)
    found.note_tried(up, 0.3, 0.5, None)
    assert found.tried[key] == Tried(3, 0.9, 0.4, None)
    found.note_tried(up, 0.1, 0.95, PRESS)
    assert found.tried[key] == Tried(4, 0.95, 0.4, PRESS)
    for end in (0.3, 0.1, 0.2):
        found.note_tried(down, end, 0.5, None)
    assert found.tried[(up.chain, up.variable, -1)] == Tried(3, 0.5, 0.1, None), "downwards the lowest is furthest"


def test_of_several_that_never_were_met_the_one_that_is_farthest_off_is_named() -> None:
    """As shares of what its places and contents ever were: 1.6 of 4 m are more than 0.1 of 1, but 0.4 of 4 are not."""
    found = of("cup.water >= 0.5", "cup.x >= 2.5")
    found.model.low["cup"], found.model.high["cup"] = np.zeros(2), np.array([4.0, 1.0])
    found.note(filled(0.9, 0.4), (0, 1), FALL)
    failure = found.failure(3, exhausted=True)
    assert (failure.condition.variable, failure.closest) == ("x", 0.9)
    nearer = of("cup.water >= 0.5", "cup.x >= 1.3")
    nearer.model.low["cup"], nearer.model.high["cup"] = np.zeros(2), np.array([4.0, 1.0])
    nearer.note(filled(0.9, 0.3), (0, 1), FALL)
    assert nearer.failure(3, exhausted=True).condition.variable == "water"


def test_where_each_was_met_alone_the_one_that_lacks_most_where_most_hold_is_named() -> None:
    found = of("cup.water >= 0.5", "cup.x <= 0.3", "tank.water >= 0.1")
    found.note(filled(1.0, 0.6), (1,), None)
    found.note(filled(0.2, 0.1), (0,), None)
    failure = found.failure(5, exhausted=True)
    assert failure.condition.variable == "x"
    assert (
        "can't be met together with the other conditions: it is 1 where most of them hold, in all 5" in failure.reason
    )
    assert "was not found to be met together" in found.failure(5, exhausted=False).reason
    assert failure.edge == Interaction("robot", "cup"), "nobody brought it nearer: the first that moves it"


def test_where_only_an_interaction_is_not_as_it_should_be_that_is_said() -> None:
    for wanted, more in (("inactive", {"inactive": (PRESS,)}), ("active", {"active": (FALL,)})):
        found = of("cup.water <= 0.5", **more)
        found.note(filled(0.2, 0.05), (), None)
        failure = found.failure(5, exhausted=True)
        edge = PRESS if wanted == "inactive" else FALL
        assert failure.edge == edge
        assert f"{edge.name} " in failure.reason and f"be made {wanted} together with the rest" in failure.reason
        assert failure.condition.variable == "water"
    model: Any = tap()
    bare = Nearest(model, Goal((), inactive=(PRESS,)), TAP_START)
    failure = bare.failure(1, exhausted=True)
    assert (failure.condition.object, failure.condition.variable, failure.edge) == ("tap", "level", PRESS)
    assert failure.closest == 0.0


def test_what_is_met_and_not_over_is_only_kept_so() -> None:
    found = of("cup.water <= 0.5")
    found.note(filled(0.2, 0.05), (), None)
    failure = found.failure(5, exhausted=True)
    assert (failure.edge, failure.closest) == (None, 0.05)
    assert failure.reason.endswith("holds only while something is kept hold of, in all 5 states that can be reached")


def test_what_blocked_a_drive_downwards_is_named_too() -> None:
    found = of("tank.water <= 0.2")
    model: Any = found.model
    down = next(d for d in find_drives(model, find_carries(model)) if d.chain[-1].child == "tank")
    found.note_blocked(down, PRESS, -0.3)
    failure = found.failure(4, exhausted=True)
    assert failure.edge == PRESS
    assert failure.reason.endswith("robot->tap never became active on the way, its nearest decision value is -0.3")
    up = of("tank.water >= 0.95")
    up.note_blocked(down, PRESS, -0.3)
    assert up.failure(4, exhausted=True).reason.endswith("in all 4 states that can be reached"), "that is another way"


def test_what_does_not_keep_its_value_is_said_to() -> None:
    model: Any = lamp()
    found = Nearest(model, parse_goal(["lamp.light >= 0.99"], model, LAMP_START), LAMP_START)
    assert found.failure(4, exhausted=True).reason.endswith("; it does not keep its value once it is let go")
    assert of("cup.x >= 9").failure(4, exhausted=True).reason.endswith("in all 4 states that can be reached")
