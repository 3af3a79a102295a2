"""The command `evaluate`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pandas as pd
from rich.console import Console
from rich.table import Table

from ichain_drake.cli.console import Reporter
from ichain_drake.cli.run import deliver_report
from ichain_drake.scenarios import PathScenario
from ichain_drake.scenarios.path_evaluation import CURVE, evaluate_paths
from ichain_drake.scenarios.path_output import prepare_folder
from ichain_drake.scenarios.path_run import versions


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
    """
    if report not in (None, "-"):
        prepare_folder(Path(str(report)).parent)
    if output is not None:
        prepare_folder(output)
    with Reporter() as say:
        say(f"evaluating {scenario.name}, {trials} seeds")
        found = evaluate_paths(scenario, overrides, trials, methods, jobs, say)
    document = {
        "scenario": scenario.name,
        "physics": scenario.physics,
        "seed": scenario.seed,
        "trials": trials,
        "versions": versions(),
        "given": scenario.given(),
        **found,
    }
    deliver_report(document, report, text=_format(scenario, found["table"]))
    if output is not None:
        _write_curves(found["rows"], scenario, output)


def _format(scenario: PathScenario, table: Sequence[dict[str, Any]]) -> str:
    cases = list(dict.fromkeys(line["case"] for line in table))
    view = Table("method", "samples", *(f"{c} ({scenario.unit})" for c in cases), "x oracle", "completed", box=None)
    lines: dict[tuple[str, int], dict[str, dict[str, Any]]] = {}
    for line in table:
        lines.setdefault((line["method"], line["samples"]), {})[line["case"]] = line
    for (method, samples), by_case in lines.items():
        cells, ratios = [], []
        for case in cases:
            line = by_case.get(case)
            if line is None or line["mean_error"] is None:
                cells.append("-")
            else:
                cells.append(f"{line['mean_error']:.3f} +- {line['std_error']:.3f}")
                ratios.append("-" if line["ratio_to_oracle"] is None else f"{line['ratio_to_oracle']:.2f}")
        done = sum(v["completed"] for v in by_case.values())
        runs = sum(v["runs"] for v in by_case.values())
        view.add_row(method, str(samples) if samples else "", *cells, " / ".join(ratios), f"{done}/{runs}")
    console = Console(width=140)
    with console.capture() as capture:
        console.print(view)
        console.print(f"mean error over completed runs +- spread over seeds; {scenario.name}, {scenario.physics} physics")
    return capture.get().rstrip()


def _write_curves(rows: Sequence[dict[str, Any]], scenario: PathScenario, folder: Path) -> None:
    from ichain_drake.visualization import plot_learning_curve

    frame = pd.DataFrame([r for r in rows if r["success"] and r["samples"] in CURVE])
    if len(frame):
        file = folder / "learning_curve.png"
        plot_learning_curve(file, frame[["samples", "error", "method"]], unit=scenario.unit, logarithmic=True)
        print(f"written: {file}")
