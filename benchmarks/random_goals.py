"""Goals that nobody chose: `python benchmarks/random_goals.py water_dispenser kettle --seeds 2 --goals 10 --jobs 2`.

Of each system several sets of demonstrations are recorded and learned from. A goal is what some row of them showed: one
variable, or two of different objects, at least part of the way from where they are at the start. It is planned and
carried out in `ideal` physics, from a start of its own, and counts when it holds in truth. What was shown need not be
possible from the start that was drawn (there is no more water than there is), so that refusals are printed with their
reasons, to be read.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from joblib import Parallel, delayed
from threadpoolctl import threadpool_limits

import ichain_drake as ic
from ichain_drake.demonstrations.columns import column
from ichain_drake.runs.goals.run import GraphRun, run_graph
from ichain_drake.runs.intervals import success_interval, success_words
from ichain_drake.runs.provenance import printed
from ichain_drake.simulation.wiring import look

SHARES = (0.3, 1.0)
"""Of the way to what was shown, at least and at most."""
PAIRS = 0.3
"""Share of goals that are about two objects."""
RANGE = 0.1
"""What is nearer to the start than this share of a variable's demonstrated range is no goal."""

Row = dict[str, Any]


def drawn(scenario: Any, model: ic.InteractionModel, rows: pd.DataFrame, start: Any, rng: np.random.Generator) -> str:
    """A goal out of a demonstrated row."""
    while True:
        shown, found = rows.iloc[int(rng.integers(len(rows)))], []
        for obj, space in scenario.graph.objects.items():
            if not scenario.graph.incoming(obj):
                continue
            for i, variable in enumerate(space.observable.variables):
                wide = model.high[obj][i] - model.low[obj][i]
                way = float(shown[column(obj, variable.name)]) - start[obj][i]
                rate = variable.role is not None and variable.role.kind == "change"  # nobody wants one in the end
                if not rate and wide > 50 * model.noise[obj][i] and abs(way) > RANGE * wide:
                    value = start[obj][i] + rng.uniform(*SHARES) * way
                    found.append((obj, f"{obj}.{variable.name} {'>=' if way > 0 else '<='} {value:.4g}"))
        several = len({obj for obj, _ in found}) > 1
        wanted = 2 if rng.random() < PAIRS and several else 1
        rng.shuffle(found)
        texts = dict(found)  # one of each object
        if len(texts) >= wanted:
            return " and ".join(list(texts.values())[:wanted])


def one(system: str, seed: int, goals: int) -> list[Row]:
    """Every goal of one set of demonstrations."""
    with threadpool_limits(limits=1):
        scenario: Any = ic.load_scenario(system, physics="ideal", seed=seed)
        pieces = list(scenario.record_demonstrations())
        model = ic.learn(scenario, pieces)
        rows, rng = pd.concat([p.table for p in pieces], ignore_index=True), np.random.default_rng(seed)
        out = []
        for number in range(goals):
            goal = drawn(scenario, model, rows, look(scenario.make_world(number)), rng)
            run, began = GraphRun(scenario, (goal,), number=number), time.process_time()
            run_graph(run, known=model)
            out.append(
                {
                    "system": scenario.name,
                    "seed": seed,
                    "goal": goal,
                    "planned": isinstance(run.plan, ic.Plan),
                    "probability": run.plan.probability if isinstance(run.plan, ic.Plan) else None,
                    "reached": run.goal_reached,
                    "steps": 0 if run.memory is None else run.memory.tick,
                    "plan_seconds": run.plan_seconds,
                    "seconds": time.process_time() - began,
                    "reason": run.reason,
                }
            )
        return out


def table(rows: Sequence[Row]) -> pd.DataFrame:
    """One line a system."""
    lines = []
    for name in [*dict.fromkeys(r["system"] for r in rows), "all"]:
        mine = [r for r in rows if name in ("all", r["system"])]
        planned, reached = sum(r["planned"] for r in mine), sum(r["reached"] for r in mine)
        expected = [r["probability"] for r in mine if r["planned"]]
        lines.append(
            {
                "system": name,
                "goals": len(mine),
                "planned": planned,
                "reached, of those planned": success_words(reached, planned, success_interval(reached, planned)),
                "expected": f"{np.mean(expected):.2f}" if expected else "-",
                "plan [s]": f"{np.median([r['plan_seconds'] for r in mine]):.1f}",
            }
        )
    return pd.DataFrame(lines)


def main() -> None:
    """Run, print what failed and a table, and write the report."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("systems", nargs="+", help="such as kettle, or FILE.py")
    parser.add_argument("--seed", type=int, default=0, help="of the first set of demonstrations")
    parser.add_argument("--seeds", type=int, default=2, help="sets of demonstrations")
    parser.add_argument("--goals", type=int, default=10, help="of each set")
    parser.add_argument("--jobs", type=int, default=1, help="processes")
    parser.add_argument("--report", type=Path, help="JSON file")
    options = parser.parse_args()
    jobs = [(s, options.seed + k) for s in options.systems for k in range(options.seeds)]
    found = Parallel(options.jobs)(delayed(one)(*job, options.goals) for job in jobs)
    rows = [row for part in found for row in part]
    for row in rows:
        if not row["reached"]:
            print(f"{row['system']} {row['seed']}: {row['goal']}: {row['reason']}")
    text = table(rows).to_string(index=False)
    print(text)
    if options.report:
        numbers = " ".join(f"--{name} {getattr(options, name)}" for name in ("seed", "seeds", "goals"))
        command = f"python benchmarks/random_goals.py {' '.join(options.systems)} {numbers}"
        options.report.write_text(json.dumps({**printed(text, command), "rows": rows}, indent=1))


if __name__ == "__main__":
    main()
