"""A goal that needs every machine: `python benchmarks/many_machines.py 1 2 4 8 --run 4`.

So many dispensers stand in a row, each with cold water, and every tank is to be hot (`two_dispensers` with
`machines`, `ideal` physics). Printed are how long learning and planning take, by processor time, with a power of
the number of machines that fits the planning, and for `--run` whether the plan holds when it is carried out.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from threadpoolctl import threadpool_limits

import ichain_drake as ic
from ichain_drake.control.planning.goals import parse_goal
from ichain_drake.objects import WorldObject
from ichain_drake.runs.goals.run import GraphRun, run_graph
from ichain_drake.runs.provenance import printed
from ichain_drake.scenarios.object_maker import ObjectMaker
from ichain_drake.simulation.wiring import look, make_planner
from ichain_drake.systems.two_dispensers.scenario import MachineStart, TwoDispensers, TwoDispensersConfig
from ichain_drake.systems.water_dispenser.layout import DispenserStart

FILLED, HOT = 0.5, 0.6
"""How much is in each tank at the start, and how hot all are to be: shares of what a tank holds, and of boiling."""


class FilledDispensers(TwoDispensers):
    """Machines whose tanks are full of cold water when a run starts; demonstrations are those of `two_dispensers`."""

    def make_objects(self, start: DispenserStart, make: ObjectMaker) -> Mapping[str, WorldObject]:
        """See `TwoDispensers`."""
        objects = dict(super().make_objects(start, make))
        if not isinstance(start, MachineStart):
            full = replace(start, tank_amount=FILLED)
            for m in self.machines:
                tank = self._names(m)[-1]
                objects[tank] = self.make_tank(tank, full, make, self._tank_settings(m))
        return objects


def one(machines: int, seed: int, executed: bool) -> dict[str, Any]:
    """Record, learn, plan and, if wanted, run."""
    last = 0.45 - 0.2 + TwoDispensersConfig.spacing * (machines - 1)
    settings = [f"machines={machines}", f"robot.hand.bounds={{x: [0.3, 0.8], y: [{last - 0.75}, 0.45], z: [0.0, 0.6]}}"]
    scenario = FilledDispensers(settings, "ideal", seed)
    goal = tuple(f"{m}_tank.temperature >= {HOT}" for m in scenario.machines)
    pieces, began = list(scenario.record_demonstrations()), time.process_time()
    model = ic.learn(scenario, pieces)
    learned, began = time.process_time() - began, time.process_time()
    start = look(scenario.make_world(0))
    found = make_planner(model).plan(start, parse_goal(goal, model, start))
    planning, plan = time.process_time() - began, found if isinstance(found, ic.Plan) else None
    row = {
        "machines": machines,
        "learn": learned,
        "plan": planning,
        "steps": len(plan.steps) if plan else 0,
        "probability": plan.probability if plan else 0.0,
        "executed": "-" if plan else getattr(found, "reason", ""),
    }
    if executed and plan:
        run = GraphRun(scenario, goal)
        run_graph(run, known=model)
        assert run.memory is not None
        row["executed"] = f"{'reached' if run.goal_reached else run.reason}, {run.memory.replans} new plans"
    return row


def main() -> None:
    """Print a line a number of machines, and how planning grows; write the report."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("machines", nargs="+", type=int, help="how many; several in a row")
    parser.add_argument("--run", type=int, nargs="*", default=[], help="of these, which are carried out")
    parser.add_argument("--seed", type=int, default=0, help="of demonstrations and start")
    parser.add_argument("--report", type=Path, help="JSON file")
    options = parser.parse_args()
    rows = []
    with threadpool_limits(limits=1):
        for number in options.machines:
            rows.append(one(number, options.seed, number in options.run))
            print(rows[-1], flush=True)
    view = pd.DataFrame(rows).rename(columns={"learn": "learn [s]", "plan": "plan [s]"})
    text = view.to_string(index=False, float_format="{:.2f}".format)
    if len(rows) > 1:
        power = np.polyfit(np.log([r["machines"] for r in rows]), np.log([r["plan"] for r in rows]), 1)[0]
        text += f"\n\nplanning grows with the power {power:.1f} of the number of machines"
    print(text)
    if options.report:
        chosen = " ".join(map(str, options.machines)) + (
            f" --run {' '.join(map(str, options.run))}" * bool(options.run)
        )
        command = f"python benchmarks/many_machines.py {chosen} --seed {options.seed}"
        options.report.write_text(json.dumps({**printed(text, command), "rows": rows}, indent=1))


if __name__ == "__main__":
    main()
