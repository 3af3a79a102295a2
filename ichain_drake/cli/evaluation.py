"""What `evaluate` does for every sort of scenario: runs the evaluation, keeps an interrupted one, writes the report."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

from rich.console import Console
from rich.table import Table

from ichain_drake import rules
from ichain_drake.cli.console import Reporter
from ichain_drake.cli.options import command_said
from ichain_drake.cli.run import deliver_report
from ichain_drake.errors import InputError, WorkerLostError
from ichain_drake.runs.clusters.workers import Say
from ichain_drake.runs.paths.output import prepare_file, prepare_folder
from ichain_drake.runs.provenance import code_hash, given_of, printed
from ichain_drake.runs.row_file import RowFile, rows_beside
from ichain_drake.runs.runner import EvaluationInterrupted
from ichain_drake.scenarios import Scenario
from ichain_drake.scenarios.goal_scenario import GoalScenario


@dataclass(frozen=True)
class Evaluation:
    """What is particular to an evaluation.

    Attributes:
        scenario: that is evaluated.
        trials: how many.
        what: of each, for the line that is said first.
        done: the report's reason if all of them were finished.
        evaluate: does the work, given what is called with a line and the fraction done, and where rows are kept;
            returns rows and tables.
        text: the tables as text.
        pictures: draws what was found into a folder.
        asked: what else its rows depend on; rows on disk that were asked for otherwise are not gone on with.
        more: entries of the report beside what all have.
    """

    scenario: Scenario | GoalScenario
    trials: int
    what: str
    done: str
    evaluate: Callable[[Say, RowFile], dict[str, Any]]
    text: Callable[[dict[str, Any]], str]
    pictures: Callable[[dict[str, Any], Path], None]
    asked: Mapping[str, Any] = field(default_factory=dict)
    more: Mapping[str, Any] = field(default_factory=dict)


def run_evaluation(evaluation: Evaluation, report: str | None, output: Path | None, *, resume: bool = False) -> None:
    """Evaluate, print the tables, write report and pictures; rows go beside the report as they come.

    Args:
        evaluation: see there.
        report: a file, or `-` for stdout; by default `report.json` in `output`, if there is one.
        output: folder for pictures.
        resume: go on from the rows beside the report.

    Raises:
        InputError: if a file or folder can't be written, or there is no report to go on from.
        EvaluationInterrupted: on Ctrl-C, once the report on what was finished is written.
        WorkerLostError: if processes were killed again and again, likewise.
    """
    scenario = evaluation.scenario
    if output is not None:
        prepare_folder(output)
        report = report or str(output / "report.json")
    if report not in (None, "-"):
        prepare_file(Path(str(report)))
    elif resume:
        raise InputError("--resume goes on from the rows beside a report: name it with --report FILE")
    about = {
        "scenario": scenario.name,
        "physics": scenario.physics,
        "seed": scenario.seed,
        "without": sorted(rules.switched_off()),
        "code": code_hash([type(scenario)]),
        **evaluation.asked,
    }
    rows = RowFile(None if report in (None, "-") else rows_beside(Path(str(report))), about, resume=resume)
    stopped: EvaluationInterrupted | WorkerLostError | None = None
    with Reporter() as say:
        say(f"evaluating {scenario.name}, {evaluation.trials} {evaluation.what}")
        try:
            found = evaluation.evaluate(say, rows)
        except (EvaluationInterrupted, WorkerLostError) as interruption:
            stopped, found = interruption, interruption.found
    text = evaluation.text(found)
    document = {
        **printed(text, command_said()),
        "scenario": scenario.name,
        "physics": scenario.physics,
        "seed": scenario.seed,
        "trials": evaluation.trials,
        **evaluation.more,
        "reason": evaluation.done if stopped is None else str(stopped),
        "given": given_of(scenario),
        **found,
    }
    deliver_report(document, report, text=text)
    if output is not None:
        evaluation.pictures(found, output)
    if stopped is not None:
        raise stopped


def table_text(view: Table, note: str) -> str:
    """A table with a note below, as text."""
    console = Console(width=140)
    with console.capture() as capture:
        console.print(view)
        console.print(note)
    return capture.get().rstrip()


class OverSeeds(Protocol):
    """What is evaluated on demonstrations of several seeds; see `DiscoveryEvaluation`, `CalibrationEvaluation`."""

    @property
    def scenario(self) -> Scenario:
        """With the first seed and the physics."""

    @property
    def overrides(self) -> tuple[str, ...]:
        """Its settings."""

    @property
    def trials(self) -> int:
        """Number of seeds."""

    @property
    def methods(self) -> tuple[str, ...]:
        """What is evaluated of each."""

    def check(self) -> None:
        """Refuse what can't be evaluated, by an `InputError`."""


def evaluate_seeds(
    what: OverSeeds,
    evaluate: Callable[[Any, Say, RowFile], dict[str, Any]],
    text: Callable[[Scenario, dict[str, Any]], str],
    pictures: Callable[[dict[str, Any], Path], None],
    report: str | None,
    output: Path | None = None,
    *,
    resume: bool = False,
) -> None:
    """`run_evaluation` of demonstrations of several seeds.

    Args:
        what: is evaluated.
        evaluate: does the work.
        text: the tables as text.
        pictures, report, output, resume: see `Evaluation` and `run_evaluation`.

    Raises:
        InputError: as `OverSeeds.check`, or on a file that can't be written.
        EvaluationInterrupted: on Ctrl-C, once the report on what was finished is written.
    """
    what.check()
    evaluation = Evaluation(
        what.scenario,
        what.trials,
        "seeds",
        "every seed was evaluated",
        evaluate=lambda say, rows: evaluate(what, say, rows),
        text=lambda found: text(what.scenario, found),
        pictures=pictures,
        asked={"settings": list(what.overrides), "methods": list(what.methods)},
    )
    run_evaluation(evaluation, report, output, resume=resume)
