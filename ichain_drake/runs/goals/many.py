"""Many trials towards a goal: together in `ideal` physics, elsewhere one by one; rows are equal to the bit."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import Any

from threadpoolctl import threadpool_limits

from ichain_drake.control.execution.executor import ExecutorSettings
from ichain_drake.control.planning.goal_text import check_goal_text
from ichain_drake.control.planning.goals import parse_goal
from ichain_drake.errors import IchainError
from ichain_drake.learning import InteractionModel
from ichain_drake.runs.goals.run import GraphRun, conclude, executor_of
from ichain_drake.runs.goals.trial import Trial, outcome, timed_trial
from ichain_drake.simulation.goals_together import act_together, look_together
from ichain_drake.simulation.recording_together import nobody_looks


def timed_trials(
    trials: Sequence[Trial], models: Sequence[InteractionModel | str]
) -> list[tuple[dict[str, Any], float]]:
    """`timed_trial` of each: its row, and the processor time that planning took in its run [s].

    Args:
        trials: of one system and line, which differ in seeds and numbers.
        models: what each runs with, or why nothing was learned.
    """
    able = [k for k, (t, m) in enumerate(zip(trials, models, strict=True)) if _able(t, m)]
    known: dict[int, tuple[dict[str, Any], float]] = {}
    if len(able) > 1 and nobody_looks():
        runs = _together([trials[k] for k in able], [models[k] for k in able])
        known = {
            k: (trials[k].row() | outcome(run), run.plan_seconds) for k, run in zip(able, runs, strict=True) if run
        }
    each = enumerate(zip(trials, models, strict=True))
    return [known[k] if k in known else timed_trial(trial, model) for k, (trial, model) in each]


def _able(trial: Trial, model: InteractionModel | str) -> bool:
    return trial.physics == "ideal" and isinstance(model, InteractionModel)


def _together(trials: Sequence[Trial], models: Sequence[Any]) -> list[GraphRun | None]:
    """The finished runs; None for what has to be run alone."""
    nothing: list[GraphRun | None] = [None] * len(trials)
    settings = ExecutorSettings(monitors=trials[0].monitors)
    try:
        with threadpool_limits(limits=1):
            scenarios = [t.kind(t.overrides, t.physics, t.seed) for t in trials]
            runs = [GraphRun(s, t.goal, number=t.number) for s, t in zip(scenarios, trials, strict=True)]  # type: ignore[arg-type] # they have goals
            return _run(runs, models, settings)
    except IchainError:
        return nothing
    except Exception as error:  # whatever it is, of a user's own object for instance: each run alone will show it
        why = f"{type(error).__name__}: {error}"
        warnings.warn(f"runs are calculated one by one: together they end in {why}", stacklevel=4)
        return nothing


def _run(
    runs: Sequence[GraphRun], models: Sequence[InteractionModel], settings: ExecutorSettings
) -> list[GraphRun | None]:
    """`run_graph` of all with what is known."""
    worlds = [run.scenario.make_world(run.number) for run in runs]
    executors = []
    for run, model, seen in zip(runs, models, look_together(worlds), strict=True):
        check_goal_text(run.expressions, run.scenario.graph)
        run.model, run.goal = model.for_goals(), parse_goal(run.expressions, model, seen)
        executors.append(executor_of(run, model, run.goal, None, settings, lambda line: None))
    found = act_together(worlds, executors, settings.ticks + 10)
    for run, one in zip(runs, found, strict=True):
        if one is not None:
            run.log, run.memory = one
            conclude(run)
    return [None if one is None else run for run, one in zip(runs, found, strict=True)]
