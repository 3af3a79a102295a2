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
    if isinstance(scenario, PathScenario):
        paths = dict(task) if isinstance(task, Mapping) else choose_paths(scenario, task)
        following = PathRun(scenario, paths)
        run_paths(following, known=known, demos=demos, oracle=oracle, progress=progress)
        return following
    towards = GraphRun(scenario, (task,) if isinstance(task, str) else tuple(task), number=number)
    run_graph(towards, known=known, demos=demos, progress=progress)
    return towards
