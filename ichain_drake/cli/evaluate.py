"""The command `evaluate`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pandas as pd
from rich.table import Table

from ichain_drake.cli.evaluation import Evaluation, run_evaluation, table_text
from ichain_drake.runs.paths.evaluation import (
    CURVE,
    FIRST_LINK,
    FULL,
    VARIANTS,
    check_evaluation,
    evaluate_paths,
)
from ichain_drake.scenarios import PathScenario


def evaluate_path_scenario(
    scenario: PathScenario,
    overrides: Sequence[str],
    trials: int,
    methods: Sequence[str],
    jobs: int,
    report: str | None,
    output: Path | None,
) -> None:
    """Evaluate, print one table, write the report and the learning curves.

    Raises:
        InputError: on an unknown method, or a folder that can't be written.
        EvaluationInterrupted: on Ctrl-C, once the report on the seeds that were finished is written.
    """
    check_evaluation(scenario, trials, methods, jobs)
    evaluation = Evaluation(
        scenario,
        trials,
        "seeds",
        "every seed was evaluated",
        evaluate=lambda say: evaluate_paths(scenario, overrides, trials, methods, jobs, say),
        text=lambda found: _format(scenario, found["table"]),
        pictures=lambda found, folder: _write_curves(found["rows"], scenario, folder),
    )
    run_evaluation(evaluation, report, output)


def _format(scenario: PathScenario, table: Sequence[dict[str, Any]]) -> str:
    parts = [_format_paths(scenario, [line for line in table if line["method"] != FIRST_LINK])]
    parts.append(_format_link(scenario, [line for line in table if line["method"] == FIRST_LINK]))
    return "\n\n".join(part for part in parts if part)


def _format_link(scenario: PathScenario, table: Sequence[dict[str, Any]]) -> str:
    if not table:
        return ""
    view = Table("first link", "samples", f"rms error ({table[0]['unit']})", "largest of a seed", "held", box=None)
    for line in table:
        error = "-" if line["mean_error"] is None else f"{line['mean_error']:.4f} +- {line['std_error']:.4f}"
        largest = "-" if line["max_error"] is None else f"{line['max_error']:.4f}"
        view.add_row(line["case"], str(line["samples"]), error, largest, f"{line['completed']}/{line['runs']}")
    note = f"wanted against read states at the end of the first tick and of the next; {scenario.physics} physics"
    return table_text(view, note)


def _format_paths(scenario: PathScenario, table: Sequence[dict[str, Any]]) -> str:
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
        view.add_row(method, str(samples) if samples else "", *cells, " / ".join(ratios), f"{done}/{runs}")
    where = f"{scenario.name}, {scenario.physics} physics"
    return table_text(view, f"mean error over completed runs +- spread over seeds; {where}")


def _write_curves(rows: Sequence[dict[str, Any]], scenario: PathScenario, folder: Path) -> None:
    from ichain_drake.visualization import plot_learning_curve

    curves = {v.method for v in VARIANTS if v.samples != FULL and v.samples in CURVE and not v.monolithic}
    frame = pd.DataFrame([r for r in rows if r["success"] and r["method"] in curves])
    if len(frame):
        file = folder / "learning_curve.png"
        plot_learning_curve(file, frame[["samples", "error", "method"]], unit=scenario.unit, logarithmic=True)
        print(f"written: {file}")
