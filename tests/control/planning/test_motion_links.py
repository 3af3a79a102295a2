"""Demonstrated states as places of a motion: none much like another, told apart by what stays as it is."""

from types import SimpleNamespace

import numpy as np
from toy_models import tap
from winding import TURN, shade

from ichain_drake.control.planning.motion_links import _reach, run_on, thinned
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
