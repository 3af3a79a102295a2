"""Demonstrated states as places of a motion: none much like another, told apart by what stays as it is."""

from types import SimpleNamespace

import numpy as np
import pytest
from toy_models import tap
from winding import TURN, shade

from ichain_drake.control.planning.motion_links import Links, _reach, best_motion, link, run_on, thinned
from ichain_drake.control.settings import PLANNING


def test_states_that_are_much_alike_are_thinned_and_none_is_without_a_neighbour() -> None:
    model = shade()
    for limit in model.step_limit.values():
        limit[:] = 0.4
    every, kept = model.edges[TURN].examples.active, thinned(model, TURN)
    places = [np.hstack([batch["robot"][:, :1], batch["knob"]]) for batch in (every, kept)]
    assert 10 < len(places[1]) < len(places[0])
    away = np.abs(places[0][:, None] - places[1]).max(axis=2) / model.step_limit["knob"][0]
    assert (away.min(axis=1) < PLANNING.alike + 1e-9).all(), "whatever was left out is near one that was kept"
    between = np.abs(places[1][:, None] - places[1]).max(axis=2) / model.step_limit["knob"][0]
    assert (between[~np.eye(len(between), dtype=bool)] >= PLANNING.alike - 1e-9).all()


def test_an_interaction_that_is_active_in_no_sample_has_no_states() -> None:
    model = shade()
    model.gates[TURN] = lambda s: np.full(len(s["robot"]), -1.0)
    assert len(thinned(model, TURN)["knob"]) == 0


def test_changes_and_what_jumps_tell_no_states_apart() -> None:
    model = tap()
    np.testing.assert_allclose(_reach(model, "tank"), [0.1, np.inf])
    np.testing.assert_allclose(_reach(model, "robot"), [0.1, np.inf])
    np.testing.assert_allclose(_reach(model, "tap"), [0.1])
    model.step_limit["tank"][0] = 0.0
    np.testing.assert_allclose(_reach(model, "tank"), [4e-4, np.inf])


def test_more_states_than_can_be_linked_are_spread_over_all_of_them() -> None:
    model = shade()
    rows, more = model.edges[TURN].examples.active, 3 * PLANNING.nodes
    angle = np.linspace(-30.0, 30.0, more)
    rows |= {"robot": np.column_stack([0.0 * angle, np.ones(more)]), "knob": angle[:, None], "shade": angle[:, None]}
    found = thinned(model, TURN)["knob"][:, 0]
    assert len(found) == PLANNING.nodes
    assert np.diff(np.sort(found)).max() < 5 * 60.0 / PLANNING.nodes


def test_a_motion_is_followed_for_as_many_ticks_as_there_are() -> None:
    """To and fro between two states, and from a third by a new grasp to the first."""
    motion = SimpleNamespace(onward=np.array([1, 0, 0]), again=np.array([False, False, True]))
    gains, ticks = np.array([2.0, 0.5, 0.0]), PLANNING.retake + 3
    pairs, odd = divmod(ticks, 2)
    total = run_on(motion, gains, ticks)  # type: ignore[arg-type]
    np.testing.assert_allclose(total, [2.5 * pairs + 2.0 * odd, 2.5 * pairs + 0.5 * odd, 2.5 + 2.0])


def test_a_tick_links_states_whose_object_it_brings_near_enough_to_where_the_other_has_it() -> None:
    """A knob that goes along with the robot as it turns: of two states alike but for the robot neither leads on."""
    model = shade()
    angles = np.array([0.0, 0.08, 0.16, 0.08, 1.0])  # the fourth with the knob elsewhere
    knobs = np.array([0.0, 0.08, 0.16, 0.5, 1.0])
    states = {
        "robot": np.column_stack([angles, np.ones(5)]),
        "knob": knobs[:, None],
        "shade": 0.5 + 0.1 * knobs[:, None],
    }
    found = link(model, TURN, states, np.array([0.0, 0.0]))
    assert list(zip(found.start.tolist(), found.end.tolist(), strict=True)) == [(0, 1), (1, 0), (1, 2), (2, 1)]
    np.testing.assert_allclose(found.change["knob"][:, 0], [0.08, -0.08, 0.08, -0.08], atol=1e-12)
    np.testing.assert_allclose(found.change["shade"][:, 0], [0.008, -0.008, 0.008, -0.008], atol=1e-12)
    assert not found.retake.any(), "let go of, the knob stays where it is, and no other state has it there"
    np.testing.assert_allclose(found.reach[0], [0.1, np.inf])


def test_what_is_let_go_of_is_taken_anew_wherever_it_is_shown_to_come_to() -> None:
    model = shade()
    knobs = np.array([0.3, 0.3 + 0.9 * PLANNING.meets * 0.1, 0.3 + 2.1 * PLANNING.meets * 0.1])
    states = {
        "robot": np.array([[-1.0, 1.0], [0.0, 1.0], [1.0, 1.0]]),
        "knob": knobs[:, None],
        "shade": np.full((3, 1), 0.5),
    }
    found = link(model, TURN, states, np.array([0.0, 0.0]))
    assert not len(found.start), "too far for a tick"
    assert found.retake.tolist() == [[False, True, False], [True, False, False], [False, False, False]]
    model.passive["knob"].variables[0].kind = "constant"  # it goes back to 0 at once
    found = link(model, TURN, states | {"knob": np.array([[0.5], [0.0], [0.9]])}, np.array([0.0, 0.0]))
    assert found.retake.tolist() == [[False, True, False], [False, False, False], [False, True, False]]


def chained(retake: int | None) -> Links:
    """Four states in a row, a tick from each to the next, which raises a thing by 1; from the last back by a grasp."""
    states = {"robot": np.arange(4.0)[:, None], "knob": np.arange(4.0)[:, None], "shade": np.zeros((4, 1))}
    again = np.zeros((4, 4), dtype=bool)
    if retake is not None:
        again[3, retake] = True
    change = {"shade": np.ones((3, 1)), "knob": np.ones((3, 1))}
    return Links(TURN, states, np.arange(3), np.arange(1, 4), change, again, (np.ones(1), np.ones(1)))


def test_a_motion_goes_round_where_that_goes_on_longest_and_rests_where_nothing_is_gained() -> None:
    model, d, later = shade(), PLANNING.discount, PLANNING.discount**PLANNING.retake
    motion, gains = best_motion(model, chained(0), "shade", 0, 1)  # type: ignore[arg-type]
    assert motion.onward.tolist() == [1, 2, 3, 0]
    assert motion.again.tolist() == [False, False, False, True]
    assert gains.tolist() == [1.0, 1.0, 1.0, 0.0]
    whole = (1 + d + d**2) / (1 - d**3 * later)
    np.testing.assert_allclose(
        motion.value, [whole, 1 + d + d**2 * later * d * whole / d, 1 + d * later * whole, later * whole], rtol=1e-3
    )
    ends, gains = best_motion(model, chained(None), "shade", 0, 1)  # type: ignore[arg-type]
    assert ends.onward.tolist() == [1, 2, 3, 3]
    assert not ends.again.any()
    assert gains.tolist() == [1.0, 1.0, 1.0, 0.0]
    np.testing.assert_allclose(ends.value, [1 + d + d**2, 1 + d, 1.0, 0.0])
    still, gains = best_motion(model, chained(0), "shade", 0, -1)  # type: ignore[arg-type]
    assert still.onward.tolist() == [0, 1, 2, 3], "the other way nothing is gained"
    assert not gains.any()
    assert (still.edge, still.wraps.tolist()) == (TURN, [False])
    np.testing.assert_array_equal(still.child, chained(0).states["knob"])
    np.testing.assert_array_equal(still.robot, chained(0).states["robot"])


@pytest.mark.parametrize(("robot", "knob", "links"), [(0.2, 0.1, 6), (0.1, 0.2, 4)])
def test_how_far_a_tick_leads_is_by_how_far_the_robot_goes(robot: float, knob: float, links: int) -> None:
    """Three places, 0.08 from each other."""
    model = shade()
    model.step_limit["robot"][0], model.step_limit["knob"][0] = robot, knob
    angles = np.array([0.0, 0.08, 0.16])
    states = {
        "robot": np.column_stack([angles, np.ones(3)]), "knob": angles[:, None], "shade": 0.5 + 0.1 * angles[:, None],
    }  # fmt: skip
    assert len(link(model, TURN, states, np.array([0.0, 0.0])).start) == links


def test_what_changes_by_another_one_tells_no_states_apart_whatever_it_is_called() -> None:
    model = tap()
    np.testing.assert_allclose(_reach(model, "cup"), [0.1, 0.1])
    model.passive["cup"].variables[1].kind = "change"
    np.testing.assert_allclose(_reach(model, "cup"), [0.1, np.inf])
