"""Drives by motion, predicted together: where the robot is in each step, when it lets go, and what it loses."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from winding import GEAR, TURN, shade

from ichain_drake.control.planning.carries import find_carries
from ichain_drake.control.planning.motion_drives import find_motion_drives
from ichain_drake.control.planning.motion_run import MotionRun
from ichain_drake.control.planning.options import find_drives
from ichain_drake.control.settings import PLANNING

PARKED = np.array([0.0, 0.0])


def made(*knobs: float, direction: int = 1) -> MotionRun:
    """Of a shade at its middle, with the knob somewhere else in each."""
    model: Any = shade()
    carries = find_carries(model)
    drives = find_motion_drives(model, carries, find_drives(model, carries))
    drive = next(d for d in drives if len(d.chain) == 2 and d.direction == direction)
    start = {"robot": PARKED, "shade": np.array([0.5])}
    return MotionRun(model, [({**start, "knob": np.array([k])}, drive) for k in knobs], PARKED)


def test_it_begins_with_the_knob_taken_where_most_of_a_stroke_is_left() -> None:
    run = made(-2.0, 1.0)
    np.testing.assert_allclose(run.first[:, 1], 1.0, err_msg="held")
    np.testing.assert_allclose(run.first[:, 0], [-1.0, 0.0], atol=0.11)
    np.testing.assert_array_equal(run.now["robot"], run.first)
    np.testing.assert_array_equal(run.hold, run.first)
    assert run.ramp.tolist() == [0, 0]
    assert run.lost == [None, None]
    assert not run.away.any()
    assert made(-2.0, 40.0).lost == [None, TURN], "where nobody ever had it, it can't be taken"


def test_each_step_goes_on_to_the_next_state_and_at_the_end_of_a_stroke_it_is_away_for_one() -> None:
    run = made(1.0)
    places, away, pauses = [run.first[0]], [], []
    knob = 1.0
    for step in range(40):
        robot = run.robot(step)[0]
        away.append(bool(run.away[0]))
        pauses.append(int(np.asarray(run.pauses())[0]))
        if not away[-1]:
            assert 0.0 < robot[0] - run.now["robot"][0, 0] <= 0.1 + 1e-9, "no further than a tick's step"
            knob += robot[0] - run.now["robot"][0, 0]
        run.now = {
            "robot": robot[None].copy(),
            "knob": np.array([[knob]]),
            "shade": np.array([[0.5 + GEAR * (knob - 1.0)]]),
        }
        places.append(robot)
    gone = away.index(True)
    np.testing.assert_array_equal(places[gone + 1], PARKED)
    assert places[gone][0] > 0.9, "as far as the wrist turns"
    assert places[gone + 2][0] < 0.0, "then it begins anew at the other end"
    assert not away[gone + 1]
    assert set(pauses) == {0, PLANNING.retake}
    assert [p > 0 for p in pauses[1:]] == away[:-1], "taking it anew takes its time, once each"


def test_it_is_looked_at_in_every_step_and_none_is_skipped() -> None:
    run = made(-2.0, 1.0)
    assert all(run.rechecks(k) for k in range(9))
    assert run.leap(run.now, run.now).tolist() == [1, 1]
    assert run.window == 2 * PLANNING.retake


@pytest.mark.parametrize(("direction", "way"), [(1, 1.0), (-1, -1.0)])
def test_a_drive_winds_on_and_on(direction: int, way: float) -> None:
    run = made(1.0, direction=direction)
    run.rows = [(s, replace(d, rate=GEAR * 0.1)) for s, d in run.rows]
    run.drive()
    heights = np.array([b["shade"][0, 0] for b in run.history])
    assert (np.diff(heights) * way >= -1e-12).all()
    assert heights[-1] * way > (0.5 * way) + 0.3, "further than a stroke"
    ticks = np.array([t[0] for t in run.ticks_at])
    jumps = np.diff(ticks)
    assert set(jumps[: int(run.last[0])].tolist()) == {1, 1 + PLANNING.retake}
