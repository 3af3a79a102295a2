"""What changes only while the robot moves is driven by a motion found in demonstrated states."""

import copy

import numpy as np
from toy_models import lamp, tap
from winding import GEAR, PUMP_START, SHADE_START, TURN, pump, shade

from ichain_drake.control.planning.carries import find_carries
from ichain_drake.control.planning.goals import parse_goal
from ichain_drake.control.planning.motion_drives import _context, find_motion_drives
from ichain_drake.control.planning.options import find_drives
from ichain_drake.control.planning.plan import Plan
from ichain_drake.control.planning.planner import GraphPlanner
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.state import Role, StateSpace, Variable


def motions(model):
    carries = find_carries(model)
    return find_motion_drives(model, carries, find_drives(model, carries))


def test_a_knob_winds_a_shade_either_way_and_nothing_does_with_the_robot_still() -> None:
    model = shade()
    assert find_drives(model, find_carries(model)) == ()
    found = [d for d in motions(model) if len(d.chain) == 2]
    assert sorted((d.chain[-1].name, d.variable, d.direction) for d in found) == [
        ("knob->shade", 0, -1),
        ("knob->shade", 0, 1),
    ]
    # A tick turns by .1 rad at most, and the wrist has to let go now and then.
    assert all(0.2 * GEAR * 0.1 < d.rate <= GEAR * 0.1 + 1e-9 for d in found)


def test_a_wrist_lets_go_at_its_end_and_takes_the_knob_again_at_the_other() -> None:
    up = next(d.motion for d in motions(shade()) if len(d.chain) == 2 and d.direction == 1)
    assert up is not None
    node = int(up.at(np.array([[1.0, 1.0]]), np.array([[-2.0]]))[0])
    assert up.again[node]
    taken = up.onward[node]
    assert up.robot[taken, 0] < -0.9
    np.testing.assert_allclose(up.child[taken], [-2.0], atol=0.05)
    best, reachable = up.grasp(np.array([[-2.0], [40.0]]))
    assert reachable.tolist() == [True, False]
    assert up.robot[best[0], 0] < -0.9  # the longest stroke lies ahead
    assert copy.deepcopy({"kept": up})["kept"] is up


def test_a_goal_many_turns_away_is_planned_and_ends_where_it_is_wanted() -> None:
    model = shade()
    found = GraphPlanner(model).plan(SHADE_START, parse_goal(["0.78 <= shade.height <= 0.82"], model, SHADE_START))
    assert isinstance(found, Plan)
    assert [s.chain[-1].name for s in found.steps] == ["knob->shade"]  # 5 rad, a wrist of 2
    step = found.steps[0]
    assert step.motion is not None
    assert step.until is not None
    assert step.until[:3] == ("shade", "height", 1)
    assert 0.78 <= step.predicted["shade"][0] <= 0.82
    assert step.ticks > 50 + 2 * 20  # two new grasps at least


def test_a_way_down_is_said_to_be_one() -> None:
    model = shade()
    found = GraphPlanner(model).plan(SHADE_START, parse_goal(["shade.height <= 0.2"], model, SHADE_START))
    assert isinstance(found, Plan)
    (step,) = found.steps
    assert step.until is not None
    assert step.until[:3] == ("shade", "height", -1)
    assert step.until[3] <= 0.2


def test_a_motion_is_looked_for_from_the_middle_of_what_it_drives() -> None:
    """Either way there is room for it; where no push of the robot moves anything there is none."""
    model = shade()
    chain = (TURN, Interaction("knob", "shade"))
    found = _context(model, chain, np.array([0]))
    assert found is not None
    assert abs(found["shade"][0] - 0.5) < 0.02
    np.testing.assert_allclose(found["shade"], 0.5 + GEAR * found["knob"])  # one of the samples
    assert _context(model, chain, np.array([], dtype=int)) is None
    model.noise["shade"] = np.ones(1)
    assert _context(model, chain, np.array([0])) is None


def test_a_pedal_pumps_to_and_fro_and_only_up() -> None:
    model = pump()
    found = [d for d in motions(model) if len(d.chain) == 2]
    assert [(d.chain[-1].name, d.direction) for d in found] == [("pedal->tank", 1)]
    plan = GraphPlanner(model).plan(PUMP_START, parse_goal(["tank.level >= 1.2"], model, PUMP_START))
    assert isinstance(plan, Plan)
    assert len(plan.steps) == 1  # some thirteen strokes of .3 m


def test_what_is_driven_by_holding_needs_no_motion() -> None:
    for model in (lamp(), tap()):
        assert motions(model) == ()


def test_a_place_is_changed_by_carrying_and_not_by_a_motion() -> None:
    """A knob that is turned further than a wrist goes is driven by motion; were its angle a place, it would not be."""
    model = shade()
    assert {d.direction for d in motions(model) if len(d.chain) == 1} == {-1, 1}
    place = StateSpace("knob", (Variable("angle", "m", role=Role("position", "room", "x")),))
    model.graph = InteractionGraph({**model.graph.objects, "knob": place}, model.graph.interactions)
    assert not [d for d in motions(model) if len(d.chain) == 1]
