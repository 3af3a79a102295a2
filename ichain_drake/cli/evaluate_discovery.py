"""The command `evaluate` with `--methods labels,edges,cuts`: what is found out of states alone."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from rich.table import Table

from ichain_drake.cli.evaluation import Evaluation, run_evaluation, table_text
from ichain_drake.runs.clusters.workers import Workers
from ichain_drake.runs.discovery import DiscoveryEvaluation, evaluate_discovery
from ichain_drake.scenarios.base import Scenario

_F1 = ("f1_all", "f1_shown", "f1_switchings")


def evaluate_discovery_of(
    scenario: Scenario,
    overrides: Sequence[str],
    trials: int,
    methods: Sequence[str],
    workers: Workers,
    report: str | None,
    output: Path | None = None,
    *,
    resume: bool = False,
) -> None:
    """Evaluate, print the table, write the report.

    Raises:
        InputError: on other methods, or a file that can't be written.
        EvaluationInterrupted: on Ctrl-C, once the report on what was finished is written.
    """
    what = DiscoveryEvaluation(scenario, tuple(overrides), trials, tuple(methods), workers)
    what.check()
    evaluation = Evaluation(
        scenario,
        trials,
        "seeds",
        "every seed was evaluated",
        evaluate=lambda say, rows: evaluate_discovery(what, say, rows),
        text=lambda found: format_discovery(scenario, found),
        pictures=lambda found, folder: None,
        asked={"settings": list(overrides), "methods": list(methods)},
    )
    run_evaluation(evaluation, report, output, resume=resume)


def format_discovery(scenario: Scenario, found: Mapping[str, Any]) -> str:
    """The table as text, and below it what was missed or added on each seed."""
    view = Table(
        "method", "seeds", "exact", "mean SHD", "precision", "recall", "F1 rows", "F1 shown", "F1 switchings",
        "goals", "with flags", "processor (s)", box=None,
    )  # fmt: skip
    for line in found["table"]:
        keys = ("mean_shd", "precision", "recall", *_F1, "reached", "reached_with_flags", "seconds")
        cells = ["-" if line[k] is None else f"{line[k]:.3g}" for k in keys]
        view.add_row(line["method"], str(line["seeds"]), str(line["exact"]), *cells)
    odd = [f"seed {row['seed']}, {row['method']}: {text}" for row in found["rows"] if (text := _odd(row))]
    note = f"{scenario.name}, {scenario.physics} physics, demonstrations of its own for each seed, states alone"
    return "\n".join([table_text(view, note), *odd])


def _odd(row: Mapping[str, Any]) -> str:
    """What went wrong with a seed, in words; empty if nothing did."""
    edges = [f"missing {e}" for e in row.get("missing", ())] + [f"extra {e}" for e in row.get("extra", ())]
    return row["reason"] or ", ".join(edges + [row["why"]] * bool(row.get("why")))
