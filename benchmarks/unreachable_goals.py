"""Goals that can't be reached, and why: `python benchmarks/unreachable_goals.py --seed 0`.

Each is asked of a model that was learned from fresh demonstrations; it has to be refused, with the reason why it is
out of reach. Goals that can be reached are the matter of `random_goals.py`.
"""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from joblib import Parallel, delayed
from threadpoolctl import threadpool_limits

import ichain_drake as ic
from ichain_drake.errors import InputError
from ichain_drake.runs.goals.plan import make_plan
from ichain_drake.runs.goals.settings import planner_of
from ichain_drake.runs.intervals import success_interval, success_words
from ichain_drake.runs.provenance import printed
from ichain_drake.simulation.wiring import look

OUTSIDE = Path(__file__).parent.parent / "tests" / "helpers" / "outside"
TOO_MUCH, MOMENTARY, BOUND, NEVER = "there is only", "does not keep its value", "is bounded there", "was never beyond"
NOTHING, NO_VALUE, EDGE, NEAREST = "no interaction was seen to change", "no value of", "inactive together", "nearest"
GOALS = {
    "water_dispenser": [
        ("cup.water >= 0.6 and tank.amount >= 0.6", TOO_MUCH),
        ("cup.temperature >= 0.5 and cup.temperature <= 0.3", NO_VALUE),
        ("dispense.level >= 3", MOMENTARY),
        ("tank.temperature >= 0.9 and power.level >= 3", MOMENTARY),
        ("cup.x >= 1.5", NEVER),
        ("cup.water >= 1.2", BOUND),
        ("tank.temperature <= 0.02", NEAREST),
        ("cup.z >= 0.3 and not hand->cup", EDGE),
        ("hand->power", "can't carry power"),
    ],
    "kettle": [
        ("bottle.water >= 0.6 and kettle.water >= 0.6", TOO_MUCH),
        ("kettle.temperature <= 0.01", NEAREST),
        ("bottle.z >= 0.3 and kettle.z >= 0.2", "together with the other conditions"),
        ("hand->bottle and hand->kettle", "one object at a time"),
        ("switch.level >= 3", MOMENTARY),
        ("bottle.temperature >= 0.9 and kettle.temperature <= 0.2", "together with the other conditions"),
        ("kettle.x >= 2", NEVER),
        ("kettle->bottle and not hand->kettle", EDGE),
    ],
    "microwave": [
        ("food.temperature >= 0.6 and food.temperature <= 0.2", NO_VALUE),
        ("door.y >= 0.4", NEAREST),
        ("knob.y >= 0.2", NOTHING),
        ("food.temperature <= -0.5", BOUND),
        ("door.z >= 0.1", NOTHING),
        ("hand.x >= 2", "is the robot"),
    ],
    str(OUTSIDE / "crane.py"): [
        ("platform.z >= 0.5", NEAREST),
        ("winch.turn <= -5", BOUND),
        ("crank.engaged >= 1", MOMENTARY),
        ("platform.x >= 0.7", NOTHING),
    ],
    str(OUTSIDE / "lock_place.py"): [
        ("drawer.x >= 0.7", NEAREST),
        ("drawer.y >= 0.5", NOTHING),
        ("weight.z >= 0.15 and not hand->weight", EDGE),
        ("key.angle >= 3", BOUND),
    ],
}


def asked(system: str, seed: int) -> list[dict[str, Any]]:
    """What is said to the goals of a system."""
    with threadpool_limits(limits=1):
        scenario: Any = ic.load_scenario(system, physics="ideal", seed=seed)
        model = ic.learn(scenario, list(scenario.record_demonstrations()))
        start, planner, rows = look(scenario.make_world(0)), planner_of(scenario.config), []
        for goal, why in GOALS[system]:
            began = time.process_time()
            try:
                _, found = make_plan(model, (goal,), start, planner)
                said = "a plan" if isinstance(found, ic.Plan) else found.reason
            except InputError as error:
                said = str(error)
            seconds = time.process_time() - began
            rows.append({"system": scenario.name, "goal": goal, "said": said, "true": why in said, "seconds": seconds})
    return rows


def main() -> None:
    """Ask, print every answer and how many are true, and write the report."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=0, help="of the demonstrations")
    parser.add_argument("--jobs", type=int, default=1, help="processes")
    parser.add_argument("--report", type=Path, help="JSON file")
    options = parser.parse_args()
    rows = [r for part in Parallel(options.jobs)(delayed(asked)(s, options.seed) for s in GOALS) for r in part]
    for row in rows:
        print(f"{'' if row['true'] else 'NOT TRUE: '}{row['system']}: {row['goal']}\n    {row['said']}")
    true, seconds = sum(r["true"] for r in rows), [r["seconds"] for r in rows]
    counted = success_words(true, len(rows), success_interval(true, len(rows)))
    text = f"refused with the true reason: {counted}; {np.median(seconds):.1f} s, at most {max(seconds):.1f} s"
    print(text)
    if options.report:
        command = f"python benchmarks/unreachable_goals.py --seed {options.seed}"
        options.report.write_text(
            json.dumps({**printed(text, command), "rows": pd.DataFrame(rows).to_dict("records")}, indent=1)
        )


if __name__ == "__main__":
    main()
