"""The scoreboard's lines, out of one row a trial."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ichain_drake.learning.calibration import reliability
from ichain_drake.runs.intervals import seed_words, success_interval
from ichain_drake.runs.scoreboard.cases import NONE, READING, Case

TIMES = ("learning_seconds", "plan_seconds", "wall_seconds")
"""What differs from one run of the scoreboard to the next; everything else is the same."""


def make_line(case: Case, rows: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """One line.

    Args:
        case: the row of the scoreboard.
        rows: its trials that were run, at least one.

    Returns:
        Name and its parts; `runs`, `reached`, Wilson's `interval`, `seeds`; `silent` failures; `median_steps` of those
        that reached, `mean_replans` (None for paths); `mean_error`: for paths the distance to the path in `unit`, for
        goals the miss as a share of what was demonstrated; `ratio_to_oracle`: of mean errors where both were measured;
        median times [s]; `causes` of failures with their number, and an example of a `reason`.
    """
    done = [r for r in rows if r["success"]]
    errors = [float(r["error"]) for r in rows if r["error"] is not None]
    both = [(float(r["error"]), float(r["oracle_error"])) for r in done if r.get("oracle_error") is not None]
    replans = [r["replans"] for r in rows if r["replans"] is not None]
    causes = Counter(r["cause"] or "unknown" for r in rows if not r["success"])
    ratio = float(np.mean([e for e, _ in both]) / np.mean([o for _, o in both])) if both else None
    return {
        "row": case.name,
        "system": case.system,
        "task": case.task,
        "physics": case.physics,
        "fault": case.fault,
        "runs": len(rows),
        "reached": len(done),
        "interval": success_interval(len(done), len(rows)),
        "seeds": seed_words(r["seed"] for r in rows),
        "silent": sum(bool(r["silent"]) for r in rows),
        "median_steps": float(np.median([r["control_steps"] for r in done])) if done else None,
        "mean_replans": float(np.mean(replans)) if replans else None,
        "mean_error": float(np.mean(errors)) if errors else None,
        "unit": next((r["unit"] for r in rows if r.get("unit")), "of range" if errors else ""),
        "ratio_to_oracle": ratio,
        **{key: _median(rows, key) for key in TIMES},
        "causes": dict(sorted(causes.items(), key=lambda item: (-item[1], item[0]))),
        "reason": next((r["reason"] for r in rows if not r["success"]), ""),
    }


def add_failures_without(table: Sequence[dict[str, Any]], rows: Sequence[Mapping[str, Any]]) -> None:
    """Give lines of faults `failed_without`: how many of their failures are of seeds that fail without the fault, too.

    Args:
        table: from `make_line`; lines without a fault, and those beside which there is none, get None.
        rows: one a trial, with the `row` that it belongs to.
    """
    lost: dict[str, set[int]] = {}
    for row in rows:
        lost.setdefault(row["row"], set())
        if not row["success"]:
            lost[row["row"]].add(row["seed"])
    for line in table:
        plain = f"{line['row'].rpartition('/')[0]}/{NONE}"
        known = line["fault"] not in (NONE, READING) and plain in lost  # other demonstrations: nothing is shared
        line["failed_without"] = len(lost[line["row"]] & lost[plain]) if known else None


def prediction_lines(rows: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """What plans said of their success beside what became of them (a reliability diagram in numbers).

    Args:
        rows: one a trial; those without a plan, and of paths, have no `probability` and are left out.

    Returns:
        One line for each tenth of probability that some plan is in, the likeliest first: its bounds `above` and
        `up_to`; `runs`; mean `predicted`; `reached` and Wilson's `interval`.
    """
    planned = [row for row in rows if row["probability"] is not None]
    if not planned:
        return []
    found = reliability([row["probability"] for row in planned], [bool(row["success"]) for row in planned])
    bins = len(found.rows)
    return [
        {
            "above": k / bins,
            "up_to": (k + 1) / bins,
            "runs": int(n),
            "predicted": round(float(found.predicted[k]) / int(n), 4),
            "reached": int(found.happened[k]),
            "interval": success_interval(int(found.happened[k]), int(n)),
        }
        for k, n in reversed(list(enumerate(found.rows)))
        if n
    ]


def _median(rows: Sequence[Mapping[str, Any]], key: str) -> float | None:
    values = [float(r[key]) for r in rows if r.get(key) is not None]
    return round(float(np.median(values)), 3) if values else None
