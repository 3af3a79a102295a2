"""The scoreboard's trials as jobs: of one system, physics and seed, all that share demonstrations."""

from __future__ import annotations

import time
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from threadpoolctl import threadpool_limits

from ichain_drake.errors import IchainError
from ichain_drake.runs.clusters.isolated import Job, reason_of
from ichain_drake.runs.goals.fresh import FreshSeed
from ichain_drake.runs.goals.run import own_goal
from ichain_drake.runs.goals.trial import ERROR, LEARNING
from ichain_drake.runs.goals.variants import MONITORS, GoalVariant
from ichain_drake.runs.paths.choice import choose_paths
from ichain_drake.runs.paths.following import follow, oracle_follow
from ichain_drake.runs.paths.result import PathResult, PathRun
from ichain_drake.runs.paths.run import learn_to_follow
from ichain_drake.runs.pieces import record_pieces
from ichain_drake.runs.scoreboard.cases import NONE, Case
from ichain_drake.scenarios.base import PathScenario

LEFT = "left the path"
"""Why a path was not followed to its end, where nothing raised."""


def make_jobs(cases: Sequence[Case], first_seed: int) -> list[Job]:
    """One job for each system, physics, kind of demonstrations and seed.

    Args:
        cases: the rows.
        first_seed: of the first trial of every row; the others follow.
    """
    groups: dict[tuple[str, str, tuple[str, ...]], list[Case]] = {}
    for case in cases:
        groups.setdefault((case.system, case.physics, case.taught), []).append(case)
    jobs: list[Job] = []
    for group in groups.values():
        for number in range(max(case.trials for case in group)):
            chosen = tuple(case for case in group if number < case.trials)
            jobs.append(_job(chosen, first_seed + number, number))
    return jobs


def _job(cases: tuple[Case, ...], seed: int, number: int) -> Job:
    first = cases[0]
    if issubclass(first.kind, PathScenario):
        return PathTrials(cases, seed, number)
    goal = own_goal(first.kind((), first.physics, seed))  # type: ignore[arg-type] # it has what a goal needs
    variants = tuple(GoalVariant(MONITORS, case.fault, case.settings, without=case.without) for case in cases)
    names = tuple(case.trial(seed) for case in cases)
    return FreshSeed(first.kind, (), first.physics, seed, goal, variants, names)


@dataclass(frozen=True)
class PathTrials:
    """Paths followed by what one seed's demonstrations taught; a finding is a row.

    Attributes:
        cases: rows of one system and physics, and one kind of demonstrations.
        seed: of demonstrations and runs.
        number: of the trial: the oracle follows in the first few.
    """

    cases: tuple[Case, ...]
    seed: int
    number: int

    @property
    def ids(self) -> tuple[str, ...]:
        """Names of the trials."""
        return tuple(case.trial(self.seed) for case in self.cases)

    def run(self, ids: Collection[str]) -> Iterator[tuple[str, dict[str, Any]]]:
        """Record, learn, follow; the seconds are as in `FreshSeed.run`, but planning is a part of control here."""
        with threadpool_limits(limits=1):
            began = time.monotonic()
            first = self.cases[0]
            scenario: PathScenario = first.kind(first.taught, first.physics, self.seed)  # type: ignore[assignment] # see `_job`
            run = PathRun(scenario, choose_paths(scenario))
            record_pieces(scenario, run.pieces)
            busy = time.process_time()
            try:
                learn_to_follow(run)
            except IchainError as error:
                for case in self.cases:
                    if case.trial(self.seed) in ids:
                        yield case.trial(self.seed), self._row(case, reason_of(error), LEARNING)
                return
            seconds = {"learning_seconds": round(time.process_time() - busy, 3), "plan_seconds": None}
            before = time.monotonic() - began
            for case in self.cases:
                if case.trial(self.seed) in ids:
                    began = time.monotonic()
                    row = self._follow(case, run)
                    wall = round(before + time.monotonic() - began, 3)
                    yield case.trial(self.seed), row | seconds | {"wall_seconds": wall}

    def failed(self, name: str, reason: str) -> dict[str, Any]:
        """The row of a trial that raised before it could follow."""
        return self._row(self.cases[self.ids.index(name)], reason, ERROR)

    def _follow(self, case: Case, run: PathRun) -> dict[str, Any]:
        """One path; its number keys the noise and is that of `ichain run`, whichever rows are asked for."""
        assert run.chain is not None and run.controller is not None
        number, path = list(run.paths).index(case.task), run.paths[case.task]
        try:
            world: PathScenario = case.kind(case.settings, case.physics, self.seed)  # type: ignore[assignment]
            result = follow(world, run.chain, run.controller, case.task, path, number)
            other: PathResult | None = None
            if case.fault == NONE and self.number < case.oracle:
                other = oracle_follow(world, case.task, path, number)
        except Exception as error:  # a trial that breaks off is a finding, whatever raised
            return self._row(case, reason_of(error), ERROR)
        row = self._row(case, result.reason, "" if result.completed else LEFT)
        return row | {
            "success": result.completed,
            "error": result.error if result.completed else None,
            "oracle_error": other.error if other is not None and other.completed else None,
            "unit": world.unit,
            "control_steps": result.control_steps,
        }

    def _row(self, case: Case, reason: str, cause: str) -> dict[str, Any]:
        """A row without success; no failure of a path is silent: its controller never says that it is done."""
        return {
            "physics": case.physics, "case": case.fault, "seed": self.seed, "success": False, "error": None,
            "oracle_error": None, "unit": "", "reason": reason, "cause": cause, "silent": False, "control_steps": 0,
            "replans": None, "probability": None, "learning_seconds": None, "plan_seconds": None, "wall_seconds": None,
        }  # fmt: skip
