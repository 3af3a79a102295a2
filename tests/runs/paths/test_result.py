"""What a run of paths says of itself: reached only where every path was completed; sums over paths, units, reasons."""

import json

import numpy as np
import pytest

from ichain_drake.control.tracking.path import TimedPath
from ichain_drake.runs.paths.result import PathResult, PathRun
from ichain_drake.simulation.episode import EpisodeLog
from ichain_drake.systems import load_scenario
from ichain_drake.timing import FRAME

SCENARIO = load_scenario("car_game", (), "ideal", 4)
PATH = TimedPath(np.array([[100.0, 100.0], [200.0, 100.0], [300.0, 100.0]]), SCENARIO.path_limits())


def result(name: str, completed: bool = True, frames: int = 31, **more: float) -> PathResult:
    """An episode of so many logged frames, the first at its start."""
    log = EpisodeLog(FRAME * np.arange(frames), {}, {}, {}, np.zeros((frames, 2)))
    return PathResult(name, PATH, log, completed, 0.5, 0.7, **more)


@pytest.mark.parametrize(
    ("completed", "reached"), [([], False), ([True], False), ([True, False], False), ([True, True], True)]
)
def test_a_goal_is_reached_where_all_paths_were_followed_to_their_ends(completed: list[bool], reached: bool) -> None:
    run = PathRun(SCENARIO, {"a": PATH, "b": PATH}, results=[result("ab"[k], c) for k, c in enumerate(completed)])
    assert run.goal_reached == run.report()["goal_reached"] == reached
    assert not PathRun(SCENARIO).goal_reached, "nothing asked for is nothing reached"


def test_steps_and_time_are_summed_over_paths() -> None:
    report = PathRun(SCENARIO, {"a": PATH, "b": PATH}, results=[result("a"), result("b", frames=101)]).report()
    assert report["control_steps"] == 3 + 10
    assert report["sim_seconds"] == pytest.approx(1.0 + 100 / 30)
    assert (report["scenario"], report["physics"], report["seed"]) == ("car_game", "ideal", 4)
    assert set(report["metrics"]) == {"paths"}, "no one path's figures stand for two"
    json.dumps(report, allow_nan=False)


def test_of_one_path_the_figures_are_flat_too() -> None:
    found = PathRun(SCENARIO, {"a": PATH}, results=[result("a", oracle_error=0.4, oracle_reason="")]).report()[
        "metrics"
    ]
    assert found["paths"]["a"] == {k: v for k, v in found.items() if k != "paths"}
    assert {k: found[k] for k in ("mean_error_px", "paper_metric_px", "completed", "oracle_error_px", "unit")} == {
        "mean_error_px": 0.5, "paper_metric_px": 0.7, "completed": True, "oracle_error_px": 0.4, "unit": "px",
    }  # fmt: skip


def test_an_error_that_the_oracle_does_not_have_is_none_with_a_reason() -> None:
    found = result("a").metrics("m")
    assert (found["oracle_error_px"], found["oracle_reason"], found["unit"]) == (None, "the oracle was not run", "m")
