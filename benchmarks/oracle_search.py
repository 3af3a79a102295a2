"""Search for the oracle's weights, on seeds that no report uses: `python benchmarks/oracle_search.py SYSTEM ...`.

An oracle is a limit only if it couldn't easily be better. Horizon, effort, weight along the path and Gauss-Newton steps
are drawn at random; each round keeps the better third and tries it on more seeds (successive halving; Jamieson &
Talwalkar, AISTATS 2016), on all of a system's paths. What counts is the mean log error beside that of the weights that
the scenario declares. Nothing is written into scenarios: whoever runs this decides, and says so in `oracle_weights`.
"""

from __future__ import annotations

import argparse
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from joblib import Parallel, delayed
from sklearn.model_selection import ParameterSampler

from ichain_drake import load_scenario
from ichain_drake.control.tracking.levels import PredictiveWeights
from ichain_drake.runs.paths.choice import choose_paths
from ichain_drake.runs.paths.following import oracle_follow
from ichain_drake.runs.provenance import printed
from ichain_drake.scenarios.base import PathScenario

SEEDS = range(100, 106)
"""Of validation: reports begin at others."""
CHOICES: dict[str, list[Any]] = {
    "horizon": [0.6, 0.8, 1.0, 1.2, 1.6],  # times the declared one
    "effort": [0.005, 0.01, 0.02, 0.05, 0.1, 0.2],
    "along": [0.1, 0.2, 0.4, 0.7, 1.0],
    "iterations": [2, 3, 4, 5],
}
KEPT = 3
"""Of so many candidates one goes on to the next round."""


def errors(system: str, seed: int, weights: PredictiveWeights) -> list[float]:
    """Mean error of each path; infinite where its end was not reached."""
    scenario = load_scenario(system, physics="ideal", seed=seed)
    assert isinstance(scenario, PathScenario)
    type(scenario).oracle_weights = weights  # in this worker process alone
    results = [oracle_follow(scenario, k, path, n) for n, (k, path) in enumerate(choose_paths(scenario).items())]
    return [r.error if r.completed else np.inf for r in results]


def said(weights: PredictiveWeights) -> str:
    """In short."""
    return ", ".join(f"{name} {getattr(weights, name)}" for name in CHOICES)


def search(system: str, first: int, jobs: int) -> dict[str, Any]:
    """The best weights of a system, and what they bring on seeds that had no say before the last round."""
    scenario = load_scenario(system)
    if not isinstance(scenario, PathScenario) or scenario.no_oracle:
        raise SystemExit(f"{system} has no oracle")
    declared = scenario.oracle_weights
    drawn = list(ParameterSampler(CHOICES, first, random_state=0))
    drawn = [{**values, "horizon": max(2, round(values["horizon"] * declared.horizon))} for values in drawn]
    candidates = list(dict.fromkeys([declared, *(replace(declared, **values) for values in drawn)]))
    found: dict[tuple[int, PredictiveWeights], list[float]] = {}

    def score(weights: PredictiveWeights, seeds: range) -> float:
        pairs = [(np.array(found[s, weights]), np.array(found[s, declared])) for s in seeds]
        return float(np.mean([np.log(mine / theirs) for mine, theirs in pairs]))

    for last in (1, 3, 6):
        seeds = SEEDS[:last]
        todo = [(s, w) for w in candidates for s in seeds if (s, w) not in found]
        found.update(zip(todo, Parallel(jobs)(delayed(errors)(system, *job) for job in todo), strict=True))
        ranked = sorted(candidates, key=lambda w: score(w, seeds))
        print(
            f"{system}, {last} seeds: {said(ranked[0])}: {np.exp(score(ranked[0], seeds)):.4f} x the declared",
            flush=True,
        )
        candidates = list(dict.fromkeys([*ranked[: max(2, len(ranked) // KEPT)], declared]))
    best = ranked[0]
    new = SEEDS[3:]  # the first three chose who came into the last round
    return {
        "system": system,
        "tried": first,
        "declared": said(declared),
        "best": said(best),
        "ratio": float(np.exp(score(best, SEEDS))),
        "ratio_on_last_seeds": float(np.exp(score(best, new))),
    }


def main() -> None:
    """Search, print a line a system, and write the report."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("systems", nargs="+", help="such as car_game")
    parser.add_argument("--first", type=int, default=24, help="candidates of the first round")
    parser.add_argument("--jobs", type=int, default=1, help="processes")
    parser.add_argument("--report", type=Path, help="JSON file")
    options = parser.parse_args()
    rows = [search(name, options.first, options.jobs) for name in options.systems]
    text = pd.DataFrame(rows).to_string(index=False, float_format="{:.3f}".format)
    print(text)
    if options.report:
        command = f"python benchmarks/oracle_search.py {' '.join(options.systems)} --first {options.first}"
        options.report.write_text(json.dumps({**printed(text, command), "rows": rows}, indent=1))


if __name__ == "__main__":
    main()
