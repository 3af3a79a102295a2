"""Trials of a goal with demonstrations of their own, and those that share one set; both are jobs of the runner."""

from __future__ import annotations

import itertools
import time
from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, Generic, TypeVar

from threadpoolctl import threadpool_limits

from ichain_drake import rules
from ichain_drake.demonstrations import Demonstration
from ichain_drake.errors import IchainError
from ichain_drake.graph import InteractionGraph
from ichain_drake.learning import InteractionModel, InteractionSpec
from ichain_drake.robot import Physics
from ichain_drake.runs.clusters.isolated import Job
from ichain_drake.runs.clusters.workers import Workers
from ichain_drake.runs.goals.many import timed_trials
from ichain_drake.runs.goals.settings import graph_spec
from ichain_drake.runs.goals.trial import Trial, run_trial, without_roles
from ichain_drake.runs.goals.variants import NO_ROLES, GoalVariant, piece_order
from ichain_drake.runs.learn import learn
from ichain_drake.scenarios.base import Scenario
from ichain_drake.scenarios.graph_scenario import record_seeds

Row = dict[str, Any]
JobT = TypeVar("JobT", bound=Job)
ApartT = TypeVar("ApartT", bound=Job)


TOGETHER = 16
"""Seeds of one job, at most: more are hardly faster, and a killed process would lose them all."""


def record_pieces(kind: type[Scenario], overrides: Sequence[str], physics: Physics, seed: int) -> list[Demonstration]:
    """The demonstrations of a seed."""
    with threadpool_limits(limits=1):
        return list(kind(overrides, physics, seed).record_demonstrations())


def try_to_learn(
    graph: InteractionGraph, pieces: Sequence[Demonstration], key: str | int, spec: InteractionSpec
) -> InteractionModel | str:
    """Models, or why there are none: too few pieces are a finding, no mistake of the user's.

    Args:
        graph: the interaction graph.
        pieces: to learn from.
        key: see `GoalVariant.learning`.
        spec: candidate estimators.
    """
    try:
        return learn(without_roles(graph) if key == NO_ROLES else graph, pieces, spec=spec)
    except IchainError as error:
        return " ".join(str(error).split())


@dataclass(frozen=True)
class SharedTrial:
    """One run with what others learned from too; its one finding is its row.

    Attributes:
        trial: what to run.
        model: what was learned, or why nothing was.
    """

    trial: Trial
    model: InteractionModel | str

    @property
    def ids(self) -> tuple[str, ...]:
        """Method, case and number."""
        return (f"{self.trial.method}/{self.trial.case}/{self.trial.number}",)

    def run(self, ids: Collection[str]) -> Iterator[tuple[str, Row]]:
        """The row."""
        yield self.ids[0], run_trial(self.trial, self.model)

    def failed(self, name: str, reason: str) -> Row:
        """The row of a trial that raised."""
        return self.trial.failed(reason)


@dataclass(frozen=True)
class FreshSeed:
    """One run of each line with demonstrations of its own seed, as `ichain run --seed` has them; a finding is a row.

    Runs of one line share nothing. Lines of one seed share the demonstrations: they are recorded and learned from once.
    A run without a rule that nobody asked for in the run with it is that one, and not done again.

    Attributes:
        kind: the scenario's class; a worker process makes its own.
        overrides: its settings.
        physics: of the world.
        seed: of demonstrations and runs.
        goal: as text.
        variants: the lines.
        names: of the findings, one a line; by default method, case and seed.
    """

    kind: type[Scenario]
    overrides: tuple[str, ...]
    physics: Physics
    seed: int
    goal: tuple[str, ...]
    variants: tuple[GoalVariant, ...]
    names: tuple[str, ...] = ()

    @property
    def ids(self) -> tuple[str, ...]:
        """One name a line."""
        return self.names or tuple(f"{v.method}/{v.case}/fresh {self.seed}" for v in self.variants)

    def run(self, ids: Collection[str]) -> Iterator[tuple[str, Row]]:
        """Record, learn and run; rows have `learning_seconds` and `plan_seconds` of processor and `wall_seconds`."""
        return _found([self], ids)

    def failed(self, name: str, reason: str) -> Row:
        """The row of a trial that raised: in recording, as `run_trial` catches the rest."""
        variant = self.variants[self.ids.index(name)]
        return self.trial(variant, 0).failed(reason) | _times(0.0, 0.0, 0.0)

    def trial(self, variant: GoalVariant, pieces: int) -> Trial:
        """A line's trial with so many pieces."""
        shown = variant.learning if isinstance(variant.learning, int) else pieces
        settings = (*self.overrides, *variant.settings)
        return Trial(
            variant.method, variant.case, self.kind, settings, self.physics, self.seed, 0, self.goal, variant.monitors,
            shown, fresh=True,
        )  # fmt: skip


@dataclass(frozen=True)
class _Joined(Generic[ApartT]):
    """Jobs of the same lines, in `ideal` physics calculated together; rows are equal to those of each alone.

    Attributes:
        apart: the jobs.
    """

    apart: tuple[ApartT, ...]

    @property
    def ids(self) -> tuple[str, ...]:
        """Line after line, of each all jobs."""
        return tuple(name for line in zip(*(job.ids for job in self.apart), strict=True) for name in line)

    def failed(self, name: str, reason: str) -> Row:
        """As the job's that has the name."""
        return next(job for job in self.apart if name in job.ids).failed(name, reason)


class FreshSeeds(_Joined[FreshSeed]):
    """Seeds that are recorded and run together."""

    def run(self, ids: Collection[str]) -> Iterator[tuple[str, Row]]:
        """As each seed's; what they do together counts as the same part of everyone's seconds."""
        return _found(self.apart, ids)


class SharedTrials(_Joined[SharedTrial]):
    """Runs of one model that are calculated together."""

    def run(self, ids: Collection[str]) -> Iterator[tuple[str, Row]]:
        """The rows."""
        wanted = [one for one in self.apart if one.ids[0] in ids]
        rows = timed_trials([one.trial for one in wanted], [one.model for one in wanted])
        for one, (row, _) in zip(wanted, rows, strict=True):
            yield one.ids[0], row


def join(jobs: Iterable[JobT], workers: Workers) -> list[JobT | FreshSeeds | SharedTrials]:
    """Join trials that can be calculated together, in as many jobs of a size as keep every worker busy.

    Args:
        jobs: seeds, shared trials, and others, which stay as they are.
        workers: who works; where a trial's time is limited each stays alone, and where nobody knows how many work.
    """
    joined: list[JobT | FreshSeeds | SharedTrials] = []
    for joins, group in itertools.groupby(jobs, _joins):
        some = list(group)
        if joins is None or len(some) == 1 or workers.trial_timeout or workers.address:
            joined += some
            continue
        kind: Any = FreshSeeds if isinstance(some[0], FreshSeed) else SharedTrials
        rounds = -(-len(some) // (TOGETHER * workers.processes))
        size = -(-len(some) // (rounds * workers.processes))
        joined += [kind(tuple(some[k : k + size])) for k in range(0, len(some), size)]
    return joined


def _joins(job: Any) -> Any:
    """What trials that can be joined have in common; None for what stays alone."""
    if isinstance(job, SharedTrial) and job.trial.physics == "ideal":
        return replace(job.trial, seed=0, number=0), id(job.model)
    if isinstance(job, FreshSeed) and job.physics == "ideal" and not any(v.without for v in job.variants):
        return job.kind, job.overrides, job.goal, job.variants
    return None


def _found(seeds: Sequence[FreshSeed], ids: Collection[str]) -> Iterator[tuple[str, Row]]:
    """The rows of seeds that have the same lines, line by line."""
    began = time.monotonic()
    scenarios = [seed.kind(seed.overrides, seed.physics, seed.seed) for seed in seeds]
    with threadpool_limits(limits=1):
        pieces = record_seeds(scenarios)
    recorded = (time.monotonic() - began) / len(seeds)
    learned: dict[tuple[int, str | int], tuple[InteractionModel | str, float, float]] = {}
    complete: dict[GoalVariant, tuple[list[tuple[Row, float]], set[str]]] = {}
    for number, variant in enumerate(seeds[0].variants):
        wanted = [k for k, seed in enumerate(seeds) if seed.ids[number] in ids]
        for k in wanted:
            if (k, variant.learning) not in learned:
                learned[k, variant.learning] = _learned(scenarios[k], pieces[k], variant.learning)
        taught = [learned[k, variant.learning] for k in wanted]
        began = time.monotonic()
        done, asked = complete.get(replace(variant, without=""), ([], {variant.without}))
        if variant.without in asked:
            with rules.noted() as asked, rules.without([variant.without] if variant.without else []):
                trials = [seeds[k].trial(variant, len(pieces[k])) for k in wanted]
                done = timed_trials(trials, [model for model, _, _ in taught])
        if not variant.without:
            complete[variant] = done, asked
        ran = (time.monotonic() - began) / max(1, len(wanted))
        for k, (row, planning), (_, busy, wall) in zip(wanted, done, taught, strict=True):
            yield seeds[k].ids[number], row | _times(busy, planning, recorded + wall + ran)


def _learned(
    scenario: Scenario, pieces: Sequence[Demonstration], key: str | int
) -> tuple[InteractionModel | str, float, float]:
    """See `try_to_learn`; and its seconds, of the processor and of the clock."""
    wall, busy = time.monotonic(), time.process_time()
    shown = piece_order(pieces, scenario.seed)[:key] if isinstance(key, int) else pieces
    found = try_to_learn(scenario.graph, shown, key, graph_spec(scenario.config))
    return found, time.process_time() - busy, time.monotonic() - wall


def _times(learning: float, plan: float, wall: float) -> dict[str, float]:
    seconds = {"learning_seconds": learning, "plan_seconds": plan, "wall_seconds": wall}
    return {key: round(value, 3) for key, value in seconds.items()}
