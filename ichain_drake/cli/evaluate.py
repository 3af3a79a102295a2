"""The command `evaluate`."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd
from rich.table import Table

from ichain_drake.cli.evaluation import Evaluation, run_evaluation, table_text
from ichain_drake.runs.clusters.workers import Workers
from ichain_drake.runs.intervals import success_interval, success_words
from ichain_drake.runs.paths.evaluation import (
    CURVE,
    FIRST_LINK,
    FULL,
    VARIANTS,
    check_evaluation,
    evaluate_paths,
)
from ichain_drake.runs.paths.shared import check_shared_evaluation, evaluate_shared_paths
from ichain_drake.scenarios import PathScenario

_REASONS = 3  # that are printed, the most frequent ones


def evaluate_path_scenario(
    scenario: PathScenario,
    overrides: Sequence[str],
    trials: int,
    methods: Sequence[str],
    workers: Workers,
    report: str | None,
    output: Path | None,
    *,
    shared: bool = False,
    resume: bool = False,
) -> None:
    """Evaluate, print one table, write the report and the learning curves.

    Args:
        scenario, overrides, trials, methods, workers: see `evaluate_paths`.
        report, output, resume: see `run_evaluation`.
        shared: whether all trials follow with what was learned from the demonstrations of the scenario's seed.

    Raises:
        InputError: on an unknown method, or a folder that can't be written.
        EvaluationInterrupted: on Ctrl-C, once the report on the seeds that were finished is written.
    """
    (check_shared_evaluation if shared else check_evaluation)(scenario, trials, methods)
    evaluate = evaluate_shared_paths if shared else evaluate_paths
    evaluation = Evaluation(
        scenario,
        trials,
        "seeds",
        "every seed was evaluated",
        evaluate=lambda say, rows: evaluate(scenario, overrides, trials, methods, workers, say, rows),
        text=lambda found: _format(scenario, found, shared=shared),
        pictures=lambda found, folder: _write_curves(found["rows"], scenario, folder),
        asked={"settings": list(overrides), "methods": list(methods), **({"shared": True} if shared else {})},
    )
    run_evaluation(evaluation, report, output, resume=resume)


def _format(scenario: PathScenario, found: Mapping[str, Any], *, shared: bool) -> str:
    table = found["table"]
    shown = f"all with the demonstrations of seed {scenario.seed}" if shared else "each with demonstrations of its own"
    parts = [_format_paths(scenario, [line for line in table if line["method"] != FIRST_LINK], shown)]
    parts.append(_format_link(scenario, [line for line in table if line["method"] == FIRST_LINK]))
    reasons = Counter(row["reason"] for row in found["rows"] if row["reason"])
    parts.append("\n".join(f"not completed: {reason} ({n} times)" for reason, n in reasons.most_common(_REASONS)))
    return "\n\n".join(part for part in parts if part)


def _format_link(scenario: PathScenario, table: Sequence[dict[str, Any]]) -> str:
    if not table:
        return ""
    view = Table("first link", "samples", f"rms error ({table[0]['unit']})", "largest of a seed", "held", box=None)
    for line in table:
        error = "-" if line["mean_error"] is None else f"{line['mean_error']:.4f} +- {line['std_error']:.4f}"
        largest = "-" if line["max_error"] is None else f"{line['max_error']:.4f}"
        view.add_row(
            line["case"],
            str(line["samples"]),
            error,
            largest,
            success_words(line["completed"], line["runs"], line["interval"]),
        )
    note = f"wanted against read states at the end of the first tick and of the next; {scenario.physics} physics"
    return table_text(view, note)


def _format_paths(scenario: PathScenario, table: Sequence[dict[str, Any]], shown: str) -> str:
    if not table:
        return ""
    cases = list(dict.fromkeys(line["case"] for line in table))
    view = Table("method", "samples", *(f"{c} ({scenario.unit})" for c in cases), "x oracle", "completed", box=None)
    lines: dict[tuple[str, int], dict[str, dict[str, Any]]] = {}
    for line in table:
        lines.setdefault((line["method"], line["samples"]), {})[line["case"]] = line
    for (method, samples), by_case in lines.items():
        cells, ratios = [], []
        for case in cases:
            found = by_case.get(case)
            if found is None or found["mean_error"] is None:
                cells.append("-")
            else:
                cells.append(f"{found['mean_error']:.3f} +- {found['std_error']:.3f}")
                ratios.append("-" if found["ratio_to_oracle"] is None else f"{found['ratio_to_oracle']:.2f}")
        done = sum(v["completed"] for v in by_case.values())
        runs = sum(v["runs"] for v in by_case.values())
        completed = success_words(done, runs, success_interval(done, runs))
        view.add_row(method, str(samples) if samples else "", *cells, " / ".join(ratios), completed)
    where = f"{scenario.name}, {scenario.physics} physics, seeds {table[0]['seeds']}"
    note = f"mean error over completed runs +- spread over seeds, {shown}; {where}"
    return table_text(view, f"{note}\nin brackets Wilson's 95 % interval")


def _write_curves(rows: Sequence[dict[str, Any]], scenario: PathScenario, folder: Path) -> None:
    from ichain_drake.visualization import plot_learning_curve

    curves = {v.method for v in VARIANTS if v.samples != FULL and v.samples in CURVE and not v.monolithic}
    frame = pd.DataFrame([r for r in rows if r["success"] and r["method"] in curves])
    if len(frame):
        file = folder / "learning_curve.png"
        plot_learning_curve(file, frame[["samples", "error", "method"]], unit=scenario.unit, logarithmic=True)
        print(f"written: {file}")
