"""Fresh trials share nothing: no seed of a demonstration is one of a run, and none is another trial's."""

import sys
from pathlib import Path

import pytest

from ichain_drake.errors import InputError
from ichain_drake.runs.goals.fresh import FreshSeed, SharedTrial
from ichain_drake.runs.goals.trial import Trial
from ichain_drake.runs.goals.variants import GoalVariant
from ichain_drake.runs.runner import run_jobs
from ichain_drake.scenarios import graph_scenario
from ichain_drake.systems.own import own_scenario

BATH = Path(__file__).parents[3] / "examples" / "own_system" / "bath.py"
LINES = (GoalVariant("monitors", "none"), GoalVariant("monitors", "noise", ("noise.scale=3",)))


@pytest.fixture
def bath(monkeypatch):
    monkeypatch.setattr(sys, "path", [*sys.path])
    return own_scenario(str(BATH))


def test_noise_of_demonstrations_and_runs_is_never_the_same(bath, monkeypatch):
    seeds = []
    real = graph_scenario.ObjectMaker
    monkeypatch.setattr(
        graph_scenario, "ObjectMaker", lambda graph, seed, *more: seeds.append(seed) or real(graph, seed, *more)
    )
    monkeypatch.setattr(graph_scenario, "record", lambda *arguments: None)
    for seed in (7, 8, 9):
        scenario = bath((), "ideal", seed)
        assert len(list(scenario.record_demonstrations())) == 8
        scenario.make_world(0)
    assert len(seeds) == 3 * (8 + 1)
    assert len(set(seeds)) == len(seeds)


class Seeds:
    """A scenario that tells which seed it was made with, and can't be demonstrated."""

    def __init__(self, overrides=(), physics="ideal", seed=0):
        self.seed = seed

    def record_demonstrations(self):
        raise InputError(f"seed {self.seed}\ncan't be recorded")


def test_a_trial_that_can_not_be_recorded_is_a_row_of_its_own_seed():
    jobs = [FreshSeed(Seeds, (), "ideal", seed, ("a.b >= 1",), LINES) for seed in (7, 8)]
    rows = run_jobs(jobs)
    assert [(r["seed"], r["case"], r["reason"]) for r in rows] == [
        (seed, case, f"seed {seed} can't be recorded") for seed in (7, 8) for case in ("none", "noise")
    ]
    assert {r["cause"] for r in rows} == {"error"}
    assert not any(r["success"] or r["silent"] for r in rows)
    assert len({i for job in jobs for i in job.ids}) == 4


def test_a_run_that_raises_what_nobody_meant_is_a_row(monkeypatch):
    def broken(*arguments, **named):
        raise ZeroDivisionError("by nought")

    monkeypatch.setattr("ichain_drake.runs.goals.trial.run_graph", broken)
    monkeypatch.setattr("ichain_drake.runs.goals.trial.GraphRun", lambda *arguments, **named: None)
    trial = Trial("monitors", "none", Seeds, (), "ideal", 0, 3, ("a.b >= 1",), True, 8)
    (row,) = run_jobs([SharedTrial(trial, object())])  # type: ignore[arg-type]
    assert row["reason"].startswith("ZeroDivisionError: by nought (test_fresh.py, line")
    assert (row["cause"], row["seed"], row["demonstrations"]) == ("error", 3, "seed 0")
