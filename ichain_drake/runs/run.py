"""The whole main job in one call, for paths and goals alike: demonstrations, learning, control, report."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ichain_drake.control.tracking.path import TimedPath
from ichain_drake.runs.goals.run import GraphRun, run_graph
from ichain_drake.runs.learn import Known
from ichain_drake.runs.paths.choice import choose_paths
from ichain_drake.runs.paths.result import PathRun
from ichain_drake.runs.paths.run import run_paths
from ichain_drake.scenarios.base import PathScenario, Progress


def start_run(
    scenario: Any,
    task: str | Sequence[str] | Mapping[str, TimedPath] = (),
    *,
    number: int = 0,
    smooth: bool = False,
) -> PathRun | GraphRun:
    """A run that has still to be carried out; arguments as for `run`.

    Args:
        scenario, task, number: see `run`.
        smooth: paths: whether corners are rounded as far as the demonstrations ask for.

    Raises:
        InputError: on a path that there isn't.
    """
    if isinstance(scenario, PathScenario):
        paths = dict(task) if isinstance(task, Mapping) else choose_paths(scenario, task)
        return PathRun(scenario, paths, smooth=smooth)
    return GraphRun(scenario, (task,) if isinstance(task, str) else tuple(task), number=number)


def carry_out(
    run: PathRun | GraphRun,
    *,
    known: Known | None = None,
    demos: str | Path | None = None,
    keep_demos: str | Path | None = None,
    oracle: bool = False,
    resampled: bool = False,
    progress: Progress | None = None,
) -> None:
    """Do everything up to the report, filling `run`, so that an interrupted one keeps what it has.

    Args:
        run: as `start_run` makes it.
        known, demos, oracle, progress: see `run`.
        keep_demos: folder that recorded demonstrations are written to.
        resampled: whether to take demonstrations of another period to the library's.

    Raises:
        InputError, UnreachableError: as `run`.
        EpisodeInterrupted, RecordingInterrupted: on Ctrl-C.
    """
    if isinstance(run, PathRun):
        run_paths(
            run, known=known, demos=demos, keep_demos=keep_demos, oracle=oracle, resampled=resampled, progress=progress
        )
    else:
        run_graph(run, known=known, demos=demos, keep_demos=keep_demos, resampled=resampled, progress=progress)


def run(
    scenario: Any,
    task: str | Sequence[str] | Mapping[str, TimedPath] = (),
    *,
    known: Known | None = None,
    demos: str | Path | None = None,
    number: int = 0,
    oracle: bool = False,
    progress: Progress | None = None,
) -> PathRun | GraphRun:
    """Record demonstrations, learn from them, and do a task, as `ichain run` does.

    Args:
        scenario: see `load_scenario`.
        task: a goal as text; or names of reference paths, or timed paths by name. The scenario's own by default.
        known: what was learned before, in place of learning; of what is known in part (see `load`), only the rest is
            recorded and learned.
        demos: folder of demonstrations to learn from, in place of recording them.
        number: of a run towards a goal; keys its start, noise and faults.
        oracle: whether to run the oracle on every path too, for comparison.
        progress: called with a line at each step.

    Returns:
        The run: `goal_reached`, `reason`, `report()`, `model`, `pieces`, and what is logged in it; `show` plays it.

    Raises:
        InputError: on a task, demonstrations or settings that can't be used.
        UnreachableError: if the arm can't get where it has to.
    """
    started = start_run(scenario, task, number=number)
    carry_out(started, known=known, demos=demos, oracle=oracle, progress=progress)
    return started
