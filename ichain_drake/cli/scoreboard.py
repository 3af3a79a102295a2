"""The command `scoreboard`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import click

from ichain_drake.cli.options import PATH, options

_FILE = Path("runs") / "scoreboard.json"


@click.command()
@click.option("--quick", is_flag=True, help="few trials, in minutes")
@options("jobs", "cluster", "trial_timeout")
@click.option("--trials", type=int, help="of every row; by default 20 without an arm, fewer by contact")
@click.option("--seed", type=int, help="of the first trial of every row; the others follow")
@click.option("--only", metavar="GLOB", multiple=True, help="rows of this name, such as 'kettle/*/ideal/*'")
@click.option("--also", metavar="FILE.py", multiple=True, help="a system of your own, beside those that come along")
@click.option("--against", type=PATH, metavar="FILE", help="an earlier report: what became better or worse")
@options("resume", "without")
@click.option("--ablate", is_flag=True, help="run rows with a goal also without each rule: which needs which")
@click.option("--rules", "list_rules", is_flag=True, help="list the rules that --without can switch off")
@click.option("--report", metavar="FILE", default=str(_FILE), show_default=True, help="as JSON; - for stdout")
def scoreboard(
    quick: bool,
    jobs: int,
    cluster: str,
    trial_timeout: float | None,
    trials: int | None,
    seed: int | None,
    only: tuple[str, ...],
    also: tuple[str, ...],
    against: Path | None,
    resume: bool,
    without: tuple[str, ...],
    ablate: bool,
    list_rules: bool,
    report: str,
) -> int:
    """Every system, task, physics and fault in one table; each trial has demonstrations of its own.

    Rows are kept beside the report as they come: interrupted, --resume goes on. With --against, the exit status is 1 if
    a row became worse beyond chance.
    """
    from ichain_drake import rules
    from ichain_drake.errors import InputError
    from ichain_drake.runs.clusters.workers import Workers
    from ichain_drake.runs.provenance import code_hash
    from ichain_drake.runs.scoreboard.ablation import with_ablations
    from ichain_drake.runs.scoreboard.against import read_scoreboard
    from ichain_drake.runs.scoreboard.cases import FIRST_SEED, QUICK, WHOLE, all_cases
    from ichain_drake.systems.own import own_scenario

    if list_rules:
        print(format_rules())
        return 0
    workers = Workers(jobs, cluster, trial_timeout)
    if trials is not None and trials < 1:
        raise InputError("--trials and --jobs: give numbers from 1")
    if seed is not None and seed < 0:
        raise InputError(f"--seed {seed}: give a whole number from 0")
    earlier = None if against is None else read_scoreboard(against)
    cases, skipped = all_cases(QUICK if quick else WHOLE, also, only, trials)
    if ablate:
        cases = with_ablations(cases, [name for name in rules.RULES if name not in without])
    about = {
        "quick": quick,
        "first_seed": FIRST_SEED if seed is None else seed,
        "also": list(also),
        "without": sorted(set(without)),
        "ablate": ablate,
        "code": code_hash([own_scenario(name) for name in also]),
    }
    with rules.without(without):
        document = _measure(cases, skipped, about, workers, report, resume=resume)
    if earlier is None:
        return 0
    return tell_changes(earlier, document, quiet=report == "-")


def _measure(
    cases: Sequence[Any],
    skipped: Mapping[str, str],
    about: Mapping[str, Any],
    workers: Any,
    report: str,
    *,
    resume: bool,
) -> dict[str, Any]:
    """Run, print, write.

    Raises:
        EvaluationInterrupted, WorkerLostError: once the report on what was finished is written.
    """
    from ichain_drake.cli.console import Reporter
    from ichain_drake.cli.options import command_said
    from ichain_drake.cli.run import deliver_report
    from ichain_drake.errors import WorkerLostError
    from ichain_drake.runs.paths.output import prepare_file
    from ichain_drake.runs.provenance import printed, versions
    from ichain_drake.runs.row_file import RowFile, rows_beside
    from ichain_drake.runs.runner import EvaluationInterrupted
    from ichain_drake.runs.scoreboard.scoreboard import run_scoreboard

    if report != "-":
        prepare_file(Path(report))
    rows = RowFile(rows_beside(_FILE if report == "-" else Path(report)), {**about, **versions()}, resume=resume)
    stopped: EvaluationInterrupted | WorkerLostError | None = None
    with Reporter() as say:
        rows_said = f"{sum(not case.without for case in cases)} rows"
        say(f"{rows_said}, {sum(case.trials for case in cases)} trials; kept in {rows.file}")
        try:
            found = run_scoreboard(cases, about["first_seed"], workers, rows, say)
        except (EvaluationInterrupted, WorkerLostError) as interruption:
            stopped, found = interruption, interruption.found
    text = format_scoreboard({**about, **found})
    document = {
        **printed(text, command_said()),
        "reason": "every trial was run" if stopped is None else str(stopped),
        **about,
        **found,
        "skipped": dict(skipped),
    }
    deliver_report(document, report, text=text)
    if stopped is not None:
        raise stopped
    return document


def format_scoreboard(document: Mapping[str, Any]) -> str:
    """The table as text.

    Args:
        document: the report.
    """
    from rich.table import Table

    from ichain_drake.cli.evaluation import table_text
    from ichain_drake.runs.intervals import success_words

    columns = ("success", "also", "steps", "replans", "silent", "error", "x oracle", "learn s", "plan s", "wall s")
    view = Table("system", "task", "physics", "fault", *columns, box=None, padding=(0, 1))
    for line in document["table"]:
        error = f"{_figure(line['mean_error'], 3)} {line['unit']}"
        view.add_row(
            line["system"], line["task"], line["physics"], line["fault"],
            success_words(line["reached"], line["runs"], line["interval"]), str(line["failed_without"] or ""),
            _figure(line["median_steps"], 0), _figure(line["mean_replans"], 1), str(line["silent"]), error,
            _figure(line["ratio_to_oracle"], 2),
            *(_figure(line[key], 1) for key in ("learning_seconds", "plan_seconds", "wall_seconds")),
        )  # fmt: skip
    seeds = f"seeds from {document['first_seed']} on, each trial with demonstrations of its own"
    off = f"; without {', '.join(document['without'])}" if document["without"] else ""
    note = (
        f"{seeds}{off}\nsuccess: in truth, with Wilson's 95 % interval; steps: median where reached; "
        "also: of the failures those that fail without the fault, too; "
        "silent: failures that ended as if reached;\nerror: mean distance to the path, or by how much the goal was "
        "missed, as a share of the demonstrated range;\ntimes: medians, learning and planning of the processor"
    )
    parts = [table_text(view, note)]
    if document["predicted"]:
        parts.append(format_predictions(document["predicted"]))
    if document["ablation"]:
        parts.append(format_ablation(document["ablation"]))
    return "\n\n".join(parts)


def format_predictions(lines: Sequence[Mapping[str, Any]]) -> str:
    """What plans said of their success beside what became of them, as text.

    Args:
        lines: from `prediction_lines`.
    """
    from rich.table import Table

    from ichain_drake.cli.evaluation import table_text
    from ichain_drake.runs.intervals import success_words

    view = Table("probability of the plan", "runs", "predicted", "reached", box=None, padding=(0, 1))
    for line in lines:
        view.add_row(
            f"{line['above']:.1f} to {line['up_to']:.1f}", str(line["runs"]), f"{line['predicted']:.3f}",
            success_words(line["reached"], line["runs"], line["interval"]),
        )  # fmt: skip
    return table_text(view, "what the first plan of each run towards a goal said of its success, and what became of it")


def format_ablation(lines: Sequence[Mapping[str, Any]]) -> str:
    """What each rule is worth, as text.

    Args:
        lines: from `rule_lines`.
    """
    from rich.table import Table

    from ichain_drake.cli.evaluation import table_text

    columns = ("pairs", "differ", "lost", "won", "p", "silent", "steps", "replans", "rows that need it")
    view = Table("without", *columns, box=None, padding=(0, 1))
    for line in lines:
        view.add_row(
            line["rule"], *(str(line[key]) for key in ("pairs", "differ", "lost", "won")), f"{line['p']:.2g}",
            f"{line['silent']:+d}", _figure(line["steps"], 3), f"{line['replans']:+.2f}", ", ".join(line["need"]),
        )  # fmt: skip
    note = (
        "pairs: the same trial with all rules and without this one; lost: reached with it alone; won: without it "
        "alone; p: exact sign test;\nsilent, replans: more without it; steps: ratio where both reached"
    )
    return table_text(view, note)


def _figure(value: float | None, digits: int) -> str:
    return "-" if value is None else f"{value:.{digits}f}"


def tell_changes(earlier: Mapping[str, Any], document: Mapping[str, Any], *, quiet: bool) -> int:
    """Print what changed since an earlier report.

    Args:
        earlier, document: reports.
        quiet: print to stderr, since stdout has the report.

    Returns:
        1 if a row became worse beyond chance, else 0.
    """
    import sys

    from ichain_drake.runs.scoreboard.against import LEVEL, compare

    found = compare(earlier["table"], document["table"])
    out = sys.stderr if quiet else sys.stdout
    said = [("better", found.better), ("worse", found.worse)]
    for word, changes in said:
        for change in changes:
            print(f"{word}: {change.words()}", file=out)
    hints = [c for c in found.changes if not c.beyond_chance and c.p < LEVEL]
    for change in hints:
        print(f"may be chance: {change.words()}", file=out)
    print(
        f"{len(found.changes)} rows compared: {len(found.better)} better, {len(found.worse)} worse beyond chance "
        f"(Fisher's exact test, Holm over rows, level {LEVEL}); {len(found.new)} new, {len(found.gone)} not measured",
        file=out,
    )
    return 1 if found.worse else 0


def format_rules() -> str:
    """The rules with their reasons, as text."""
    from rich.table import Table

    from ichain_drake.cli.evaluation import table_text
    from ichain_drake.rules import RULES

    view = Table("rule", "where", "reason", box=None)
    for rule in RULES.values():
        view.add_row(rule.name, rule.where, rule.reason)
    return table_text(view, "--without RULE switches one off, in `run`, `evaluate` and `scoreboard`")
