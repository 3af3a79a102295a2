"""Search for the oracle's weights, on seeds that no report uses: `python benchmarks/oracle_search.py SYSTEM ...`.

An oracle is a limit only if it couldn't easily be better. Horizon, effort, weight along the path and Gauss-Newton steps
are drawn at random and tried on all of a system's paths, all seeds together; half of the seeds choose, the other half
says what the choice is worth. What counts is the mean log error beside that of the weights that the scenario declares.
Nothing is written into scenarios: whoever runs this decides, and says so in `oracle_weights`.
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
from ichain_drake.runs.paths.many import oracle_follow_many
from ichain_drake.runs.paths.result import PathResult
from ichain_drake.runs.provenance import printed
from ichain_drake.scenarios.base import PathScenario
from ichain_drake.state import FloatArray

SEEDS = range(100, 106)
"""Of validation: reports begin at others."""
CHOICES: dict[str, list[Any]] = {
    "horizon": [0.6, 0.8, 1.0, 1.2, 1.6],  # times the declared one
    "effort": [0.005, 0.01, 0.02, 0.05, 0.1, 0.2],
    "along": [0.1, 0.2, 0.4, 0.7, 1.0],
    "iterations": [2, 3, 4, 5],
}
MOST = 1.0
"""Of a log ratio: what a path counts that one of two did not complete."""


def errors(system: str, weights: PredictiveWeights) -> FloatArray:
    """Mean error of each seed and path, shape (seeds, paths); infinite where its end was not reached."""
    scenarios = [load_scenario(system, physics="ideal", seed=seed) for seed in SEEDS]
    first = scenarios[0]
    assert isinstance(first, PathScenario)
    type(first).oracle_weights = weights  # in this worker process alone
    of_paths = []
    for n, (name, path) in enumerate(choose_paths(first).items()):
        found = oracle_follow_many(scenarios, name, path, n)  # type: ignore[arg-type]
        of_paths.append([r.error if isinstance(r, PathResult) and r.completed else np.inf for r in found])
    return np.array(of_paths).T


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
    found = np.array(Parallel(jobs)(delayed(errors)(system, weights) for weights in candidates))
    with np.errstate(invalid="ignore"):
        ratios = np.clip(np.nan_to_num(np.log(found / found[0]), posinf=MOST, neginf=-MOST), -MOST, MOST)
    half = len(SEEDS) // 2
    best = int(ratios[:, :half].mean(axis=(1, 2)).argmin())
    new = ratios[best, half:].ravel()
    return {
        "system": system,
        "tried": len(candidates) - 1,
        "declared": said(declared),
        "best": said(candidates[best]),
        "where chosen": float(np.exp(ratios[best, :half].mean())),
        "on other seeds": float(np.exp(new.mean())),
        "+-": float(1.96 * new.std(ddof=1) / np.sqrt(len(new))),
    }


def main() -> None:
    """Search, print a line a system, and write the report."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("systems", nargs="+", help="such as car_game")
    parser.add_argument("--first", type=int, default=24, help="candidates")
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
