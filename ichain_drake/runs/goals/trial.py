"""One trial of an evaluation over an interaction graph: a run with what was learned before, as one row."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from ichain_drake.control.execution.executor import ExecutorSettings
from ichain_drake.control.execution.tasks import Mode
from ichain_drake.control.planning.goals import gap, value_of
from ichain_drake.control.planning.model import span
from ichain_drake.control.planning.plan import Plan
from ichain_drake.graph import InteractionGraph
from ichain_drake.learning import InteractionModel
from ichain_drake.robot import Physics
from ichain_drake.runs.clusters.isolated import reason_of
from ichain_drake.runs.goals.run import GraphRun, run_graph
from ichain_drake.runs.intervals import seed_words, success_interval
from ichain_drake.scenarios.base import Scenario
from ichain_drake.state import StateSpace

MISJUDGED, LEARNING, ERROR = "misjudged", "learning", "error"
"""Causes of failure that no controller names: it stopped as if done, nothing was learned, or the run broke off."""

FRESH = "fresh"
"""Demonstrations that are the trial's own, of the seed of its row."""


@dataclasses.dataclass(frozen=True)
class Trial:
    """What one trial runs.

    Attributes:
        method: name in the report.
        case: name in the report.
        kind: the scenario's class; a worker process makes its own.
        overrides: settings, with those of the case.
        physics: of the world.
        seed: of the scenario; with `number` it keys start, noise and faults.
        number: of the run.
        goal: as text.
        monitors: whether the controller watches what it does.
        pieces: number of pieces that were learned from.
        fresh: whether the demonstrations are this trial's own, and not shared with others.
    """

    method: str
    case: str
    kind: type[Scenario]
    overrides: tuple[str, ...]
    physics: Physics
    seed: int
    number: int
    goal: tuple[str, ...]
    monitors: bool
    pieces: int
    fresh: bool = False

    def row(self) -> dict[str, Any]:
        """A row without success."""
        return {
            "method": self.method,
            "physics": self.physics,
            "case": self.case,
            "seed": self.seed if self.fresh else self.number,
            "demonstrations": FRESH if self.fresh else f"seed {self.seed}",
            "success": False,
            "error": None,
            "reason": "",
            "cause": "",
            "silent": False,
            "control_steps": 0,
            "replans": 0,
            "probability": None,
            "pieces": self.pieces,
        }

    def failed(self, reason: str) -> dict[str, Any]:
        """The row of a trial that raised."""
        return self.row() | {"reason": reason, "cause": ERROR}


def run_trial(trial: Trial, model: InteractionModel | str) -> dict[str, Any]:
    """One row.

    Args:
        trial: what to run.
        model: what was learned; or why nothing was.
    """
    return timed_trial(trial, model)[0]


def timed_trial(trial: Trial, model: InteractionModel | str) -> tuple[dict[str, Any], float]:
    """One row, and the processor time that planning took in its run [s]; arguments as for `run_trial`."""
    if isinstance(model, str):
        return trial.row() | {"reason": model, "cause": LEARNING}, 0.0
    with threadpool_limits(limits=1):
        try:
            scenario = trial.kind(trial.overrides, trial.physics, trial.seed)
            run = GraphRun(scenario, trial.goal, number=trial.number)  # type: ignore[arg-type]
            run_graph(run, known=model, settings=ExecutorSettings(monitors=trial.monitors))
        except Exception as error:  # a trial that breaks off is a finding, whatever raised
            return trial.failed(reason_of(error)), 0.0
    return trial.row() | outcome(run), run.plan_seconds


def outcome(run: GraphRun) -> dict[str, Any]:
    """What a finished run adds to its row.

    `error` is the largest distance of a condition from its range, in truth at the end, as a share of the variable's
    demonstrated range. A failure is silent if the controller came to its end as if the goal held, or gave no reason.
    `probability` is what the first plan said of its success; None where there was no plan.
    """
    assert run.memory is not None
    reached = run.goal_reached
    return {
        "success": reached,
        "error": _miss(run),
        "reason": "" if reached else run.reason,
        "cause": "" if reached else run.cause,
        "silent": not reached and (run.memory.mode == Mode.REACHED or not run.reason),
        "control_steps": run.memory.tick,
        "replans": run.memory.replans,
        "probability": run.plan.probability if isinstance(run.plan, Plan) else None,
    }


def _miss(run: GraphRun) -> float | None:
    if run.log is None or run.goal is None or run.model is None:
        return None
    graph = run.scenario.graph
    last = {n: s[-1][graph.objects[n].observable_indices] for n, s in run.log.states.items()}
    away = [0.0]
    for c in run.goal.conditions:
        index = run.model.graph.objects[c.object].observable.index(c.variable)
        away.append(float(gap(c, value_of(c, last, graph))) / float(span(run.model, c.object)[index]))
    return float(np.max(away))


def without_roles(graph: InteractionGraph) -> InteractionGraph:
    """The same graph, in which no variable says what it is; names, units, bounds and kinds stay."""
    objects = {
        name: StateSpace(space.type, tuple(dataclasses.replace(v, role=None) for v in space.variables))
        for name, space in graph.objects.items()
    }
    return InteractionGraph(objects, graph.interactions)


def summarise(rows: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """One line per method, case and sort of demonstrations.

    Returns:
        Of each: runs, reached with Wilson's interval, silent failures, median steps, mean replans, causes of failure,
        and whose demonstrations they had: `fresh` ones, or those of one seed.
    """
    groups: dict[tuple[str, str, str], list[dict[str, Any]]] = {}
    for row in rows:
        groups.setdefault((row["method"], row["case"], row["demonstrations"]), []).append(row)
    table = []
    for (method, case, demonstrations), group in groups.items():
        done = [r for r in group if r["success"]]
        causes: dict[str, int] = {}
        for r in group:
            if not r["success"]:
                causes[r["cause"] or "unknown"] = causes.get(r["cause"] or "unknown", 0) + 1
        table.append(
            {
                "method": method,
                "case": case,
                "demonstrations": demonstrations,
                "seeds": seed_words(r["seed"] for r in group),
                "runs": len(group),
                "reached": len(done),
                "interval": success_interval(len(done), len(group)),
                "silent": sum(r["silent"] for r in group),
                "median_steps": float(np.median([r["control_steps"] for r in done])) if done else None,
                "mean_replans": float(np.mean([r["replans"] for r in group])),
                "causes": dict(sorted(causes.items(), key=lambda item: (-item[1], item[0]))),
            }
        )
    return table
