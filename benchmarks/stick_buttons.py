"""How often KinDER's buttons are pressed: `python benchmarks/stick_buttons.py --runs 1:40,3:16,5:8,10:3`.

Needs KinDER (see docs/kinder.md). Each set of demonstrations is of one button; what is learned from it is lifted to as
many as a row has. Every run has a start of its own, and counts when the environment says that all are pressed.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from ichain_drake import learn
from ichain_drake.runs.goals.run import GraphRun, run_graph
from ichain_drake.runs.intervals import success_interval
from ichain_drake.runs.library import load, save
from ichain_drake.systems import load_scenario

NAME = "kinder/StickButton2D-b{}"


def one(library: Path, count: int, seed: int) -> tuple[bool, float, float]:
    """Whether all buttons were pressed, control steps, and processor time [s] of a run."""
    scenario: Any = load_scenario(NAME.format(count), physics="environment", seed=seed)
    known = load(library, scenario, lift=count > 1)
    run, began = GraphRun(scenario), time.process_time()
    run_graph(run, known=known)
    seconds = time.process_time() - began
    if run.log is None or run.memory is None:
        return False, np.nan, seconds
    pressed = scenario.graph.objects["button0"].index("pressed")
    done = all(run.log.states[f"button{k}"][-1][pressed] == 1.0 for k in range(count))
    return done, float(run.memory.tick), seconds


def main() -> None:
    """Run, and print a line a number of buttons."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", default="1:40,3:16,5:8,10:3", help="buttons:runs for each set of demonstrations")
    parser.add_argument("--demonstrations", default="41,42,43", help="seeds of the sets")
    parser.add_argument("--first", type=int, default=51_000_000, help="seed of the starts")
    options = parser.parse_args()
    rows: list[dict[str, object]] = []
    with tempfile.TemporaryDirectory() as folder:
        sets = [int(s) for s in options.demonstrations.split(",")]
        for seed in sets:
            scenario = load_scenario(NAME.format(1), physics="environment", seed=seed)
            pieces = list(scenario.record_demonstrations())
            save(learn(scenario, pieces), Path(folder, str(seed)), scenario.name)
        for count, runs in (map(int, pair.split(":")) for pair in options.runs.split(",")):
            starts = [(s, options.first + 1000 * s + 100 * count + k) for s in sets for k in range(runs)]
            found = [one(Path(folder, str(s)), count, start) for s, start in starts]
            done, ticks, seconds = zip(*found, strict=True)
            interval = success_interval(sum(done), len(done)) or (0.0, 1.0)
            rows.append(
                {
                    "buttons": count,
                    "solved": f"{sum(done)} of {len(done)}",
                    "interval": "{:.3f} to {:.3f}".format(*interval),
                    "steps": np.nanmedian(ticks),
                    "most": np.nanmax(ticks),
                    "CPU [s]": np.median(seconds),
                }
            )
            print(pd.DataFrame(rows[-1:]).to_string(index=False, header=len(rows) == 1), flush=True)


if __name__ == "__main__":
    main()
