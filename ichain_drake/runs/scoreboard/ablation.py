"""What each rule is worth: every row run once more without it, from the same demonstrations and models."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.stats import binomtest

from ichain_drake.errors import InputError
from ichain_drake.runs.scoreboard.cases import GOAL, Case

Row = Mapping[str, Any]


def with_ablations(cases: Sequence[Case], rules: Collection[str]) -> list[Case]:
    """Rows towards a goal, each followed by itself without one rule after the other.

    Paths are left out: what follows them has no rule.

    Args:
        cases: rows of the scoreboard.
        rules: names.

    Raises:
        InputError: if no row has a goal.
    """
    goals = [case for case in cases if case.task == GOAL]
    if not goals:
        raise InputError("--ablate: none of these rows has a goal, and rules act on goals alone; widen --only")
    return [each for case in goals for each in (case, *(replace(case, without=rule) for rule in rules))]


def rule_lines(rows: Sequence[Row], rules: Collection[str]) -> list[dict[str, Any]]:
    """One line a rule, out of pairs: the same trial with all rules and without this one.

    Args:
        rows: one a trial, with its `row` and what it was run `without`.
        rules: names.

    Returns:
        Of each rule: `pairs`, how many of them `differ` in any way, `lost` (reached with it alone) and `won` (without
        it alone) with the two-sided `p` of the exact sign test, `silent` failures more without it, ratio of `steps`
        (without to with; geometric mean where both reached), `replans` more without it (mean), and the rows that `need`
        it: in which more is lost than won.
    """
    complete = {(r["row"], r["seed"]): r for r in rows if not r["without"]}
    lines = []
    for rule in rules:
        pairs = [(complete[k], r) for r in rows if r["without"] == rule and (k := (r["row"], r["seed"])) in complete]
        lost = [a["row"] for a, b in pairs if a["success"] and not b["success"]]
        won = [a["row"] for a, b in pairs if b["success"] and not a["success"]]
        both = [(a["control_steps"], b["control_steps"]) for a, b in pairs if a["success"] and b["success"]]
        lines.append(
            {
                "rule": rule,
                "pairs": len(pairs),
                "differ": sum(_outcome(a) != _outcome(b) for a, b in pairs),
                "lost": len(lost),
                "won": len(won),
                "p": float(binomtest(len(lost), len(lost) + len(won)).pvalue) if lost or won else 1.0,
                "silent": sum(b["silent"] for _, b in pairs) - sum(a["silent"] for a, _ in pairs),
                "steps": float(np.exp(np.mean([np.log(b / a) for a, b in both]))) if both else None,
                "replans": float(np.mean([b["replans"] - a["replans"] for a, b in pairs])) if pairs else None,
                "need": [row for row in dict.fromkeys(lost) if lost.count(row) > won.count(row)],
            }
        )
    return lines


def _outcome(row: Row) -> tuple[Any, ...]:
    return tuple(row[key] for key in ("success", "reason", "control_steps", "replans", "error"))
