"""`run` for path-following scenarios: demonstrations, learning, control."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from threadpoolctl import threadpool_limits

from ichain_drake.control.tracking.chain import make_controller
from ichain_drake.control.tracking.turns import check_turns, smooth_path
from ichain_drake.demonstrations import Demonstration, write_demonstrations
from ichain_drake.errors import InputError, UnreachableError
from ichain_drake.graph import InteractionGraph
from ichain_drake.learning.chain.chain import LearnedLink, learn_chain
from ichain_drake.learning.chain.command import LearnedCommand
from ichain_drake.learning.estimators.trial import try_out
from ichain_drake.runs.paths.demonstrations import read_for
from ichain_drake.runs.paths.following import follow, measure_result, oracle_follow
from ichain_drake.runs.paths.result import PathRun
from ichain_drake.scenarios.base import PathScenario, Progress
from ichain_drake.simulation.episode import EpisodeInterrupted
from ichain_drake.simulation.recorder import RecordingInterrupted, whole_frames
from ichain_drake.simulation.watching import watched_by
from ichain_drake.timing import TICK


def check_settings(scenario: PathScenario) -> None:
    """Refuse estimators that learning would refuse, before minutes of recording; a scenario has checked the rest.

    Raises:
        InputError: on an unknown estimator or parameter; names the interaction.
    """
    tried: set[str] = set()
    for name, link in scenario.config.learning.candidates().items():
        for spec in (*link.forward, *link.inverse, *([link.screening] if link.screening else [])):
            if str(spec) in tried:
                continue
            tried.add(str(spec))
            try:
                try_out(spec.make())
            except (ValueError, TypeError) as error:  # InputError is one; constructors may raise both
                raise InputError(f"{name}: {spec}: {error}") from None


def run_paths(
    run: PathRun,
    *,
    demos: str | Path | None = None,
    keep_demos: str | Path | None = None,
    known: Mapping[str, LearnedLink] | None = None,
    known_command: LearnedCommand | None = None,
    oracle: bool = False,
    resampled: bool = False,
    progress: Progress | None = None,
) -> None:
    """Do everything up to the report, filling `run`.

    Args:
        run: with `scenario` and `paths` set.
        demos: folder of demonstrations to learn from, in place of recording them.
        keep_demos: folder that recorded demonstrations are written to.
        known: links from a library, by interaction name; what only they need is not demonstrated again.
        known_command: what the library knows about commanding the hand.
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
            if demos is not None:
                run.pieces = read_for(run.scenario, demos, resampled=resampled, say=say)
            else:
                record_pieces(run, keep_demos, say, set(known or ()))
            learn_to_follow(run, known, known_command, say)
            _follow_all(run, oracle, say)
        except UnreachableError as error:
            run.reason = str(error)
            raise


def learn_to_follow(
    run: PathRun,
    known: Mapping[str, LearnedLink] | None = None,
    known_command: LearnedCommand | None = None,
    say: Progress = lambda line: None,
) -> None:
    """Learn links and controller from the run's pieces; a path that they can't follow is refused.

    Args:
        run: with pieces; is given `chain` and `controller`.
        known, known_command: as for `run_paths`.
        say: called with a line at each step.

    Raises:
        InputError: on bad demonstrations, or a path that turns too sharply.
    """
    scenario, control = run.scenario, run.scenario.config.control
    run.chain = learn_chain(
        run.pieces,
        scenario.graph,
        scenario.target,
        scenario.target_variables,
        scenario.config.learning.candidates(),
        recorded_seconds(run.pieces, scenario.graph),
        say,
        known,
        known_command,
    )
    for name, path in run.paths.items():
        where = f"path {name}"
        if run.smooth:
            run.paths[name], off = smooth_path(path, run.chain, where, scenario.unit)
            say(f"{where}: smoothed, by {off:.3g} {scenario.unit} at most")
        check_turns(run.paths[name], run.chain, where, scenario.unit)
    run.controller = make_controller(run.chain, control.method, scenario.path_limits(), control.candidates(), say)


def _follow_all(run: PathRun, oracle: bool, say: Progress) -> None:
    """Every path, and where wanted the oracle on it; what an interruption leaves of one is kept."""
    scenario = run.scenario
    assert run.chain is not None and run.controller is not None
    for number, (name, path) in enumerate(run.paths.items()):
        say(f"following {name}")
        try:
            result = follow(scenario, run.chain, run.controller, name, path, number)
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


def recorded_seconds(pieces: Sequence[Demonstration], graph: InteractionGraph) -> dict[str, float]:
    """Simulated robot time that went into demonstrations, per interaction name [s].

    A piece in which the robot was recorded took its time; one without it (somebody else moved the parent) did not.
    """
    out = {edge.name: 0.0 for edge in graph.interactions}
    for piece in pieces:
        if not piece.has(graph.root, graph.objects[graph.root]):
            continue
        for edge in graph.interactions:
            if all(piece.has(end, graph.objects[end]) for end in (edge.parent, edge.child)):
                out[edge.name] += (len(piece) - 1) * TICK
    return out


def record_pieces(
    run: PathRun, keep: Path | None, say: Progress, known: Collection[str] = (), *, overwrite: bool = False
) -> None:
    """Record demonstrations, writing each as soon as it is there; what Ctrl-C leaves of a piece is written too.

    Args:
        run: gets them.
        keep: folder for them.
        say: called with a line before each.
        known: interactions that need none.
        overwrite: whether files in that folder may be replaced.
    """
    try:
        with threadpool_limits(limits=1):  # as `run_paths`, whoever records
            for piece in run.scenario.record_demonstrations(say, known):
                run.pieces.append(piece)
                if keep is not None:
                    write_demonstrations([piece], keep, overwrite=overwrite)
    except RecordingInterrupted as stopped:
        run.pieces.append(stopped.piece)
        if keep is not None:
            write_demonstrations([stopped.piece], keep, overwrite=overwrite)
        raise
