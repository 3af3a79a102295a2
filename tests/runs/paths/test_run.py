"""Any path with turns that the demonstrations show is followed, whoever drew it."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from ichain_drake.control.tracking.path import TimedPath
from ichain_drake.demonstrations import read_demonstrations
from ichain_drake.errors import InputError
from ichain_drake.runs.learn import recorded_seconds
from ichain_drake.runs.paths.choice import choose_paths
from ichain_drake.runs.paths.result import PathRun
from ichain_drake.runs.paths.run import run_paths
from ichain_drake.runs.pieces import check_settings
from ichain_drake.systems import load_scenario
from ichain_drake.systems.car_game.scenario import CarGame


def three_lobes() -> np.ndarray:
    t = np.linspace(0.2, 2 * np.pi + 0.2, 600)
    r = 150 + 45 * np.cos(3 * t)
    return np.stack([400 + r * np.cos(t), 300 + r * np.sin(t)], axis=1)


def rounded_rectangle(width: float = 480.0, height: float = 320.0, radius: float = 35.0) -> np.ndarray:
    """Begins in the middle of the upper side."""
    corners = [(1, 0, -90), (1, 1, 0), (0, 1, 90), (0, 0, 180)]
    points = [np.array([[400.0, 300 - height / 2]])]
    for right, low, start in corners:
        centre = np.array([400 + (right - 0.5) * (width - 2 * radius), 300 + (low - 0.5) * (height - 2 * radius)])
        a = np.radians(start + np.linspace(0, 90, 40))
        points.append(centre + radius * np.stack([np.cos(a), np.sin(a)], axis=1))
    return np.concatenate([*points, points[0]])


def smallest_radius(points: np.ndarray) -> float:
    a, b, c = points[:-2], points[1:-1], points[2:]
    sides = [np.linalg.norm(p - q, axis=1) for p, q in ((a, b), (b, c), (a, c))]
    u, v = b - a, c - a
    area = np.abs(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]) / 2
    bent = area > 1e-6
    return float((np.prod(sides, axis=0)[bent] / (4 * area[bent])).min())


@pytest.fixture(scope="module")
def learned(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Demonstrations of 500 transitions a link."""
    from ichain_drake.cli.main import main

    folder = tmp_path_factory.mktemp("demos")
    assert main(["teach", "car_game", "--physics", "ideal", "-o", str(folder)]) == 0
    return folder


def test_paths_that_nobody_has_seen_are_followed(learned, tmp_path):
    for name, points in (("lobes", three_lobes()), ("rectangle", rounded_rectangle())):
        assert smallest_radius(points) > 34.0
        pd.DataFrame(points, columns=["x [px]", "y [px]"]).to_csv(tmp_path / f"{name}.csv", index=False)
    scenario = load_scenario("car_game", (), "ideal", 0)
    files = [tmp_path / f"{name}.csv" for name in ("lobes", "rectangle")]
    paths = choose_paths(scenario, file=files[0]) | choose_paths(scenario, file=files[1])
    run = PathRun(scenario, paths)
    run_paths(run, demos=learned)
    assert run.goal_reached, run.reason
    for result in run.results:
        print(f"\n{result.name}: {result.error:.3f} px")
        assert result.completed
        assert result.error < 1.5


class LostOracle(CarGame):
    """Its oracle may command no more than one place of the hand, a joystick in its middle: it drives nowhere."""

    def command_range(self) -> tuple[np.ndarray, np.ndarray]:
        middle = np.array(self.config.joystick.pivot[:2])
        return middle - 1e-6, middle + 1e-6


def test_a_report_says_why_there_is_no_error_of_the_oracle(learned):
    a = np.linspace(0.0, np.pi / 3, 100)
    bend = np.stack([250 + 200 * np.sin(a), 400 - 200 * (1 - np.cos(a))], axis=1)
    scenario = LostOracle(["control.horizons=[5]", "control.efforts=[0.05]"], "ideal", 0)
    run = PathRun(scenario, {"bend": TimedPath(bend, scenario.path_limits())})
    run_paths(run, demos=learned, oracle=True)
    metrics = run.report()["metrics"]
    assert metrics["completed"]
    assert metrics["oracle_error_px"] is None
    assert metrics["oracle_reason"] == "the oracle did not reach the path's end"


def test_robot_time_is_counted_where_the_robot_took_part(learned):
    scenario = load_scenario("car_game", (), "ideal", 0)
    pieces = read_demonstrations(learned, scenario.graph)
    # One more than 500: in the first tick the grasp is not yet known to hold.
    assert recorded_seconds(pieces, scenario.graph) == {"hand->joystick": pytest.approx(167.0), "joystick->car": 0.0}
    assert {len(p) - 1 for p in pieces} == {500, 501}


@pytest.mark.parametrize("samples", [99, 100, 121, 200])
def test_as_many_transitions_are_recorded_as_were_asked_for(samples):
    """For some numbers of ticks a third of a second, multiplied, ends just before the last frame."""
    scenario = load_scenario("car_game", [f"learning.samples={samples}"], "ideal", 0)
    assert [len(p) - 1 for p in scenario.record_demonstrations()] == [samples + 1, samples]


def test_an_interrupted_run_reports_that():
    scenario = load_scenario("car_game", (), "ideal", 0)
    report = PathRun(scenario, choose_paths(scenario, ["eight"])).report()
    assert (report["reason"], report["goal_reached"], report["models"]) == ("interrupted", False, {})
    json.dumps(report, allow_nan=False)


def test_reference_paths_by_name():
    scenario = load_scenario("car_game", (), "ideal", 0)
    assert list(choose_paths(scenario)) == ["eight", "spiral", "cursive"]
    chosen = choose_paths(scenario, ["cursive"])
    assert list(chosen) == ["cursive"] and isinstance(chosen["cursive"], TimedPath)
    with pytest.raises(InputError, match="no path 'nine'"):
        choose_paths(scenario, ["nine"])


def test_settings_are_checked_before_work():
    check_settings(load_scenario("car_game", (), "ideal", 0))
    bad = load_scenario("car_game", ["learning.estimator=polynomial(colour=1)"], "ideal", 0)
    with pytest.raises(InputError, match=r"hand->joystick: polynomial\(colour=1\): .*no parameter 'colour'"):
        check_settings(bad)
