"""The command `evaluate` with `--methods calibration`: how honest P(active) and predictive intervals are."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from rich.table import Table

from ichain_drake.cli.evaluation import table_text
from ichain_drake.runs.calibration import HELD_OUT, LEVELS, SET_ASIDE, bins_of
from ichain_drake.scenarios.base import Scenario


def format_calibration(scenario: Scenario, found: Mapping[str, Any]) -> str:
    """The tables as text, and below them seeds of which nothing was learned."""
    parts = [_statuses(found["statuses"]), _intervals(found["intervals"])]
    parts += [f"seed {row['seed']}: {row['reason']}" for row in found["rows"] if row["reason"]]
    seeds = sorted(row["seed"] for row in found["rows"])
    if seeds:
        learned, other, aside = (f"{seeds[0] + k}-{seeds[-1] + k}" for k in (0, HELD_OUT, SET_ASIDE))
        parts.append(
            f"{scenario.name}, {scenario.physics} physics, learned from demonstrations of seeds {learned}, compared "
            f"with those of {other}, scaled by those of {aside}"
        )
    return "\n\n".join(part for part in parts if part)


def _statuses(lines: Sequence[Mapping[str, Any]]) -> str:
    if not lines:
        return ""
    view = Table("P(active)", "rows", "active", "error", "largest of a seed", "left out", "alone", "Brier", box=None)
    for line in lines:
        errors = (f"{line[k]:.4f}" for k in ("error", "largest", "left_out", "alone", "brier"))
        view.add_row(line["interaction"], str(line["rows"]), str(line["active"]), *errors)
    note = (
        "error: expected calibration error, mean over seeds (10 bins of equal width), given the status before; left "
        "out: as learning found it; alone: not given"
    )
    return table_text(view, note)


def _intervals(lines: Sequence[Mapping[str, Any]]) -> str:
    if not lines:
        return ""
    levels = [f"{100 * level:.0f} %" for level in LEVELS]
    view = Table("one tick of", "rows", *levels, "scaled", "", "acting", *levels, "scaled", "", box=None)
    for line in lines:
        cells = {k: [_percent(x) for x in line[k]] for k in ("covered", "scaled", "covered_acting", "scaled_acting")}
        view.add_row(
            line["variable"],
            str(line["rows"]),
            *cells["covered"],
            *cells["scaled"],
            str(line["acting"]),
            *cells["covered_acting"],
            *cells["scaled_acting"],
        )
    note = (
        "shares of readings within predictive intervals that are to cover so many, of all rows and of those in which "
        "an effect acts;\nscaled: by residuals of pieces that were set aside (split conformal prediction)"
    )
    return table_text(view, note)


def _percent(share: float | None) -> str:
    return "-" if share is None else f"{100 * share:.1f}"


def write_pictures(found: Mapping[str, Any], folder: Path) -> None:
    """`reliability.png`, where there are statuses, and `coverage.png`, where anything was predicted."""
    from ichain_drake.visualization import plot_coverage, plot_reliability

    if found["statuses"]:
        file = folder / "reliability.png"
        plot_reliability(file, {line["interaction"]: bins_of(line) for line in found["statuses"]})
        print(f"written: {file}")
    if found["intervals"]:
        file = folder / "coverage.png"
        shares = {
            line["variable"]: {"spread": line["covered"][-1], "scaled": line["scaled"][-1]}
            for line in found["intervals"]
        }
        plot_coverage(file, shares, level=LEVELS[-1])
        print(f"written: {file}")
