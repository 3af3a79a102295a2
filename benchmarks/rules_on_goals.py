"""Which rules do goals need that nobody chose: `python benchmarks/rules_on_goals.py kettle --seed 70500 --jobs 2`.

Of each system several sets of demonstrations are recorded and learned from; the system's own goal and others, drawn
out of demonstrated rows (see `random_goals.py`), are planned and carried out with all rules, and once more without
each rule that was asked for. Where a rule of planning changes nothing in the only plan of a run it is not run again:
the outcome is the same. So more demonstrations and goals are seen than `ichain scoreboard --ablate` can afford, which
has faults and other physics instead; a rule goes only if neither needs it.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from joblib import Parallel, delayed
from random_goals import drawn
from threadpoolctl import threadpool_limits

import ichain_drake as ic
from ichain_drake import rules
from ichain_drake.cli.scoreboard import format_ablation
from ichain_drake.runs.goals.plan import make_plan
from ichain_drake.runs.goals.run import GraphRun, own_goal, run_graph
from ichain_drake.runs.goals.trial import outcome
from ichain_drake.runs.provenance import printed
from ichain_drake.runs.scoreboard.ablation import rule_lines
from ichain_drake.simulation.wiring import look

Row = dict[str, Any]


def carried_out(scenario: Any, model: ic.InteractionModel, goal: tuple[str, ...], number: int) -> Row:
    """One run's outcome."""
    run = GraphRun(scenario, goal, number=number)
    try:
        run_graph(run, known=model)
    except Exception as error:  # a run that breaks off is a finding, whatever raised
        failed = {"success": False, "error": None, "reason": str(error), "cause": type(error).__name__}
        return failed | {"silent": False, "control_steps": 0, "replans": -1, "probability": None}
    return outcome(run)


def way(model: ic.InteractionModel, goal: tuple[str, ...], start: Mapping[str, np.ndarray]) -> str:
    """What a plan does, to be compared."""
    try:
        plan = make_plan(model, goal, start)[1]
    except Exception as error:  # as in a run
        return repr(error)
    return repr([replace(s, predicted={}) for s in plan.steps] if isinstance(plan, ic.Plan) else plan)


def one(system: str, physics: Any, seed: int, goals: int, asked_for: frozenset[str]) -> list[Row]:
    """Every goal of one set of demonstrations, with all rules and without each."""
    with threadpool_limits(limits=1):
        scenario: Any = ic.load_scenario(system, physics=physics, seed=seed)
        pieces = list(scenario.record_demonstrations())
        model = ic.learn(scenario, pieces)
        shown, rng = pd.concat([p.table for p in pieces], ignore_index=True), np.random.default_rng(seed)
        out: list[Row] = []
        for number in range(goals):
            start = look(scenario.make_world(number))
            goal = (drawn(scenario, model, shown, start, rng),) if number else own_goal(scenario)
            about = {"row": system, "seed": f"{seed}/{number}", "goal": " and ".join(goal)}
            with rules.noted() as asked:
                complete = carried_out(scenario, model, goal, number)
            out.append(about | {"without": ""} | complete)
            planned = way(model, goal, start)
            for rule in sorted(asked & asked_for):
                with rules.without([rule]):
                    same = (
                        rules.RULES[rule].where == "control.planning"
                        and complete["replans"] == 0
                        and way(model, goal, start) == planned
                    )
                    row = complete if same else carried_out(scenario, model, goal, number)
                out.append(about | {"without": rule} | row)
        return out


def main() -> None:
    """Run, print what was lost or won and a table, and write the report."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("systems", nargs="+", help="such as water_dispenser")
    parser.add_argument("--physics", default="ideal", help="ideal, arm or contact")
    parser.add_argument("--rules", nargs="+", default=sorted(rules.RULES), help="all, if not given")
    parser.add_argument("--seed", type=int, default=0, help="of the first set of demonstrations; the others follow")
    parser.add_argument("--seeds", type=int, default=2, help="sets of demonstrations of each system")
    parser.add_argument("--goals", type=int, default=6, help="of each set, the system's own among them")
    parser.add_argument("--jobs", type=int, default=1, help="processes")
    parser.add_argument("--report", type=Path, help="JSON file")
    options = parser.parse_args()
    rules.check_names(options.rules)
    jobs = [(system, options.physics, options.seed + k) for k in range(options.seeds) for system in options.systems]
    work = (delayed(one)(*job, options.goals, frozenset(options.rules)) for job in jobs)
    rows: list[Row] = []
    for found in Parallel(options.jobs, return_as="generator")(work):
        rows += found
        complete = {row["seed"]: row for row in found if not row["without"]}
        for row in found:
            if row["without"] and row["success"] != complete[row["seed"]]["success"]:
                what = "won" if row["success"] else "lost"
                reason = row["reason"] or complete[row["seed"]]["reason"]
                print(
                    f"{what} without {row['without']}: {row['row']} {row['seed']}: {row['goal']}: {reason}", flush=True
                )
    reached = sum(row["success"] for row in rows if not row["without"])
    text = f"{reached} of {sum(not row['without'] for row in rows)} goals reached with all rules\n\n"
    text += format_ablation([line for line in rule_lines(rows, options.rules) if line["pairs"]])
    print(text)
    if options.report:
        numbers = " ".join(f"--{name} {getattr(options, name)}" for name in ("physics", "seed", "seeds", "goals"))
        some = f" --rules {' '.join(options.rules)}" if set(options.rules) != set(rules.RULES) else ""
        command = f"python benchmarks/rules_on_goals.py {' '.join(options.systems)} {numbers}{some}"
        options.report.write_text(json.dumps({**printed(text, command), "rows": rows}, indent=1))


if __name__ == "__main__":
    main()
