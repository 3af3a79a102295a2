"""Demonstrated states that motions are made of."""

from types import SimpleNamespace

import numpy as np
from toy_models import tap
from winding import TURN, shade

from ichain_drake.control.planning.motion_links import _reach, run_on, thinned
from ichain_drake.control.settings import PLANNING


def test_states_that_are_much_alike_are_kept_once() -> None:
    model = shade()
    rows = model.edges[TURN].examples.active
    shown = {n: v.copy() for n, v in rows.items()}
    for n in rows:
        rows[n] = np.concatenate([rows[n], rows[n] + 1e-6, rows[n][:40]])
    kept = thinned(model, TURN)
    assert len(kept["knob"]) == len(shown["knob"])
    places = [np.column_stack([v["robot"][:, 0], v["knob"]]) / 0.1 for v in (kept, shown)]  # in ticks' largest steps
    off = [np.abs(places[0][:, None] - other).max(axis=2) for other in places]
    assert off[1].min(axis=0).max() < PLANNING.alike, "each of them is like one that is kept"
    assert (off[0] + np.eye(len(kept["knob"]))).min() >= PLANNING.alike, "and no two that are kept are alike"
    for n in rows:
        rows[n] = shown[n] - [0.0, 1.0] if n == "robot" else shown[n]  # an open hand: it holds nothing in any of them
    assert {len(v) for v in thinned(model, TURN).values()} == {0}


def test_more_states_than_can_be_linked_are_spread_over_all_of_them() -> None:
    model = shade()
    rows, more = model.edges[TURN].examples.active, 3 * PLANNING.nodes
    angle = np.linspace(-30.0, 30.0, more)
    rows |= {"robot": np.column_stack([0.0 * angle, np.ones(more)]), "knob": angle[:, None], "shade": angle[:, None]}
    found = thinned(model, TURN)["knob"][:, 0]
    assert len(found) == PLANNING.nodes
    assert np.diff(np.sort(found)).max() < 5 * 60.0 / PLANNING.nodes


def test_states_are_told_apart_by_what_keeps_its_value_or_is_held() -> None:
    """Not by a hand that opens, nor by a change of something else."""
    model = tap()
    for obj, reach in (("robot", [0.1, np.inf]), ("tank", [0.1, np.inf]), ("cup", [0.1, 0.1]), ("tap", [0.1])):
        np.testing.assert_array_equal(_reach(model, obj), reach)
    model.noise["cup"][1] = 1.0
    assert _reach(model, "cup")[1] > 1.0  # no state is told from another by less than readings tell


def test_a_motion_is_followed_for_as_many_ticks_as_there_are() -> None:
    """To and fro between two states, and from a third by a new grasp to the first."""
    motion = SimpleNamespace(onward=np.array([1, 0, 0]), again=np.array([False, False, True]))
    gains, ticks = np.array([2.0, 0.5, 0.0]), PLANNING.retake + 3
    pairs, odd = divmod(ticks, 2)
    total = run_on(motion, gains, ticks)  # type: ignore[arg-type]
    np.testing.assert_allclose(total, [2.5 * pairs + 2.0 * odd, 2.5 * pairs + 0.5 * odd, 2.5 + 2.0])
