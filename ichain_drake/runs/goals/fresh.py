"""Trials of a goal with demonstrations of their own, and those that share one set; both are jobs of the runner."""

from __future__ import annotations

import time
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

from threadpoolctl import threadpool_limits

from ichain_drake import rules
from ichain_drake.demonstrations import Demonstration
from ichain_drake.errors import IchainError
from ichain_drake.graph import InteractionGraph
from ichain_drake.learning import InteractionModel, InteractionSpec
from ichain_drake.robot import Physics
from ichain_drake.runs.goals.settings import graph_spec
from ichain_drake.runs.goals.trial import Trial, run_trial, timed_trial, without_roles
from ichain_drake.runs.goals.variants import NO_ROLES, GoalVariant, piece_order
from ichain_drake.runs.learn import learn
from ichain_drake.scenarios.base import Scenario

Row = dict[str, Any]


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
        began = time.monotonic()
        scenario = self.kind(self.overrides, self.physics, self.seed)
        pieces = record_pieces(self.kind, self.overrides, self.physics, self.seed)
        recorded, spec = time.monotonic() - began, graph_spec(scenario.config)
        learned: dict[str | int, tuple[InteractionModel | str, float, float]] = {}
        complete: dict[GoalVariant, tuple[Row, float, set[str]]] = {}
        for name, variant in zip(self.ids, self.variants, strict=True):
            if name not in ids:
                continue
            key = variant.learning
            if key not in learned:
                wall, busy = time.monotonic(), time.process_time()
                shown = piece_order(pieces, self.seed)[:key] if isinstance(key, int) else pieces
                found = try_to_learn(scenario.graph, shown, key, spec)
                learned[key] = found, time.process_time() - busy, time.monotonic() - wall
            model, busy, wall = learned[key]
            began = time.monotonic()
            row, planning, asked = complete.get(replace(variant, without=""), ({}, 0.0, {variant.without}))
            if variant.without in asked:
                with rules.noted() as asked, rules.without([variant.without] if variant.without else []):
                    row, planning = timed_trial(self._trial(variant, len(pieces)), model)
            if not variant.without:
                complete[variant] = row, planning, asked
            seconds = (busy, planning, recorded + wall + time.monotonic() - began)
            yield name, row | _times(*seconds)

    def failed(self, name: str, reason: str) -> Row:
        """The row of a trial that raised: in recording, as `run_trial` catches the rest."""
        variant = self.variants[self.ids.index(name)]
        return self._trial(variant, 0).failed(reason) | _times(0.0, 0.0, 0.0)

    def _trial(self, variant: GoalVariant, pieces: int) -> Trial:
        shown = variant.learning if isinstance(variant.learning, int) else pieces
        settings = (*self.overrides, *variant.settings)
        return Trial(
            variant.method, variant.case, self.kind, settings, self.physics, self.seed, 0, self.goal, variant.monitors,
            shown, fresh=True,
        )  # fmt: skip


def _times(learning: float, plan: float, wall: float) -> dict[str, float]:
    seconds = {"learning_seconds": learning, "plan_seconds": plan, "wall_seconds": wall}
    return {key: round(value, 3) for key, value in seconds.items()}
