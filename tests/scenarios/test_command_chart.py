"""Hand commands in coordinates: round a circle, never across it or the shorter, wrong way."""

from __future__ import annotations

import numpy as np

from ichain_drake.objects import WheelMount
from ichain_drake.scenarios.command_chart import CommandChart
from ichain_drake.timing import FRAMES_PER_TICK

MOUNT = WheelMount()
CHART = CommandChart(MOUNT.knob_from_wheel, MOUNT.wheel_from_knob)


def test_frames_go_round_and_arrive() -> None:
    start, goal = np.array([0.3, 0.0]), np.array([0.7, 0.01])
    frames = MOUNT.wheel_from_knob(CHART.frames(MOUNT.knob_from_wheel(start), MOUNT.knob_from_wheel(goal)))
    assert frames.shape == (FRAMES_PER_TICK, 2)
    np.testing.assert_allclose(frames[:4], start + np.arange(1, 5)[:, None] / 4 * (goal - start), atol=1e-12)
    np.testing.assert_allclose(frames[4:], np.tile(goal, (6, 1)), atol=1e-12)


def test_what_is_far_is_approached_the_right_way_round() -> None:
    start, goal = np.array([[-2.0, 0.0], [-2.0, 0.0]]), np.array([[2.0, 0.0], [-1.5, 0.0]])
    command = MOUNT.wheel_from_knob(CHART.within_tick(MOUNT.knob_from_wheel(start), goal))
    assert -2.0 < command[0, 0] < -0.7  # towards +2, by as much as a hand moves in a tick
    np.testing.assert_allclose(command[1], goal[1], atol=1e-12)
