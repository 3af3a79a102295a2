"""`run` for path-following scenarios: demonstrations, learning, control, report, playback, pictures."""

from __future__ import annotations

import contextlib
import hashlib
import importlib.metadata
import platform
import time
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from threadpoolctl import threadpool_limits

from ichain_drake.control.chain import ChainController, make_controller
from ichain_drake.control.path import PathLimits, TimedPath, check_points, paper_path_error, path_error, read_path
from ichain_drake.control.systems import Controller
from ichain_drake.control.turns import check_turns
from ichain_drake.demonstrations import Demonstration, read_demonstrations, write_demonstrations
from ichain_drake.errors import InputError, UnreachableError
from ichain_drake.graph import InteractionGraph
from ichain_drake.learning.chain import LearnedChain, LearnedLink, learn_chain
from ichain_drake.learning.command import LearnedCommand
from ichain_drake.scenarios.base import PathScenario, Progress
from ichain_drake.scenarios.episode import EpisodeInterrupted, EpisodeLog, follow_path
from ichain_drake.scenarios.oracle import OraclePolicy
from ichain_drake.scenarios.recorder import RecordingInterrupted, whole_frames
from ichain_drake.scenarios.watching import watched_by
from ichain_drake.state import FloatArray
from ichain_drake.timing import FRAMES_PER_TICK, TICK

_MOST_POINTS = 10**6


@dataclass(frozen=True)
class PathResult:
    """One followed path.

    Attributes:
        name: of the path.
        path: the timed path.
        log: everything logged.
        completed: whether its end was reached.
        error: mean distance of all executed 30 Hz positions to the sampled path, in its unit.
        paper_metric: the paper's metric (sec. IV) on the same run.
        oracle_error: the oracle's `error` under the same noise; NaN if it was not run.
    """

    name: str
    path: TimedPath
    log: EpisodeLog
    completed: bool
    error: float
    paper_metric: float
    oracle_error: float = float("nan")

    @property
    def control_steps(self) -> int:
        """Decisions taken."""
        return (len(self.log.times) - 1) // FRAMES_PER_TICK

    def metrics(self) -> dict[str, Any]:
        """For the report."""
        return {
            "mean_error_px": self.error,
            "paper_metric_px": self.paper_metric,
            "completed": self.completed,
            "oracle_error_px": None if np.isnan(self.oracle_error) else self.oracle_error,
        }


@dataclass
class PathRun:
    """A run of a path scenario, filled as it goes, so that an interrupted one keeps what it has.

    Attributes:
        scenario: what runs.
        paths: to follow, by name.
        pieces: demonstrations.
        chain: learned links.
        controller: built from them.
        results: one per followed path.
        reason: why the goal was or was not reached.
        started: when, by the monotonic clock [s].
    """

    scenario: PathScenario
    paths: dict[str, TimedPath] = field(default_factory=dict)
    pieces: list[Demonstration] = field(default_factory=list)
    chain: LearnedChain | None = None
    controller: ChainController | None = None
    results: list[PathResult] = field(default_factory=list)
    reason: str = "interrupted"
    started: float = field(default_factory=time.monotonic)

    @property
    def goal_reached(self) -> bool:
        """Whether every path was completed."""
        return len(self.results) == len(self.paths) > 0 and all(r.completed for r in self.results)

    def report(self) -> dict[str, Any]:
        """The contents of `report.json`."""
        scenario = self.scenario
        paths = {r.name: r.metrics() for r in self.results}
        metrics: dict[str, Any] = {"paths": paths}
        if len(paths) == 1:
            metrics |= next(iter(paths.values()))
        return {
            "scenario": scenario.name,
            "physics": scenario.physics,
            "seed": scenario.seed,
            "goal_reached": self.goal_reached,
            "reason": self.reason,
            "control_steps": sum(r.control_steps for r in self.results),
            "sim_seconds": round(sum(float(r.log.times[-1]) for r in self.results), 6),
            "wall_seconds": time.monotonic() - self.started,
            "versions": versions(),
            "given": scenario.given(),
            "models": {} if self.chain is None else models_report(self.chain),
            "control": {} if self.controller is None else control_report(self.controller),
            "metrics": metrics,
        }


def versions() -> dict[str, str]:
    """Versions that a result may depend on."""
    names = ("ichain_drake", "drake", "numpy", "scipy", "scikit-learn", "pandas")
    found = {"python": platform.python_version()}
    for name in names:
        try:
            found[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            found[name] = "not installed"
    for name in ("gymnasium", "box2d"):  # an extra
        with contextlib.suppress(importlib.metadata.PackageNotFoundError):
            found[name] = importlib.metadata.version(name)
    return found


def models_report(chain: LearnedChain) -> dict[str, Any]:
    """Per interaction: samples, simulated robot time, scores and where it came from."""
    out = {}
    for link in chain.links:
        inverse = link.best_inverse
        out[link.interaction.name] = {
            "samples": link.forward.samples,
            "robot_seconds": round(link.robot_seconds, 6),
            "cross_validation_score": link.forward.score,
            "inverse_cross_validation_score": inverse.score,
            "forward": str(link.forward.spec),
            "inverse": str(inverse.spec),
            "residual_std": {
                v: float(s)
                for v, s in zip(link.forward.model.child_space.names, link.forward.residual_std, strict=True)
            },
            "source": link.source,
        }
    return out


def control_report(controller: ChainController) -> dict[str, Any]:
    """What validation chose, and from what."""
    return {
        "method": controller.method,
        "chosen": controller.choice.label,
        "validation": {o.label: None if not np.isfinite(o.error) else o.error for o in controller.options},
    }


def choose_paths(scenario: PathScenario, names: Sequence[str] = (), file: Path | None = None) -> dict[str, TimedPath]:
    """The paths of a run: reference paths by name (default all), or one from a CSV file.

    Raises:
        InputError: on an unknown name, a bad file, or a point outside the plane.
    """
    limits = scenario.path_limits()
    if file is not None:
        points = read_path(file, scenario.target_variables)
        _check_inside(points, scenario, str(file))
        _check_length(points, limits, str(file), scenario.unit)
        return {file.stem: TimedPath(points, limits)}
    known = scenario.reference_paths()
    for name in names:
        if name not in known:
            raise InputError(f"{scenario.name} has no path {name!r}; it has {', '.join(known)}")
    chosen = {n: known[n] for n in (names or known)}
    for name, points in chosen.items():
        check_points(points, f"path {name}", scenario.target_variables)
        _check_length(points, limits, f"path {name}", scenario.unit)
    return {n: TimedPath(p, limits) for n, p in chosen.items()}


def _check_inside(points: FloatArray, scenario: PathScenario, where: str) -> None:
    outside = ((points < 0) | (points > np.array(scenario.size))).any(axis=1)
    if outside.any():
        row = int(np.argmax(outside))
        x, y = points[row]
        raise InputError(
            f"{where}: line {row + 2}: ({x:g}, {y:g}) {scenario.unit} is outside the screen of "
            f"{scenario.size[0]:g} x {scenario.size[1]:g} {scenario.unit}"
        )


def _check_length(points: FloatArray, limits: PathLimits, where: str, unit: str) -> None:
    length = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
    if length <= limits.tolerance:
        raise InputError(
            f"{where}: it is {length:.3g} {unit} long; an end counts as reached within {limits.tolerance:g} {unit}, so "
            "give a longer path"
        )
    if length / limits.spacing > _MOST_POINTS:
        raise InputError(
            f"{where}: {length:.0f} {unit} at path.spacing {limits.spacing:g} are over {_MOST_POINTS} points; give a "
            "larger spacing"
        )


def check_settings(scenario: PathScenario) -> None:
    """Refuse estimators that learning would refuse, before minutes of recording; a scenario has checked the rest.

    Raises:
        InputError: on an unknown estimator or parameter; names the interaction.
    """
    for name, link in scenario.config.learning.candidates().items():
        for spec in (*link.forward, *link.inverse, *([link.screening] if link.screening else [])):
            try:
                spec.make()
            except (ValueError, TypeError) as error:  # InputError is one; constructors may raise both
                raise InputError(f"{name}: {spec}: {error}") from None


def run_paths(
    run: PathRun,
    *,
    demos: Path | None = None,
    keep_demos: Path | None = None,
    known: Mapping[str, LearnedLink] | None = None,
    known_command: LearnedCommand | None = None,
    oracle: bool = True,
    progress: Progress | None = None,
) -> None:
    """Do everything up to the report, filling `run`.

    Args:
        run: with `scenario` and `paths` set.
        demos: folder of demonstrations to learn from, in place of recording them.
        keep_demos: folder that recorded demonstrations are written to.
        known: links from a library, by interaction name; what only they need is not demonstrated again.
        known_command: what the library knows about commanding the hand.
        oracle: whether to run the oracle on every path too.
        progress: called with a line at each step.

    Raises:
        InputError: on bad settings, demonstrations or paths.
        UnreachableError: if the arm can't get where it has to; `run.reason` says why.
    """
    check_settings(run.scenario)
    # One BLAS thread: the matrices are small, and sums must not depend on how many cores there are.
    with threadpool_limits(limits=1):
        try:
            _run_paths(run, demos, keep_demos, known, known_command, oracle, progress or (lambda line: None))
        except UnreachableError as error:
            run.reason = str(error)
            raise


def _run_paths(
    run: PathRun,
    demos: Path | None,
    keep_demos: Path | None,
    known: Mapping[str, LearnedLink] | None,
    known_command: LearnedCommand | None,
    oracle: bool,
    say: Progress,
) -> None:
    scenario = run.scenario
    if demos is not None:
        run.pieces = read_demonstrations(demos, scenario.graph)
    else:
        record_pieces(run, keep_demos, say, set(known or ()))
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
        check_turns(path, run.chain, f"path {name}", scenario.unit)
    control = scenario.config.control
    run.controller = make_controller(run.chain, control.method, scenario.path_limits(), control.candidates(), say)
    for number, (name, path) in enumerate(run.paths.items()):
        say(f"following {name}")
        try:
            result = follow(scenario, run.chain, run.controller, name, path, number)
        except EpisodeInterrupted as stopped:
            log = whole_frames(stopped.log)
            if len(log.times) > 1:
                run.results.append(_result(scenario, name, path, log, False, number))
            raise
        run.results.append(result)
        if oracle and scenario.has_oracle:
            say(f"the oracle on {name}")
            with watched_by(None):  # a person who looks on must not push the oracle's car
                run.results[-1] = _with_oracle(scenario, result, number)
    lost = [r.name for r in run.results if not r.completed]
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


def record_pieces(run: PathRun, keep: Path | None, say: Progress, known: Collection[str] = ()) -> None:
    """Record demonstrations, writing each as soon as it is there; what Ctrl-C leaves of a piece is written too."""
    try:
        with threadpool_limits(limits=1):  # as `run_paths`, whoever records
            for piece in run.scenario.record_demonstrations(say, known):
                run.pieces.append(piece)
                if keep is not None:
                    write_demonstrations([piece], keep)
    except RecordingInterrupted as stopped:
        run.pieces.append(stopped.piece)
        if keep is not None:
            write_demonstrations([stopped.piece], keep)
        raise


def follow(
    scenario: PathScenario,
    chain: LearnedChain,
    controller: ChainController,
    name: str,
    path: TimedPath,
    number: int,
) -> PathResult:
    """Follow one path with a learned controller.

    Args:
        scenario: makes the world.
        chain: the learned chain; its objects' `measured` are read.
        controller: decides.
        name: of the path.
        path: the timed path.
        number: of the run; keys its noise.
    """
    world, prepare = scenario.make_world(path, number)
    spaces = {n: scenario.graph.objects[n].observable for n in chain.names}
    middle = (chain.command_lower + chain.command_upper) / 2
    system = Controller(controller.policy, spaces, len(chain.targets), middle)
    log, completed = follow_path(world, system, prepare, path, scenario.target, chain.targets)
    return _result(scenario, name, path, log, completed, number)


def _with_oracle(scenario: PathScenario, result: PathResult, number: int) -> PathResult:
    other = oracle_follow(scenario, result.name, result.path, number)
    return PathResult(
        result.name,
        result.path,
        result.log,
        result.completed,
        result.error,
        result.paper_metric,
        other.error if other.completed else float("nan"),
    )


def oracle_follow(scenario: PathScenario, name: str, path: TimedPath, number: int) -> PathResult:
    """Follow one path with the oracle: the true model, the true states, the same noise."""
    world, prepare = scenario.make_world(path, number)
    graph = scenario.graph
    names = graph.chain(scenario.target)
    hand = graph.objects[names[0]]
    targets = [graph.objects[scenario.target].index(v) for v in scenario.target_variables]
    chart = scenario.command_chart()
    policy = OraclePolicy(
        graph,
        world.objects,
        scenario.target,
        targets,
        path.limits.speed * TICK,
        *scenario.command_range(),
        scenario.oracle_weights,
        chart,
    )
    spaces = {n: graph.objects[n] for n in names}
    middle = np.mean(scenario.command_range(), axis=0)
    middle = middle if chart is None else chart.to_hand(middle)
    system = Controller(policy, spaces, 2, middle, policy.sizes)  # type: ignore[arg-type]
    indices = scenario.target_indices()
    log, completed = follow_path(world, system, prepare, path, scenario.target, indices, truth=names[1:])
    if len(hand) != policy.sizes[0]:
        raise InputError("the oracle needs a hand without hidden variables")
    return _result(scenario, name, path, log, completed, number)


def _result(
    scenario: PathScenario, name: str, path: TimedPath, log: EpisodeLog, completed: bool, number: int
) -> PathResult:
    space = scenario.graph.objects[scenario.target]
    executed = log.states[scenario.target][:, [space.index(v) for v in scenario.target_variables]]
    ticks = np.arange(0.0, path.time[-1] + TICK, TICK)
    waypoints = path.at_time(np.minimum(ticks, path.time[-1]))
    rng = np.random.default_rng([scenario.seed, number, 77])
    return PathResult(
        name, path, log, completed, path_error(executed, path), paper_path_error(executed, waypoints, rng)
    )


def data_hash(pieces: Sequence[Demonstration]) -> str:
    """A hash of demonstrations' values, for a library's manifest."""
    digest = hashlib.sha256()
    for piece in pieces:
        digest.update(",".join(piece.table.columns).encode())
        digest.update(pd.util.hash_pandas_object(piece.table, index=False).to_numpy().tobytes())
    return digest.hexdigest()
