"""The commands `evaluate` and `benchmarks`, without what they import."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from ichain_drake.cli.options import options, scenario_named
from ichain_drake.errors import IchainError


@click.command()
@options("scenario")
@options("physics", "seed")
@click.option("--trials", type=int, help="number of seeds; 20 for paths, 5 for goals by default")
@click.option(
    "--methods",
    metavar="A,B",
    default="",
    help="only these (also method@samples, method/case; or labels,edges,cuts; or calibration)",
)
@click.option("--fresh", is_flag=True, help="every trial has demonstrations of its own; paths: so by default")
@click.option("--shared", is_flag=True, help="all trials share the demonstrations of one seed; goals: so by default")
@options("jobs", "cluster", "trial_timeout", "report", "output", "resume", "without", "settings")
def evaluate(
    scenario: str,
    physics: str,
    seed: int,
    trials: int | None,
    methods: str,
    fresh: bool,
    shared: bool,
    jobs: int,
    cluster: str,
    trial_timeout: float | None,
    report: str | None,
    output: Path | None,
    resume: bool,
    without: tuple[str, ...],
    settings: tuple[str, ...],
) -> None:
    """Compare methods over many seeds, in one table.

    --fresh and --shared together print both, for goals.
    """
    from ichain_drake import rules
    from ichain_drake.cli.evaluate import evaluate_path_scenario
    from ichain_drake.cli.evaluate_calibration import format_calibration, write_pictures
    from ichain_drake.cli.evaluate_discovery import format_discovery
    from ichain_drake.cli.evaluate_graph import evaluate_goal_scenario
    from ichain_drake.cli.evaluation import evaluate_seeds
    from ichain_drake.runs.calibration import CALIBRATION, CalibrationEvaluation, evaluate_calibration
    from ichain_drake.runs.clusters.workers import Workers
    from ichain_drake.runs.discovery import METHODS, DiscoveryEvaluation, evaluate_discovery
    from ichain_drake.scenarios import PathScenario

    workers = Workers(jobs, cluster, trial_timeout)
    loaded = scenario_named(scenario, settings, physics, seed)
    names = [m.strip() for m in methods.split(",") if m.strip()]
    with rules.without(without):
        over_seeds = (loaded, tuple(settings), 5 if trials is None else trials, tuple(names), workers)
        files: dict[str, Any] = {"report": report, "output": output, "resume": resume}
        if set(names) & set(METHODS):
            found = DiscoveryEvaluation(*over_seeds)
            evaluate_seeds(found, evaluate_discovery, format_discovery, lambda found, folder: None, **files)
        elif CALIBRATION in names:
            calibrated = CalibrationEvaluation(*over_seeds)
            evaluate_seeds(calibrated, evaluate_calibration, format_calibration, write_pictures, **files)
        elif isinstance(loaded, PathScenario):
            if shared and fresh:
                raise IchainError(f"{scenario} follows paths: give one of --fresh and --shared")
            count = 20 if trials is None else trials
            evaluate_path_scenario(
                loaded, list(settings), count, names, workers, report, output, shared=shared, resume=resume
            )
        else:
            count = 5 if trials is None else trials
            evaluate_goal_scenario(
                loaded, list(settings), count, names, workers, report, output,
                shared=shared or not fresh, fresh=fresh, resume=resume,
            )  # fmt: skip


@click.command()
@click.option("--profile", metavar="SYSTEM", help="instead: where the time of one run of it goes")
@click.option("--scaling", is_flag=True, help="instead: how cost grows with objects, rows and trials; takes long")
@options("physics", "seed", "report", "settings")
def benchmarks(
    profile: str | None, scaling: bool, physics: str, seed: int, report: str | None, settings: tuple[str, ...]
) -> None:
    """Print what the library costs, as ratios measured in one run.

    --physics, --seed and --set are those of the run that --profile looks at.
    """
    from ichain_drake import benchmarks as measured
    from ichain_drake.cli.console import Reporter
    from ichain_drake.cli.options import command_said
    from ichain_drake.cli.run import deliver_report
    from ichain_drake.runs.paths.output import prepare_file
    from ichain_drake.runs.provenance import printed

    if report not in (None, "-"):
        prepare_file(Path(report))
    if profile is None and settings:
        raise IchainError("--set is for --profile: the benchmarks have settings of their own")
    if profile is not None and scaling:
        raise IchainError("--profile and --scaling are two different things to measure; give one of them")
    with Reporter() as say:
        if profile is not None:
            results = measured.profile_run(scenario_named(profile, settings, physics, seed), say)
            text = measured.format_profile(results)
        elif scaling:
            results = measured.run_scaling(say)
            text = measured.format_scaling(results)
        else:
            results = measured.run_benchmarks(say)
            text = measured.format_table(results)
    deliver_report({**results, **printed(text, command_said())}, report, text=text)
