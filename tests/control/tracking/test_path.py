"""Paths: reading, sampling, timing, progress, and the two error measures against brute force."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ichain_drake.control.tracking.path import (
    PathLimits,
    TimedPath,
    _mean_curvature,
    check_points,
    paper_path_error,
    path_error,
    read_path,
    resample,
)
from ichain_drake.errors import InputError

LIMITS = PathLimits(speed=45.0, turn_rate=1.1, spacing=1.0, smoothing=40.0, tolerance=3.0)
LINE = np.array([[0.0, 0.0], [300.0, 0.0]])


def circle(radius: float, turns: float = 1.0) -> np.ndarray:
    t = np.linspace(0, 2 * np.pi * turns, 3000)
    return radius * np.stack([np.cos(t), np.sin(t)], axis=1)


polylines = st.integers(0, 10**6).map(lambda seed: np.random.default_rng(seed).uniform(0, 100, (6, 2)))


@given(points=polylines, spacing=st.floats(0.5, 20.0))
def test_resampled_points_are_equally_far_apart_along_the_polyline(points: np.ndarray, spacing: float) -> None:
    sampled = resample(points, spacing)
    np.testing.assert_array_equal(sampled[[0, -1]], points[[0, -1]])
    length = np.linalg.norm(np.diff(points, axis=0), axis=1).sum()
    step = length / (len(sampled) - 1)
    assert step <= spacing < step * (1 + 1.5 / (len(sampled) - 1)) + spacing / len(sampled)
    # Never further apart than along the polyline, and all on it.
    assert np.linalg.norm(np.diff(sampled, axis=0), axis=1).max() <= step + 1e-9
    starts, ways = points[:-1], np.diff(points, axis=0)
    along = np.clip(((sampled[:, None] - starts) * ways).sum(-1) / (ways**2).sum(-1), 0, 1)
    assert np.linalg.norm(sampled[:, None] - starts - along[..., None] * ways, axis=-1).min(axis=1).max() < 1e-6


def test_the_shortest_path_is_straight() -> None:
    path = TimedPath(np.array([[0, 0], [0.1, 0]]), LIMITS)
    assert path.curvature.tolist() == [0, 0]
    assert path.time[-1] == pytest.approx(0.1 / 45)


def test_resampling_drops_doubled_points_and_keeps_short_paths() -> None:
    np.testing.assert_allclose(resample(np.array([[0, 0], [0, 0], [2, 0], [2, 0], [4.0, 0]]), 1.0)[:, 0], range(5))
    assert len(resample(np.array([[0, 0], [0.1, 0]]), 1.0)) == 2


@pytest.mark.parametrize("radius", [30.0, 100.0])
def test_curvature_and_speed_of_a_circle(radius: float) -> None:
    """Everywhere, the ends included, where there are fewer neighbours to average over."""
    path = TimedPath(circle(radius), LIMITS)
    np.testing.assert_allclose(path.curvature, 1 / radius, rtol=0.01)
    np.testing.assert_allclose(path.speed, 45 / np.hypot(1, 45 / radius / 1.1), rtol=0.01)
    # The turn rate that this needs stays below the limit.
    assert (path.speed * path.curvature).max() < 1.1
    assert path.time[-1] == pytest.approx(2 * np.pi * radius / path.speed.mean(), rel=0.01)


def test_a_straight_line_is_taken_at_nominal_speed() -> None:
    path = TimedPath(LINE, LIMITS)
    np.testing.assert_allclose(path.speed, 45.0)
    np.testing.assert_allclose(path.time, path.points[:, 0] / 45.0)
    np.testing.assert_allclose(path.at_time(np.array([0.0, 2.0])), [[0, 0], [90, 0]], atol=1e-9)
    # Beyond the end straight on, at the last speed.
    np.testing.assert_allclose(path.at_time(path.time[-1] + np.array([1.0])), [[345, 0]], atol=1e-9)


def test_a_corner_within_the_first_step_does_not_change_the_clock() -> None:
    bent = TimedPath(np.array([[0.0, 0.0], [0.5, 0.0], [0.5, 200.0]]), LIMITS)
    assert bent.time[-1] > 200 / 45
    assert bent.time[-1] == pytest.approx(200.5 / 45, rel=0.15)
    assert not bent.near_end(len(bent.points) - 5)


def test_progress_only_goes_forward_and_no_further_than_asked() -> None:
    path = TimedPath(circle(50.0, turns=2.0), LIMITS)
    lap = len(path.points) // 2
    assert path.advance(path.points[20], 0, 1.0) == 20
    assert path.advance(path.points[20], 30, 1.0) == 30
    # Second lap over the same ground: the nearest point of the first lap is not taken.
    assert path.advance(path.points[lap + 5], lap, 1.0) == pytest.approx(lap + 5, abs=1)
    assert path.advance(path.points[200], 0, 1.0) <= 46
    assert path.advance(path.points[-1], len(path.points) - 1, 1.0) == len(path.points) - 1


def test_it_looks_as_far_ahead_as_nominal_speed_takes_it() -> None:
    for spacing in (0.5, 1.0, 3.0):
        path = TimedPath(LINE, replace(LIMITS, spacing=spacing))
        assert path.advance(LINE[-1], 0, 1.0) == pytest.approx(45.0 / spacing, abs=1.0)


def test_near_the_end_within_the_tolerance_along_the_path() -> None:
    path = TimedPath(LINE, LIMITS)
    assert [path.near_end(k) for k in (0, 296, 297, 300)] == [False, False, True, True]


@given(points=polylines, seed=st.integers(0, 1000))
def test_error_measures_equal_brute_force(points: np.ndarray, seed: int) -> None:
    path = TimedPath(points, LIMITS)
    executed = np.random.default_rng(seed).uniform(0, 100, (30, 2))
    distance = np.linalg.norm(executed[:, None] - path.points, axis=-1).min(axis=1)
    assert path_error(executed, path) == pytest.approx(distance.mean())
    chosen = np.random.default_rng(seed).integers(0, 30, 500)
    to_waypoints = np.linalg.norm(executed[chosen][:, None] - points, axis=-1).min(axis=1)
    assert paper_path_error(executed, points, np.random.default_rng(seed)) == pytest.approx(to_waypoints.mean())


def test_a_perfect_run_has_a_quarter_of_the_waypoint_spacing_in_the_papers_measure() -> None:
    path = TimedPath(LINE, LIMITS)
    executed = path.at_time(np.linspace(0, path.time[-1], 5000))
    waypoints = LINE[0] + np.arange(0, 301, 15.0)[:, None] * [1, 0]
    assert paper_path_error(executed, waypoints, np.random.default_rng(0)) == pytest.approx(15 / 4, rel=0.1)
    assert path_error(executed, path) < 0.3


def write(folder: Path, text: str) -> Path:
    (folder / "p.csv").write_text(text)
    return folder / "p.csv"


def test_a_path_file_may_have_units_other_columns_and_any_order(tmp_path: Path) -> None:
    file = write(tmp_path, "name,y [px], x [px]\na,2,1\nb,4,3\n")
    np.testing.assert_array_equal(read_path(file, ("x", "y")), [[1, 2], [3, 4]])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("x,y\n1,2\n3,\n", r"line 3, column y: not a finite number"),
        ("x,y\n1,2\n3,inf\n", r"line 3, column y: not a finite number"),
        ("x,y\n1,2\nfar,4\n", r"line 3, column x: not a finite number"),
        ("x,y\n1,2\n", r"1 point\(s\); a path needs at least 2"),
        ("x,y\n", r"0 point\(s\)"),
        ("x,z\n1,2\n3,4\n", "column y is missing; a path has columns x, y"),
        ("x [px],x [m],y\n1,2,3\n3,4,5\n", "column x appears twice"),
        ("x,y\n1,2\n1,2\n", "all points are the same"),
        ("", "can't read the path"),
    ],
)
def test_a_file_that_is_no_path_is_refused_with_its_name(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(InputError, match=rf"p\.csv: .*{message}"):
        read_path(write(tmp_path, text), ("x", "y"))


def test_a_missing_or_binary_path_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"none\.csv: can't read the path"):
        read_path(tmp_path / "none.csv", ("x", "y"))
    (tmp_path / "b.csv").write_bytes(b"\xff\x00\xfe")
    with pytest.raises(InputError, match=r"b\.csv: can't read the path"):
        read_path(tmp_path / "b.csv", ("x", "y"))


def test_points_from_elsewhere_are_checked_too() -> None:
    check_points(LINE, "goal")
    with pytest.raises(InputError, match="goal: line 3, column y"):
        check_points(np.array([[0, 0], [1, np.nan]]), "goal")


def test_a_path_in_any_dialect_and_its_unit(tmp_path: Path) -> None:
    file = write(tmp_path, "# drawn by hand\nx [mm];y [m]\n1000,5;2\n3000;4\n")
    np.testing.assert_allclose(read_path(file, ("x", "y"), "m"), [[1.0005, 2], [3, 4]])
    np.testing.assert_allclose(read_path(file, ("x", "y")), [[1000.5, 2], [3000, 4]])  # in whatever they are
    with pytest.raises(InputError, match=r"column x is in mm, a path here in px"):
        read_path(file, ("x", "y"), "px")


def test_more_points_than_memory_are_refused() -> None:
    with pytest.raises(InputError, match="over 1000000 points; give a larger spacing"):
        resample(np.array([[0.0, 0.0], [1e12, 0.0]]), 1.0)


def test_many_followers_advance_as_each_does() -> None:
    path = TimedPath(circle(60.0), LIMITS)
    rng = np.random.default_rng(0)
    progress = rng.integers(0, len(path.points), 200)
    progress[:2] = len(path.points) - 1, len(path.points) - 2
    positions = path.points[progress] + rng.normal(0.0, 20.0, (200, 2))
    alone = [path.advance(p, int(k), 2.0) for p, k in zip(positions, progress, strict=True)]
    np.testing.assert_array_equal(path.advance_rows(positions, progress, 2.0), alone)


@pytest.mark.parametrize("seed", range(3))
def test_curvature_is_a_mean_over_neighbours_point_by_point(seed: int) -> None:
    """Over fewer near the ends, which turn as the points beside them do."""
    rng = np.random.default_rng(seed)
    points = np.cumsum(rng.normal(size=(12, 2)), axis=0)
    ways = np.diff(points, axis=0)
    turns = [np.arctan2(a[0] * b[1] - a[1] * b[0], a @ b) / 0.5 for a, b in zip(ways[:-1], ways[1:], strict=True)]
    turns = [turns[0], *turns, turns[-1]]
    for half in (1, 3, 50):
        expected = [np.mean(turns[max(0, k - half) : k + half + 1]) for k in range(12)]
        np.testing.assert_allclose(_mean_curvature(points, 0.5, half), expected)


def test_beyond_its_end_it_goes_on_in_its_last_direction_at_its_last_speed() -> None:
    path = TimedPath(np.array([[0.0, 0.0], [200.0, 0.0], [200.0, 150.0], [40.0, 270.0]]), LIMITS)
    end, last = path.time[-1], path.speed[-1]
    np.testing.assert_allclose(path.at_time(end), [40.0, 270.0], atol=1e-9)
    np.testing.assert_allclose(path.at_time(end + 2.0), [40.0 - 2.0 * last * 0.8, 270.0 + 2.0 * last * 0.6], atol=1e-6)
    assert path.direction[1] == pytest.approx(0.0)
    assert path.direction[-1] == pytest.approx(np.arctan2(0.6, -0.8))
    moved = path.shifted(np.array([5.0, -3.0]))
    np.testing.assert_allclose(moved.at_time(np.array([0.0, 1.0])), path.at_time(np.array([0.0, 1.0])) + [5.0, -3.0])
    np.testing.assert_array_equal(path.points[0], [0.0, 0.0], "it stays where it is")


def test_at_a_time_it_is_between_its_points() -> None:
    path = TimedPath(circle(30.0), LIMITS)
    middle = 0.5 * (path.time[7] + path.time[8])
    np.testing.assert_allclose(path.at_time(middle), 0.5 * (path.points[7] + path.points[8]))
    steps = np.linalg.norm(np.diff(path.points, axis=0), axis=1)
    np.testing.assert_allclose(np.diff(path.time), steps / (0.5 * (path.speed[1:] + path.speed[:-1])), rtol=1e-3)
