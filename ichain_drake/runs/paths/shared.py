"""Evaluations of paths in which all trials share the demonstrations of one seed: starts and noise are their own."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from ichain_drake.control.tracking.chain import ChainController
from ichain_drake.errors import IchainError, InputError
from ichain_drake.learning.chain.chain import LearnedChain
from ichain_drake.robot import Physics
from ichain_drake.runs.clusters.isolated import reason_of
from ichain_drake.runs.clusters.workers import Say, Workers
from ichain_drake.runs.paths.choice import choose_paths
from ichain_drake.runs.paths.evaluation import (
    FIRST_LINK,
    FULL,
    METHODS,
    PathVariant,
    check_evaluation,
    chosen_variants,
    learn_variant,
    path_row,
    plain_row,
)
from ichain_drake.runs.paths.many import Found, follow_many, oracle_follow_many
from ichain_drake.runs.paths.summary import ORACLE, summarise
from ichain_drake.runs.row_file import RowFile
from ichain_drake.runs.runner import evaluate_jobs
from ichain_drake.scenarios.base import PathScenario

Row = dict[str, Any]
Learned = tuple[LearnedChain, ChainController] | str
"""A variant's links and controller, or why there are none."""

_TOGETHER = 256
"""Trials of one job, at most: bounds the memory of what they log, and what a killed process loses."""


def check_shared_evaluation(scenario: PathScenario, trials: int, methods: Sequence[str]) -> None:
    """Refuse what `evaluate_shared_paths` would refuse, before work starts.

    Raises:
        InputError: as `check_evaluation`, or on a method that nothing is followed by.
    """
    check_evaluation(scenario, trials, methods)
    if FIRST_LINK in methods:
        raise InputError(
            f"--shared: {FIRST_LINK} has no trials of one seed's demonstrations; leave it out of --methods"
        )


def evaluate_shared_paths(
    scenario: PathScenario,
    overrides: Sequence[str],
    trials: int,
    methods: Sequence[str] = (),
    workers: Workers | None = None,
    progress: Say | None = None,
    rows: RowFile | None = None,
) -> dict[str, Any]:
    """`evaluate_paths`, but all trials follow with what was learned from the demonstrations of the scenario's seed.

    In `ideal` physics the trials of a job are calculated together; rows don't depend on it. Arguments and errors are as
    there, but for the first link, which is left out.

    Returns:
        `rows` (one a run, each with the seed of its `demonstrations`) and `table`.
    """
    check_shared_evaluation(scenario, trials, methods)
    rows, workers = rows or RowFile(), workers or Workers()
    chosen = tuple(m for m in methods or METHODS if m != FIRST_LINK)
    variants = chosen_variants(chosen)
    with threadpool_limits(limits=1):
        learned = _learn(scenario, overrides, variants, progress or (lambda line, fraction: None))
    size = 1 if workers.trial_timeout else min(_TOGETHER, -(-trials // workers.processes))
    work = [
        SharedSeeds(
            type(scenario), tuple(overrides), scenario.physics, scenario.seed,
            tuple(range(scenario.seed + k, scenario.seed + min(k + size, trials))),
            tuple(zip(variants, learned, strict=True)), ORACLE in chosen and not scenario.no_oracle,
        )
        for k in range(0, trials, size)
    ]  # fmt: skip

    def found() -> dict[str, Any]:
        flat = [row for seed in rows.of(i for job in work for i in job.ids) for row in seed]
        return {"rows": flat, "table": summarise(flat)}

    return evaluate_jobs(work, workers, rows, found, progress)


def _learn(
    scenario: PathScenario, overrides: Sequence[str], variants: Sequence[PathVariant], say: Say
) -> list[Learned]:
    """What every variant makes of the demonstrations of the scenario's seed."""
    most = max([v.samples for v in variants if not v.monolithic], default=FULL)
    scenario = type(scenario)([*overrides, f"learning.samples={most}"], scenario.physics, scenario.seed)
    say(f"learning from the demonstrations of seed {scenario.seed}", None)
    pieces = list(scenario.record_demonstrations()) if variants else []
    whole = [scenario.monolithic_demonstration(2 * FULL)] if any(v.monolithic for v in variants) else []
    learned: list[Learned] = []
    for variant in variants:
        try:
            learned.append(learn_variant(scenario, variant, whole if variant.monolithic else pieces))
        except IchainError as error:
            learned.append(str(error))
    return learned


@dataclass(frozen=True)
class SharedSeeds:
    """Runs of several seeds with what others learned from too, a job of the runner; a finding is a seed's rows.

    Attributes:
        kind: the scenario's class; a worker process makes its own.
        overrides: its settings.
        physics: of the world.
        demonstrated: seed of the demonstrations.
        seeds: of starts and noise.
        learned: variants, with what they made of the demonstrations.
        oracle: whether the oracle follows, too.
    """

    kind: type[PathScenario]
    overrides: tuple[str, ...]
    physics: Physics
    demonstrated: int
    seeds: tuple[int, ...]
    learned: tuple[tuple[PathVariant, Learned], ...]
    oracle: bool

    @property
    def ids(self) -> tuple[str, ...]:
        """The seeds."""
        return tuple(f"seed {seed}" for seed in self.seeds)

    def run(self, ids: Collection[str]) -> Iterator[tuple[str, list[Row]]]:
        """Every seed's rows, when all of them are finished."""
        scenarios = [self._scenario(seed) for seed, name in zip(self.seeds, self.ids, strict=True) if name in ids]
        if not _same_paths(scenarios):
            for scenario in scenarios:
                yield from self._rows([scenario])
        else:
            yield from self._rows(scenarios)

    def _rows(self, scenarios: Sequence[PathScenario]) -> Iterator[tuple[str, list[Row]]]:
        rows: list[list[Row]] = [[] for _ in scenarios]
        with threadpool_limits(limits=1):
            for method, samples, learned in self._methods():
                for number, (name, path) in enumerate(choose_paths(scenarios[0]).items()):
                    found: list[Found] | list[str]
                    if isinstance(learned, str):
                        found = [learned for _ in scenarios]
                    elif learned is None:
                        found = oracle_follow_many(scenarios, name, path, number)
                    else:
                        found = follow_many(scenarios, *learned, name, path, number)
                    for of_seed, scenario, one in zip(rows, scenarios, found, strict=True):
                        of_seed.append(self._row(method, samples, scenario, name, one))
        for scenario, of_seed in zip(scenarios, rows, strict=True):
            yield f"seed {scenario.seed}", of_seed

    def failed(self, name: str, reason: str) -> list[Row]:
        """Rows without success, one for each path and method."""
        scenario = self._scenario(self.seeds[self.ids.index(name)])
        cases = choose_paths(scenario)
        return [self._row(method, n, scenario, case, reason) for method, n, _ in self._methods() for case in cases]

    def _scenario(self, seed: int) -> PathScenario:
        return self.kind(self.overrides, self.physics, seed)

    def _methods(self) -> list[tuple[str, int, Learned | None]]:
        told: list[tuple[str, int, Learned | None]] = [(v.method, v.samples, learned) for v, learned in self.learned]
        return told + ([(ORACLE, 0, None)] if self.oracle else [])

    def _row(self, method: str, samples: int, scenario: PathScenario, case: str, found: Found | str) -> Row:
        shared = {"demonstrations": f"seed {self.demonstrated}"}
        if isinstance(found, str | Exception):
            reason = found if isinstance(found, str) else reason_of(found)
            return plain_row(method, samples, scenario, case, reason) | shared
        return path_row(method, samples, scenario, case, found) | shared


def _same_paths(scenarios: Sequence[PathScenario]) -> bool:
    """Whether all follow the same paths; one of a user's may draw them by its seed."""
    first, limits = scenarios[0].reference_paths(), scenarios[0].path_limits()
    return all(
        list(paths) == list(first)
        and all(np.array_equal(points, first[name]) for name, points in paths.items())
        and scenario.path_limits() == limits
        for scenario in scenarios
        for paths in [scenario.reference_paths()]
    )
