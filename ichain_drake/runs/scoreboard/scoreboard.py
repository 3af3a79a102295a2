"""The scoreboard: every row's trials, and its table."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ichain_drake.runs.clusters.workers import Say, Workers
from ichain_drake.runs.goals.fresh import join
from ichain_drake.runs.row_file import RowFile
from ichain_drake.runs.runner import evaluate_jobs
from ichain_drake.runs.scoreboard.ablation import rule_lines
from ichain_drake.runs.scoreboard.cases import FIRST_SEED, Case
from ichain_drake.runs.scoreboard.table import add_failures_without, make_line, prediction_lines
from ichain_drake.runs.scoreboard.trials import make_jobs


def run_scoreboard(
    cases: Sequence[Case],
    first_seed: int = FIRST_SEED,
    workers: Workers | None = None,
    rows: RowFile | None = None,
    say: Say | None = None,
) -> dict[str, Any]:
    """Run every trial, each with demonstrations, learning and run of its own.

    Args:
        cases: the rows, from `all_cases`, or those from `with_ablations`.
        first_seed: of the first trial of every row; the others follow.
        workers: who works; by default this process. The result does not depend on it, but for times.
        rows: what was found before, and where rows are kept as they come.
        say: called with a line and the fraction done.

    Returns:
        `table` (one line a row, see `make_line`), `predicted` (what plans said of their success beside what became of
        them, with all rules, see `prediction_lines`), `ablation` (one line a rule that some row is run without, see
        `rule_lines`) and `rows` (one a trial, with the `row` that it belongs to and the rule that it was `without`).

    Raises:
        InputError: if a cluster does not answer.
        EvaluationInterrupted: on Ctrl-C, with the trials that were finished.
        WorkerLostError: if processes were killed again and again, with the same.
    """
    rows, workers = rows or RowFile(), workers or Workers()

    def found() -> dict[str, Any]:
        table, flat = [], []
        for case in cases:
            own = rows.of(case.trial(first_seed + k) for k in range(case.trials))
            flat += [{"row": case.name, "without": case.without, **row} for row in own]
            if own and not case.without:
                table.append(make_line(case, own))
        complete = [row for row in flat if not row["without"]]
        add_failures_without(table, complete)
        off = dict.fromkeys(case.without for case in cases if case.without)
        predicted = prediction_lines(complete)
        return {"table": table, "predicted": predicted, "ablation": rule_lines(flat, off), "rows": flat}

    work = join(make_jobs(cases, first_seed), workers)
    return evaluate_jobs(work, workers, rows, found, say, _label)


def _label(name: str, done: int, total: int) -> str:
    system, _, physics, *_, seed = name.split("/")
    return f"{done} of {total}: {system}, {physics}, {seed}"
