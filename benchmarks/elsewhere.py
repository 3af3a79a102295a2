"""Where nothing was demonstrated: `python benchmarks/elsewhere.py --seed 70400 --trials 20 --jobs 2`.

Every trial has demonstrations of its own, at the ordinary places. Then either two things stand elsewhere together (a
bottle and a kettle; a dispenser and a cup), moved by up to 15 cm and turned by up to 40 degrees about the middle
between them, or one stands alone 15 cm or more from any place at which a demonstration had it. Places are drawn at
random, within the hand's reach (where there is an arm: where that can hold a thing as demonstrations held it when they
took it and when they began to pour), and off what else stands there and the edge of the plate that the kettle heats on.
The system's own goal is planned and carried out.
"""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from joblib import Parallel, delayed
from threadpoolctl import threadpool_limits

import ichain_drake as ic
from ichain_drake.demonstrations.columns import column
from ichain_drake.motion_query import MotionQuery
from ichain_drake.runs.goals.run import GraphRun, own_goal, run_graph
from ichain_drake.runs.intervals import success_interval, success_words
from ichain_drake.runs.provenance import printed
from ichain_drake.simulation.wiring import look
from ichain_drake.state import FloatArray
from ichain_drake.systems.water_dispenser.layout import LAYOUT, MIDDLE

MOVED, TURNED, ALONE = 0.15, math.radians(40.0), 0.15
"""At most [m], at most [rad]; at least [m]."""
REACH = ((0.34, 0.79), (-0.42, 0.35))
"""Where a vessel can be taken, x and y in the robot's frame [m]."""
PLATE, ON, OFF = (0.735, 0.13), 0.03, 0.14
"""Middle of what a kettle stands on, and how near to it, or far from it, a kettle doesn't tip over its edge [m]."""
PAIRS = {"kettle": ("bottle", "kettle"), "water_dispenser": ("cup", "machine")}
STANDING = {  # what nothing may be put on: middle and how far from it, in the robot's frame [m]
    "kettle": {"switch": ((0.5, 0.22), 0.14), "kettle": (PLATE, OFF)},
    "water_dispenser": {"buttons": ((0.5, 0.22), 0.14), "machine": (MIDDLE, 0.17)},
}
Row = dict[str, Any]


def reachable(*places: FloatArray) -> bool:
    """Whether all are within reach."""
    return all(low <= p[i] <= high for p in places for i, (low, high) in enumerate(REACH))


def together(scenario: Any, rng: np.random.Generator) -> list[str]:
    """Settings that put two things somewhere else."""
    pair, start = PAIRS[scenario.name], scenario.config.start
    old = [np.array(MIDDLE if name == "machine" else getattr(start, name)) for name in pair]
    middle, (fixed, away) = np.mean(old, axis=0), next(iter(STANDING[scenario.name].values()))
    while True:
        angle, way = rng.uniform(-TURNED, TURNED), rng.uniform(-MOVED, MOVED, 2)
        turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
        new = [middle + way + turn @ (p - middle) for p in old]
        taken = [*new[:-1], new[-1] + turn @ (np.array(LAYOUT.outlet[:2]) - MIDDLE)] if "machine" in pair else new
        clear = min(float(np.linalg.norm(p - fixed)) for p in new) > away
        if "kettle" in pair:
            clear = clear and not ON < float(np.linalg.norm(new[-1] - PLATE)) < OFF
        if np.linalg.norm(way) <= MOVED and clear and reachable(*taken):
            out = [
                f"start.{name}={p.round(4).tolist()}" for name, p in zip(pair, new, strict=True) if name != "machine"
            ]
            if "machine" in pair:
                shift = (new[-1] - MIDDLE).round(4).tolist()
                out += [f"machine.shift={shift}", f"machine.turn_deg={math.degrees(angle):.2f}"]
            return out


def alone(scenario: Any, pieces: Sequence[ic.Demonstration], rng: np.random.Generator) -> list[str]:
    """Settings that put one thing far from where any demonstration had it, or as far as reach allows."""
    name = PAIRS[scenario.name][0]
    tables = [p.table[p.table[f"hand->{name}"] < 0.5] for p in pieces]  # noqa: PLR2004 - a flag
    seen = np.concatenate([t[[column(name, a) for a in "xyz"]].to_numpy() for t in tables])
    shown = scenario.camera().to_robot(seen)[:, :2]
    places = np.array(np.meshgrid(*(np.arange(low, high, 0.01) for low, high in REACH))).reshape(2, -1).T
    for middle, away in STANDING[scenario.name].values():
        places = places[np.linalg.norm(places - middle, axis=1) > away]
    far = np.linalg.norm(places[:, None] - shown[None], axis=2).min(axis=1)
    place = places[rng.choice(np.flatnonzero(far >= min(ALONE, far.max())))]
    return [f"start.{name}={place.round(4).tolist()}"]


def held(scenario: Any, pieces: Sequence[ic.Demonstration], switched: str, thing: str) -> FloatArray:
    """The hand's state where demonstrations switched an interaction on, its place relative to a thing's, one a row."""
    hand, rows = scenario.graph.objects["hand"].observable, []
    for table in (p.table for p in pieces):
        on = table[switched].to_numpy() > 0.5  # noqa: PLR2004 - a flag
        at = table[on & ~np.append(True, on[:-1])]
        rows.append(at[[column("hand", v) for v in hand.names]].to_numpy(copy=True))
        rows[-1][:, :3] -= scenario.camera().to_robot(at[[column(thing, v) for v in "xyz"]].to_numpy())
    return np.concatenate(rows)


def within_arm(moved: Any, pieces: Sequence[ic.Demonstration], names: Sequence[str]) -> bool:
    """Whether the arm, if there is one, can take things where they stand, and pour into what stands there."""
    motion, world = moved.make_motion(), moved.make_world(0)
    if motion is None:
        return True
    start = look(world)
    kinds = [(f"hand->{n}", n) for n in names if n != "machine"]
    kinds += [("bottle->kettle", "kettle"), ("kettle->bottle", "bottle")] if "kettle" in names else []
    for switched, thing in kinds:
        goal = np.median(held(moved, pieces, switched, thing), axis=0)
        goal[:3] += moved.camera().to_robot(start[thing][:3])
        goal[-1] = 0.0  # the hand open
        try:
            motion.path(MotionQuery(start["hand"], goal))
        except ic.UnreachableError:
            return False
    return True


def one(case: str, system: str, physics: Any, seed: int) -> Row:
    """Demonstrations, learning and a run."""
    with threadpool_limits(limits=1):
        seen = ["machine.seen=true"] if case == "together" and system == "water_dispenser" else []
        scenario: Any = ic.load_scenario(system, seen, physics=physics, seed=seed)
        pieces, rng = list(scenario.record_demonstrations()), np.random.default_rng(seed)
        pair = PAIRS[system] if case == "together" else PAIRS[system][:1]
        while True:
            settings = together(scenario, rng) if case == "together" else alone(scenario, pieces, rng)
            moved: Any = ic.load_scenario(system, [*seen, *settings], physics=physics, seed=seed)
            if within_arm(moved, pieces, pair):
                break
        run = GraphRun(moved, own_goal(moved))
        run_graph(run, known=ic.learn(scenario, pieces))
        return {
            "case": case,
            "system": system,
            "physics": physics,
            "seed": seed,
            "settings": settings,
            "planned": isinstance(run.plan, ic.Plan),
            "probability": run.plan.probability if isinstance(run.plan, ic.Plan) else None,
            "reached": run.goal_reached,
            "reason": run.reason,
        }


def table(rows: Sequence[Row]) -> pd.DataFrame:
    """One line a case, system and physics."""
    lines = []
    for key, group in pd.DataFrame(rows).groupby(["case", "system", "physics"], sort=False):
        n, reached = len(group), int(group["reached"].sum())
        pair = PAIRS[str(key[1])]
        lines.append(
            {
                "moved": " and ".join(pair) if key[0] == "together" else pair[0],
                "system": key[1],
                "physics": key[2],
                "trials": n,
                "planned": int(group["planned"].sum()),
                "reached": success_words(reached, n, success_interval(reached, n)),
            }
        )
    return pd.DataFrame(lines)


def main() -> None:
    """Run, print what failed and a table, and write the report."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=0, help="of the first trial; the others follow")
    parser.add_argument("--trials", type=int, default=4, help="of each line in `ideal`")
    parser.add_argument("--contact", type=int, default=0, help="the same by contact, where that can be moved")
    parser.add_argument("--jobs", type=int, default=1, help="processes")
    parser.add_argument("--report", type=Path, help="JSON file")
    options = parser.parse_args()
    cases = [(case, system, "ideal", options.trials) for case in ("together", "alone") for system in PAIRS]
    cases += [("together", "kettle", "contact", options.contact)]
    cases += [("alone", system, "contact", options.contact) for system in PAIRS]
    jobs = [(case, system, physics, options.seed + k) for case, system, physics, n in cases for k in range(n)]
    rows: list[Row] = []
    for row in Parallel(options.jobs, return_as="generator")(delayed(one)(*job) for job in jobs):
        rows.append(row)
        if not row["reached"]:
            print(
                ", ".join(f"{row[k]}" for k in ("case", "system", "physics", "seed", "settings", "reason")), flush=True
            )
    text = table(rows).to_string(index=False)
    print(text)
    if options.report:
        numbers = " ".join(f"--{name} {getattr(options, name)}" for name in ("seed", "trials", "contact"))
        command = f"python benchmarks/elsewhere.py {numbers}"
        options.report.write_text(json.dumps({**printed(text, command), "rows": rows}, indent=1))


if __name__ == "__main__":
    main()
