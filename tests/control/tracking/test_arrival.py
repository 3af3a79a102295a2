"""What counts as having followed a path to its end."""

import numpy as np
import pytest

from ichain_drake.control.tracking.arrival import Arrival
from ichain_drake.control.tracking.path import PathLimits, TimedPath

LIMITS = PathLimits(speed=45.0, tolerance=3.0, corridor=10.0)
LINE = TimedPath(np.array([[0.0, 0.0], [300.0, 0.0]]), LIMITS)
A = np.linspace(0.0, 2 * np.pi, 200)
CIRCLE = TimedPath(20.0 * np.stack([np.cos(A), np.sin(A)], axis=1), LIMITS)


def run(path: TimedPath, executed: np.ndarray, frames: int = 10) -> Arrival:
    """Ticks of ten frames, as an episode shows them."""
    arrival, progress = Arrival(path), 0
    for start in range(0, len(executed) - frames, frames):
        seen = executed[start : start + frames + 1]
        progress = path.advance(seen[-1], progress, 4 / 3)
        arrival.see(seen, path, progress)
        if arrival.arrived or arrival.past:
            break
    return arrival


def along(offset: float, until: float = 320.0) -> np.ndarray:
    x = np.arange(0.0, until, 1.5)
    return np.stack([x, np.full(len(x), offset)], axis=1)


def test_a_run_along_the_path_arrives_though_no_tick_ends_at_its_end() -> None:
    arrival = run(LINE, along(1.0))
    assert arrival.arrived
    assert arrival.reason("px", 7.0) == ""


@pytest.mark.parametrize(
    ("path", "executed", "reason"),
    [
        (LINE, along(8.0), "came no nearer to the end than 8"),
        (LINE, along(1.0, until=250.0), "left the path or stood still after 7.0 s"),
        # Standing at the middle of a circle is as near to one of its points as to any other.
        (CIRCLE, np.tile([20.0, 0.0], (200, 1)) * 0.9, "left the path"),
        # Straight across: the end is where it starts.
        (CIRCLE, np.stack([20.0 - np.abs(np.linspace(0, 38, 400) - 19), np.zeros(400)], axis=1), "left the path"),
    ],
)
def test_what_does_not_count_says_why(path: TimedPath, executed: np.ndarray, reason: str) -> None:
    arrival = run(path, executed)
    assert not arrival.arrived
    assert reason in arrival.reason("px", 7.0)


def test_a_corner_cut_by_more_than_the_corridor_does_not_count() -> None:
    corner = TimedPath(np.array([[0.0, 0.0], [100.0, 0.0], [100.0, 100.0]]), LIMITS)
    straight = np.linspace([0.0, 0.0], [100.0, 100.0], 120)
    arrival = Arrival(corner)
    for k in range(12):
        arrival.see(straight[10 * k : 10 * k + 11], corner, min(len(corner.points) - 1, 20 * (k + 1)))
    assert "left the path by" in arrival.reason("px", 1.0)
    near = np.concatenate([np.linspace([0, 0], [95, 0], 70), np.linspace([95, 0], [100, 8], 8),
                           np.linspace([100, 8], [100, 130], 90)])  # fmt: skip
    assert run(corner, near).arrived


def test_a_run_is_over_once_the_end_lies_behind() -> None:
    arrival = run(LINE, along(8.0, until=400.0))
    assert arrival.past


def test_where_a_path_crosses_itself_a_later_branch_is_no_substitute() -> None:
    """A loop of radius 60 that is skipped: what comes after it passes the crossing only."""
    a = np.linspace(-np.pi / 2, 1.5 * np.pi, 300)
    loop = np.stack([150 + 60 * np.cos(a), 60 + 60 * np.sin(a)], axis=1)
    path = TimedPath(np.concatenate([[[0.0, 0.0]], loop, [[300.0, 0.0]]]), LIMITS)
    arrival, executed = Arrival(path), along(0.0)
    for k, start in enumerate(range(0, len(executed) - 10, 10)):
        arrival.see(executed[start : start + 11], path, min(len(path.points) - 1, 40 * k))
    assert not arrival.arrived


def test_who_comes_nearer_is_not_past_yet() -> None:
    arrival, last = Arrival(LINE), len(LINE.points) - 1
    arrival.see(np.array([[280.0, 8.0], [290.0, 8.0], [299.0, 8.0]]), LINE, last)
    assert not arrival.past, "it is nowhere nearer to the end than now"
    arrival.see(np.array([[299.0, 8.0], [300.0, 8.0], [304.0, 8.0]]), LINE, last)
    assert arrival.past
    assert "no nearer to the end than 8 px; 3 px count" in arrival.reason("px", 1.0)
