"""`run` for path-following scenarios: demonstrations, learning, control."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from threadpoolctl import threadpool_limits

from ichain_drake.control.tracking.chain import make_controller
from ichain_drake.control.tracking.turns import check_turns, smooth_path
from ichain_drake.errors import UnreachableError
from ichain_drake.learning import InteractionModel
from ichain_drake.remote import connect
from ichain_drake.runs.learn import Known, learn
from ichain_drake.runs.paths.following import follow, measure_result, oracle_follow
from ichain_drake.runs.paths.result import PathRun
from ichain_drake.runs.pieces import check_settings, read_for, record_pieces
from ichain_drake.scenarios.base import Progress
from ichain_drake.simulation.episode import EpisodeInterrupted
from ichain_drake.simulation.recorder import whole_frames
from ichain_drake.simulation.watching import watched_by


def run_paths(
    run: PathRun,
    *,
    demos: str | Path | None = None,
    keep_demos: str | Path | None = None,
    known: Known | None = None,
    oracle: bool = False,
    resampled: bool = False,
    progress: Progress | None = None,
) -> None:
    """Do everything up to the report, filling `run`.

    Args:
        run: with `scenario` and `paths` set.
        demos: folder of demonstrations to learn from, in place of recording them.
        keep_demos: folder that recorded demonstrations are written to.
        known: what was learned before, in place of learning; of parts, what only they need is not demonstrated again.
        oracle: whether to run the oracle on every path too; it takes longer than the run.
        resampled: whether to take demonstrations of another period to the library's.
        progress: called with a line at each step.

    Raises:
        InputError: on bad settings, demonstrations or paths.
        UnreachableError: if the arm can't get where it has to; `run.reason` says why.
    """
    keep_demos = None if keep_demos is None else Path(keep_demos)
    demos = None if demos is None else Path(demos)
    check_settings(run.scenario)
    say = progress or (lambda line: None)
    # One BLAS thread: the matrices are small, and sums must not depend on how many cores there are.
    with threadpool_limits(limits=1):
        try:
            if isinstance(known, InteractionModel):
                run.pieces = []
            elif demos is not None:
                run.pieces = read_for(run.scenario, demos, resampled=resampled, say=say)
            else:
                record_pieces(run.scenario, run.pieces, keep_demos, say, set(known.names if known else ()))
            learn_to_follow(run, known, say)
            _follow_all(run, oracle, say)
        except UnreachableError as error:
            run.reason = str(error)
            raise


def learn_to_follow(
    run: PathRun,
    known: Known | None = None,
    say: Progress = lambda line: None,
) -> None:
    """Learn links and controller from the run's pieces; a path that they can't follow is refused.

    Args:
        run: with pieces; is given `model` and `controller`.
        known: as for `run_paths`.
        say: called with a line at each step.

    Raises:
        InputError: on bad demonstrations, or a path that turns too sharply.
    """
    scenario, control = run.scenario, run.scenario.config.control
    run.model = learn(scenario, run.pieces, known=known, progress=say)
    chain = run.model.for_paths()
    for name, path in run.paths.items():
        where = f"path {name}"
        if run.smooth:
            run.paths[name], off = smooth_path(path, chain, where, scenario.unit)
            say(f"{where}: smoothed, by {off:.3g} {scenario.unit} at most")
        check_turns(run.paths[name], chain, where, scenario.unit)
    run.controller = make_controller(chain, control.method, scenario.path_limits(), control.candidates(), say)


def _follow_all(run: PathRun, oracle: bool, say: Progress) -> None:
    """Every path, and where wanted the oracle on it; what an interruption leaves of one is kept."""
    scenario = run.scenario
    assert run.chain is not None and run.controller is not None
    for number, (name, path) in enumerate(run.paths.items()):
        say(f"following {name}")
        try:
            world = connect(run.robot, scenario.graph) if run.robot else None
            result = follow(scenario, run.chain, run.controller, name, path, number, world)
            run.line = {} if world is None else world.report()
        except EpisodeInterrupted as stopped:
            log = whole_frames(stopped.log)
            if len(log.times) > 1:
                run.results.append(measure_result(scenario, name, path, log, None, number))
            raise
        if scenario.no_oracle:
            result = replace(result, oracle_reason=f"{scenario.name} has no oracle: {scenario.no_oracle}")
        run.results.append(result)
        if oracle and not scenario.no_oracle:
            say(f"the oracle on {name}")
            with watched_by(None):  # a person who looks on must not push the oracle's car
                other = oracle_follow(scenario, name, path, number)
            if other.completed:
                run.results[-1] = replace(result, oracle_error=other.error, oracle_reason="")
            else:
                run.results[-1] = replace(result, oracle_reason="the oracle did not reach the path's end")
    lost = [f"{r.name} ({r.reason})" for r in run.results if not r.completed]
    run.reason = f"the end was not reached on: {', '.join(lost)}" if lost else "every path was followed to its end"
