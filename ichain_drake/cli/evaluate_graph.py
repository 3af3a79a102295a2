"""The command `evaluate` for scenarios that are asked for a goal over their interaction graph."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd
from rich.table import Table

from ichain_drake.cli.evaluation import Evaluation, run_evaluation, table_text
from ichain_drake.errors import InputError
from ichain_drake.runs.clusters.workers import Workers
from ichain_drake.runs.goals.evaluation import GoalEvaluation, check_graph_evaluation, evaluate_goals
from ichain_drake.runs.goals.run import own_goal
from ichain_drake.runs.goals.trial import FRESH
from ichain_drake.runs.goals.variants import NUMBER
from ichain_drake.runs.intervals import success_words
from ichain_drake.scenarios.goal_scenario import GoalScenario


def evaluate_goal_scenario(
    scenario: GoalScenario,
    overrides: Sequence[str],
    trials: int,
    methods: Sequence[str],
    workers: Workers,
    report: str | None,
    output: Path | None = None,
    *,
    shared: bool = True,
    fresh: bool = False,
    resume: bool = False,
) -> None:
    """Evaluate the scenario's own goal, print the tables, write the report, into the folder `output` if not named.

    Raises:
        InputError: on an unknown method, a file that can't be written, or a scenario without a goal.
        EvaluationInterrupted: on Ctrl-C, once the report on the trials that were finished is written.
    """
    check_graph_evaluation(scenario, trials, methods)
    goal = own_goal(scenario)
    if not goal:
        raise InputError(f"{scenario.name} has no goal of its own to evaluate; set one in its file")
    what = GoalEvaluation(scenario, tuple(overrides), goal, trials, tuple(methods), workers, shared, fresh)
    evaluation = Evaluation(
        scenario,
        trials,
        "runs a line",
        "every trial was run",
        evaluate=lambda say, rows: evaluate_goals(what, say, rows),
        text=lambda found: format_evaluation(scenario, found),
        pictures=lambda found, folder: _write_curve(found["rows"], folder),
        asked={"settings": list(overrides), "methods": list(methods), "goal": list(goal)},
        more={"goal": list(goal)},
    )
    run_evaluation(evaluation, report, output, resume=resume)


def _write_curve(rows: Sequence[Mapping[str, Any]], folder: Path) -> None:
    """How success grows with the number of pieces, as `pieces.png`, if there are runs with fewer pieces."""
    from ichain_drake.visualization import plot_success_curve

    columns = ("pieces", "success", "control_steps")
    frame = pd.DataFrame([{c: r[c] for c in columns} for r in rows if r["method"] == NUMBER])
    if len(frame):
        plot_success_curve(folder / "pieces.png", frame)
        print(f"written: {folder / 'pieces.png'}")


def format_evaluation(scenario: GoalScenario, found: Mapping[str, Any]) -> str:
    """The tables as text."""
    parts = [_trials(found["table"]), _classifiers(found["classifiers"], found["held_out"])]
    parts += [f"case {case} is left out: {reason}" for case, reason in found["skipped"].items()]
    parts.append(f"{scenario.name}, {scenario.physics} physics, seed {scenario.seed}")
    return "\n\n".join(part for part in parts if part)


def _trials(table: Sequence[Mapping[str, Any]]) -> str:
    if not table:
        return ""
    view = Table(
        "method",
        "case",
        "demonstrations",
        "seeds",
        "reached",
        "silent",
        "steps",
        "replans",
        "causes of failure",
        box=None,
    )
    for line in table:
        steps = "-" if line["median_steps"] is None else f"{line['median_steps']:.0f}"
        causes = ", ".join(f"{cause} {n}" for cause, n in line["causes"].items())
        reached = success_words(line["reached"], line["runs"], line["interval"])
        seeds = line["seeds"] if line["demonstrations"] == FRESH else f"runs {line['seeds']}"
        view.add_row(
            line["method"], line["case"], line["demonstrations"], seeds, reached, str(line["silent"]), steps,
            f"{line['mean_replans']:.1f}", causes,
        )  # fmt: skip
    note = (
        "reached: in truth, with Wilson's 95 % interval; silent: ended as if it were; steps: median where reached; "
        "replans: mean"
    )
    return table_text(view, note)


def _classifiers(lines: Sequence[Mapping[str, Any]], held_out: Mapping[str, Any]) -> str:
    if not lines:
        return ""
    view = Table(
        "interaction", "status F1", "near-miss F1", "as read (true gate)", "switching F1", "events", "rows", box=None
    )
    for line in lines:
        view.add_row(
            line["interaction"],
            _figure(line["status_f1"]),
            *_near_misses(line),
            _figure(line["event_f1"]),
            str(line["events"]),
            str(line["rows"]),
        )
        for moved, figures in line["borders"].items():
            view.add_row(f"  by {moved}", "", *_near_misses(figures), "", "", "")
    note = (
        f"on {held_out['pieces']} held-out pieces of {len(held_out['seeds'])} other seeds; near misses beside as many "
        "states inside; switching within one step"
    )
    return table_text(view, note)


def _near_misses(line: Mapping[str, Any]) -> tuple[str, str]:
    near, read, gate = (_figure(line[k]) for k in ("near_miss_f1", "near_miss_read_f1", "gate_read_f1"))
    return near, "-" if line["near_misses"] is None else f"{read} ({gate})"


def _figure(value: float | None) -> str:
    return "-" if value is None else f"{value:.3f}"
