"""Trials of paths: what `ichain run` does with the same seed, and a row for everything that goes wrong."""

from types import SimpleNamespace

import numpy as np
import pytest

from ichain_drake.errors import InputError
from ichain_drake.runs.paths.choice import choose_paths
from ichain_drake.runs.paths.result import PathRun
from ichain_drake.runs.paths.run import run_paths
from ichain_drake.runs.runner import run_jobs
from ichain_drake.runs.scoreboard.cases import Case
from ichain_drake.runs.scoreboard.trials import make_jobs
from ichain_drake.systems.car_game.scenario import CarGame


class ShortGame(CarGame):
    """The car game with two paths of a few seconds in place of its three, and few samples."""

    def __init__(self, *arguments):
        super().__init__(*arguments)
        self.config.learning.samples = 250

    def reference_paths(self):
        t = np.linspace(0.0, 1.0, 200)[:, None]
        wave = np.concatenate([250 + 120 * t, 300 + 30 * np.sin(4 * t)], axis=1)
        return {"line": np.concatenate([300 + 100 * t, 300 + 0 * t], axis=1), "wave": wave}


def case(kind, task, fault="none", settings=(), oracle=0, taught=()):
    return Case("short_game", kind, task, "ideal", fault, settings, 1, oracle, taught=taught)


def test_what_is_read_with_noise_is_demonstrated_so(monkeypatch):
    def told(scenario, pieces):
        raise InputError(f"recorded with {scenario.config.noise.vehicle}")

    monkeypatch.setattr("ichain_drake.runs.scoreboard.trials.record_pieces", told)
    read = ("noise.vehicle=1",)
    rows = run_jobs(make_jobs([case(ShortGame, "wave"), case(ShortGame, "wave", "reading", read, taught=read)], 5))
    assert [r["reason"] for r in rows] == ["recorded with 0.0", "recorded with 1.0"]


def test_a_trial_is_the_run_of_its_seed():
    loud = ("noise.scale=20",)
    cases = [
        case(ShortGame, "wave", oracle=1),
        case(ShortGame, "wave", "noise", ("noise.scale=3",)),
        case(ShortGame, "wave", "loud", loud),
    ]
    (job,) = make_jobs(cases, 5)
    plain, noisy, lost = run_jobs([job])
    scenario = ShortGame((), "ideal", 5)
    run = PathRun(scenario, choose_paths(scenario))
    run_paths(run)
    wave = run.results[1]  # the second of the scenario's paths, although the line was not asked for
    assert plain["success"], plain["reason"]
    assert plain["error"] == wave.error
    assert plain["control_steps"] == wave.control_steps
    assert 0 < plain["oracle_error"] < plain["error"] * 1.5
    assert noisy["error"] > plain["error"]
    assert noisy["oracle_error"] is None
    assert plain["unit"] == "px"
    assert plain["wall_seconds"] > plain["learning_seconds"] > 0
    assert set(plain) == set(noisy) == set(lost)
    again = ShortGame(loud, "ideal", 5)
    rerun = PathRun(again, choose_paths(again))
    run_paths(rerun, known=run.model)
    assert not lost["success"]
    assert lost["reason"] == rerun.results[1].reason != ""


@pytest.mark.parametrize(
    ("where", "cause"), [("record_pieces", "error"), ("learn_to_follow", "learning"), ("follow", "error")]
)
def test_what_raises_is_a_row(monkeypatch, where, cause):
    def broken(*arguments, **named):
        raise InputError(f"{where} does not go")

    for name in ("record_pieces", "learn_to_follow"):
        monkeypatch.setattr(f"ichain_drake.runs.scoreboard.trials.{name}", lambda run, *more: run)
    monkeypatch.setattr(f"ichain_drake.runs.scoreboard.trials.{where}", broken)
    if where == "follow":
        monkeypatch.setattr(
            "ichain_drake.runs.scoreboard.trials.learn_to_follow",
            lambda run: setattr(run, "model", SimpleNamespace(chain=object())) or setattr(run, "controller", object()),
        )
    rows = run_jobs(make_jobs([case(ShortGame, "line"), case(ShortGame, "wave")], 5))
    assert [(r["success"], r["cause"], r["reason"], r["seed"]) for r in rows] == [
        (False, cause, f"{where} does not go", 5)
    ] * 2
    assert [(r["control_steps"], r["error"], r["silent"]) for r in rows] == [(0, None, False)] * 2
