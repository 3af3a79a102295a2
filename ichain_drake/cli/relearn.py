"""The command `relearn`: one link is learned anew, beside nothing and everything, and the ways are compared."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from ichain_drake.cli.console import Reporter
from ichain_drake.cli.run import deliver_report
from ichain_drake.errors import InputError
from ichain_drake.runs.goals.relearn import relearn_interaction, summarise_relearned
from ichain_drake.runs.goals.run import own_goal
from ichain_drake.runs.paths.relearn import relearn_link, summarise_ways
from ichain_drake.runs.pieces import check_settings
from ichain_drake.scenarios import PathScenario


def relearn_and_compare(
    make: Callable[[int], tuple[Any, Any]], seeds: Sequence[int], link: str, library: Path, report: str | None
) -> None:
    """`ichain relearn`: print one row per way to adapt, and write the report.

    Args:
        make: the changed scenario and the original of a seed.
        seeds: at least one.
        link: `parent->child`.
        library: what was learned before.
        report: a file, or `-`.

    Raises:
        InputError: on an unknown link, a library that lacks another, or a scenario without paths or a goal.
    """
    pairs = [make(seed) for seed in seeds]
    first = pairs[0][0]
    follows = isinstance(first, PathScenario)
    for changed, _ in pairs:
        check_settings(changed)
        if not follows and not own_goal(changed):
            raise InputError(f"{changed.name} has no goal of its own to try; set one in its file")
    rows: list[dict[str, Any]] = []
    found: dict[str, Any] = {}
    with Reporter() as say:
        for changed, original in pairs:
            if len(pairs) > 1:
                say(f"seed {changed.seed}")
            if follows:
                one = relearn_link(changed, original, link, library, say)
            else:
                one = relearn_interaction(changed, original, own_goal(changed), link, library, say)
            rows += one["rows"]
            found = found or one
    table = (summarise_ways if follows else summarise_relearned)(rows)
    found |= {"seeds": list(seeds), "rows": rows, "table": table}
    deliver_report(found, report, _paths_table(table, first.unit) if follows else _goal_table(table))


def _paths_table(ways: list[dict[str, Any]], unit: str) -> str:
    cases = list(dict.fromkeys(case for way in ways for case in way["paths"]))
    heads = (*(f"{case} ({unit})" for case in cases), "of original", "new samples", "robot (s)")
    table = Table("learned anew", *heads, box=None)
    for way in ways:
        nothing = "lost" if way["applied"] else "-"
        errors = [_cell(way["paths"][case], way["seeds"], 3) or nothing for case in cases]
        ratio = _cell(way["ratio"], way["seeds"], 2) or "-"
        table.add_row(way["way"], *errors, ratio, str(way["new_samples"]), f"{way['robot_seconds']:.0f}")
    return _text(table, ways)


def _cell(value: dict[str, Any], seeds: int, digits: int) -> str:
    """Mean and spread over seeds, and how many were lost; nothing if all were."""
    if value["mean"] is None:
        return ""
    spread = f" ± {value['std']:.{digits}f}" if seeds > 1 else ""
    lost = f", {value['lost']} lost" if value["lost"] else ""
    return f"{value['mean']:.{digits}f}{spread}{lost}"


def _goal_table(lines: list[dict[str, Any]]) -> str:
    heads = ("goal reached", "control steps, median", "new plans, mean", "new samples", "robot (s)")
    table = Table("learned anew", *heads, box=None)
    for line in lines:
        reached = f"{line['reached']}/{line['runs']}" if line["applied"] else "-"
        steps = "-" if line["control_steps"] is None else f"{line['control_steps']:.0f}"
        replans = f"{line['replans']:.1f}" if line["applied"] else "-"
        table.add_row(line["way"], reached, steps, replans, str(line["new_samples"]), f"{line['robot_seconds']:.0f}")
    return _text(table, lines)


def _text(table: Table, lines: list[dict[str, Any]]) -> str:
    """A table, and below it the reasons of failures."""
    console = Console(width=140)
    with console.capture() as capture:
        console.print(table)
    text = [line.rstrip() for line in capture.get().rstrip().splitlines()]
    return "\n".join([*text, *(f"{line['way']}: {line['reason']}" for line in lines if line["reason"])])
