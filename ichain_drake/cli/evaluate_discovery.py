"""The command `evaluate` with `--methods labels,edges,cuts`: what is found out of states alone."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rich.table import Table

from ichain_drake.cli.evaluation import table_text
from ichain_drake.scenarios.base import Scenario

_F1 = ("f1_all", "f1_shown", "f1_switchings")


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
    return str(row["reason"] or ", ".join([*edges, *filter(None, [row.get("why")])]))
