"""Fresh trials share nothing: no seed of a demonstration is one of a run, and none is another trial's."""

import sys
from pathlib import Path

import pytest

from ichain_drake.errors import InputError
from ichain_drake.runs.clusters.workers import Workers
from ichain_drake.runs.goals.fresh import FreshSeed, FreshSeeds, SharedTrial, SharedTrials, join
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


def apart_from_seconds(rows):
    return {name: {k: v for k, v in row.items() if not k.endswith("seconds")} for name, row in rows}


def test_seeds_found_together_are_what_each_is_alone(bath):
    goal = tuple(bath((), "ideal", 0).config.goal)
    seeds = [FreshSeed(bath, (), "ideal", seed, goal, LINES) for seed in (7, 8, 9)]
    joint = FreshSeeds(tuple(seeds))
    found = list(joint.run(joint.ids))
    assert [name for name, _ in found] == list(joint.ids)
    assert [name.rpartition(" ")[2] for name in joint.ids] == ["7", "8", "9"] * 2
    alone = [pair for seed in seeds for pair in seed.run(seed.ids)]
    assert apart_from_seconds(found) == apart_from_seconds(alone)
    assert all(row["success"] and row["wall_seconds"] > 0 for _, row in found)
    some = [joint.ids[1], joint.ids[3]]
    assert apart_from_seconds(joint.run(some)) == {n: r for n, r in apart_from_seconds(alone).items() if n in some}


def test_a_seed_that_can_not_be_recorded_is_in_no_other_ones_way(bath, monkeypatch):
    goal = tuple(bath((), "ideal", 0).config.goal)
    seeds = tuple(FreshSeed(bath, (), "ideal", seed, goal, LINES[:1]) for seed in (7, 8))
    real = bath.script

    def script(self, rng):
        if self.seed == 7:
            raise InputError("its script is lost")
        return real(self, rng)

    monkeypatch.setattr(bath, "script", script)
    lost, found = run_jobs([FreshSeeds(seeds)])
    assert (lost["seed"], lost["reason"], lost["cause"]) == (7, "its script is lost", "error")
    assert (found["seed"], found["success"]) == (8, True)


@pytest.mark.parametrize(
    ("count", "processes", "sizes"),
    [(1, 2, [1]), (5, 2, [3, 2]), (20, 2, [10, 10]), (100, 2, [13] * 7 + [9]), (40, 1, [14, 14, 12])],
)
def test_seeds_are_joined_so_that_all_workers_have_as_much_to_do(count, processes, sizes):
    jobs = [FreshSeed(Seeds, (), "ideal", seed, ("a.b >= 1",), LINES) for seed in range(count)]
    joined = join(jobs, Workers(processes))
    assert [len(getattr(job, "apart", (job,))) for job in joined] == sizes
    assert sorted(i for job in joined for i in job.ids) == sorted(i for job in jobs for i in job.ids)
    assert join(jobs, Workers(processes, trial_timeout=5.0)) == jobs


def test_only_what_is_alike_is_joined():
    ideal = [FreshSeed(Seeds, (), "ideal", seed, ("a.b >= 1",), LINES) for seed in (1, 2)]
    arm = [FreshSeed(Seeds, (), "arm", seed, ("a.b >= 1",), LINES) for seed in (1, 2)]
    ablated = [FreshSeed(Seeds, (), "ideal", s, ("a.b >= 1",), (GoalVariant("m", "c", without="x"),)) for s in (1, 2)]
    trials = [Trial("m", "c", Seeds, (), "ideal", 0, k, ("a.b >= 1",), True, 8) for k in range(4)]
    one, other = object(), object()
    shared = [SharedTrial(t, one if t.number < 2 else other) for t in trials]  # type: ignore[arg-type]
    joined = join([*ideal, *arm, *ablated, *shared], Workers())
    assert joined == [
        FreshSeeds(tuple(ideal)), *arm, *ablated, SharedTrials(tuple(shared[:2])), SharedTrials(tuple(shared[2:])),
    ]  # fmt: skip
    assert joined[-1].failed(shared[3].ids[0], "lost") == shared[3].failed("", "lost")
