"""Trials of one learned model calculated together, against the same trials one after another."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from ichain_drake.control.tracking.chain import ChainController
from ichain_drake.learning.chain.chain import LearnedChain
from ichain_drake.runs.paths.choice import choose_paths
from ichain_drake.runs.paths.evaluation import path_row
from ichain_drake.runs.paths.following import follow
from ichain_drake.runs.paths.many import follow_many
from ichain_drake.runs.paths.result import PathResult
from ichain_drake.scenarios.base import PathScenario

_FIRST_SEED = 1000  # of the trials: the models' demonstrations are of another


def benchmark_together(
    scenario: PathScenario, chain: LearnedChain, controller: ChainController, trials: int, alone: int, learning: float
) -> dict[str, Any]:
    """Trials a second of processor time, and whether rows are equal.

    Args:
        scenario: in `ideal` physics.
        chain: learned.
        controller: decides.
        trials: calculated together, each with a seed of its own.
        alone: how many of them are run alone too, spread over all.
        learning: processor time of recording, learning and choosing the controller [s]: what a trial with
            demonstrations of its own takes in addition.

    Returns:
        Plain data; `compared` says how many runs alone were in all bits of row, states and commands what they were
        together (`equal`).
    """
    name, path = next(iter(choose_paths(scenario).items()))
    scenarios = [type(scenario)((), "ideal", _FIRST_SEED + k) for k in range(trials)]
    begin = time.process_time()
    found = follow_many(scenarios, chain, controller, name, path, 0)
    together = (time.process_time() - begin) / trials

    chosen = np.unique(np.linspace(0, trials - 1, alone).astype(int))
    equal, begin = 0, time.process_time()
    singles = [follow(scenarios[k], chain, controller, name, path, 0) for k in chosen]
    single = (time.process_time() - begin) / len(chosen)
    for k, run in zip(chosen, singles, strict=True):
        equal += _same(found[k], run, scenarios[k])
    return {
        "scenario": scenario.name,
        "path": name,
        "trials": trials,
        "steps": float(np.mean([run.control_steps for run in singles])),
        "compared": len(chosen),
        "equal": equal,
        "single_trials_a_second": 1.0 / single,
        "together_trials_a_second": 1.0 / together,
        "ratio": single / together,
        "learning_seconds": learning,
        "ratio_fresh": (learning + single) / (learning + together),
    }


def _same(one: PathResult | Exception, other: PathResult, scenario: PathScenario) -> bool:
    if isinstance(one, Exception):
        return False
    rows = [path_row("", 0, scenario, r.name, r) | {"steps": r.control_steps} for r in (one, other)]
    logs = [one.log.states[n] for n in other.log.states] + [one.log.command]
    others = [*other.log.states.values(), other.log.command]
    return rows[0] == rows[1] and all(np.array_equal(a, b) for a, b in zip(logs, others, strict=True))
