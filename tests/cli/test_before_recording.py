"""What needs no model is checked before anything is recorded: a typo costs a second."""

import time

import numpy as np
import pytest

from ichain_drake.scenarios.base import Scenario

DISPENSER = {
    ("--goal", "cup.heat >= 0.5"): "at character 1, cup has no variable 'heat'",
    ("--goal", "cup.water >> 0.5"): "at character 12, '>', a number or 'start' is expected",
    ("--goal", "-0.02 <= mug.x"): "there is no object 'mug'",
    ("--goal", "cup.water >= 0.5", "-0.02 >= mug.x"): "there is no object 'mug'",
    ("--goal", "hand->mug"): "there is no interaction hand->mug",
    ("--goal", ""): "no goal is given",
    ("--set", "learning.estimator=Rigde"): "there is no estimator 'Rigde'; did you mean Ridge",
    ("--set", "learning.estimator=polynomial(degree=60)"): "polynomial(degree=60)",
    ("--set", "goal=[cup.watr >= 1]"): "cup has no variable 'watr'",
    ("--demos", "nowhere"): "nowhere: no such folder of demonstrations",
    ("--library", "nowhere"): "nowhere",
}


@pytest.fixture(autouse=True)
def nothing_is_recorded(monkeypatch: pytest.MonkeyPatch):
    def fail(self: Scenario, run: int) -> None:
        raise AssertionError("a world was built")

    for kind in ("water_dispenser.scenario.WaterDispenser", "car_game.scenario.CarGame"):
        monkeypatch.setattr(f"ichain_drake.systems.{kind}.record_demonstrations", fail)


@pytest.mark.parametrize("command", ["run", "plan"])
@pytest.mark.parametrize("arguments", DISPENSER)
def test_a_goal(command: str, arguments: tuple[str, ...], ichain, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    started = time.monotonic()
    done = ichain(command, "water_dispenser", "--physics", "ideal", *arguments)
    assert done.status == 2
    assert DISPENSER[arguments] in done.line
    assert time.monotonic() - started < 20.0
    assert not list(tmp_path.iterdir())


PATHS = {
    ("--set", "learning.estimator=polynomial(degree=60)"): "polynomial(degree=60)",
    ("--set", "learning.estimator=MultiOutputRegressor(estimator='Ridge')"): "MultiOutputRegressor(estimator='Ridge')",
    ("--set", "learning.estimator=BaggingRegressor"): "BaggingRegressor()",
    ("--set", "learning.estimator=RidgeCV(alphas=[])"): "RidgeCV(alphas=[])",
    ("--demos", "nowhere"): "nowhere: no such folder of demonstrations",
}


@pytest.mark.parametrize("arguments", PATHS)
def test_a_path(arguments: tuple[str, ...], ichain, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    done = ichain("run", "car_game", "--physics", "ideal", *arguments)
    assert done.status == 2
    assert PATHS[arguments] in done.line
    assert not list(tmp_path.iterdir())


def test_two_paths_are_both_driven(ichain, small, csv, tmp_path, strict_json, monkeypatch):
    monkeypatch.undo()
    a = np.linspace(0.0, 1.0, 40)
    files = [csv(np.stack([200 + 100 * a, 200 + k * a], axis=1), name=f"line{k}.csv") for k in (0, 30)]
    done = ichain("run", "car_game", *small, "--path", files[0], "--path", files[1], "-o", tmp_path / "out")
    report = strict_json((tmp_path / "out" / "report.json").read_text())
    assert set(report["metrics"]["paths"]) == {"line0", "line30"}
    assert done.status == (0 if report["goal_reached"] else 1)
