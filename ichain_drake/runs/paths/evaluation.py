"""`evaluate` for path-following scenarios: methods, a baseline and an oracle, over many seeds, under the same noise."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from ichain_drake.control.tracking.chain import ChainController, make_controller
from ichain_drake.demonstrations.table import Demonstration
from ichain_drake.errors import IchainError, InputError
from ichain_drake.graph import InteractionGraph
from ichain_drake.learning.chain.chain import LearnedChain, LinkCandidates, learn_chain, replace_samples
from ichain_drake.robot import Physics
from ichain_drake.runs.clusters.workers import Say, Workers
from ichain_drake.runs.paths.choice import choose_paths
from ichain_drake.runs.paths.following import follow, oracle_follow
from ichain_drake.runs.paths.link_accuracy import (
    HasWantedStates,
    first_link_graph,
    learn_first_link,
    measure_first_link,
)
from ichain_drake.runs.paths.result import PathResult
from ichain_drake.runs.paths.summary import ORACLE, summarise
from ichain_drake.runs.pieces import check_settings
from ichain_drake.runs.row_file import RowFile
from ichain_drake.runs.runner import evaluate_jobs
from ichain_drake.scenarios.base import PathScenario

FULL = 500
"""Transitions per link that the paper had (sec. IV)."""

CURVE = (50, 100, 200, 500, 1000)


@dataclass(frozen=True)
class PathVariant:
    """One row of the evaluation's table.

    Attributes:
        method: name in the report.
        control: `inverse` or `predictive`.
        samples: transitions per link; for `monolithic`, of the one link.
        action: the parent's state that is the action.
        monolithic: whether the chain's middle is left out: robot straight to the target.
        description: in words.
    """

    method: str
    control: str
    samples: int = FULL
    action: str = "next"
    monolithic: bool = False
    description: str = ""

    @property
    def label(self) -> str:
        """Method and samples."""
        return f"{self.method}@{self.samples}"


VARIANTS: tuple[PathVariant, ...] = (
    *(PathVariant("paper", "inverse", n, description="direct polynomial inverse at each level") for n in CURVE),
    *(PathVariant("default", "predictive", n, description="learned forward model, predictive control") for n in CURVE),
    PathVariant("parent_t", "inverse", action="current", description="paper's method; parent's state at t"),
    PathVariant("parent_t_default", "predictive", action="current", description="default; parent's state at t"),
    PathVariant("monolithic", "predictive", 2 * FULL, monolithic=True, description="robot -> target, default method"),
    PathVariant(
        "monolithic_paper", "inverse", 2 * FULL, monolithic=True, description="robot -> target; paper's method"
    ),
)
FIRST_LINK = "first_link"
"""Not a way to follow paths: how well the chain's first link reaches wanted states of its child."""

METHODS: tuple[str, ...] = (*dict.fromkeys(v.method for v in VARIANTS), ORACLE, FIRST_LINK)
_LABELS = tuple(v.label for v in VARIANTS)


def check_evaluation(scenario: PathScenario, trials: int, methods: Sequence[str]) -> None:
    """Refuse what `evaluate_paths` would refuse, before work starts.

    Raises:
        InputError: on an unknown method, a number below 1, or bad settings.
    """
    if trials < 1:
        raise InputError("--trials and --jobs: give numbers from 1")
    for method in methods:
        if method not in METHODS and method not in _LABELS:
            raise InputError(
                f"there is no method {method!r}; there are {', '.join(METHODS)}, and with a number of samples "
                f"{', '.join(_LABELS)}"
            )
        if method == ORACLE and scenario.no_oracle:
            raise InputError(f"{scenario.name} has no oracle: {scenario.no_oracle}; leave it out of --methods")
    check_settings(scenario)


def evaluate_paths(
    scenario: PathScenario,
    overrides: Sequence[str],
    trials: int,
    methods: Sequence[str] = (),
    workers: Workers | None = None,
    progress: Say | None = None,
    rows: RowFile | None = None,
) -> dict[str, Any]:
    """Evaluate a path scenario.

    Every seed has demonstrations, starts and noise of its own; within a seed all methods see the same. A seed that
    raises has rows with the reason.

    Args:
        scenario: with the first seed and the physics.
        overrides: its settings, for the worker processes.
        trials: number of seeds.
        methods: only these; default all. `default` is that method at every number of samples, `default@500` at one.
        workers: who works; by default this process. The result does not depend on it.
        progress: called with a line and the fraction done.
        rows: what was found before, and where rows are kept.

    Returns:
        `rows` (one a run) and `table` (mean and spread).

    Raises:
        InputError: on an unknown method or a number below 1.
        EvaluationInterrupted: on Ctrl-C, with the seeds that were finished.
        WorkerLostError: if processes were killed again and again, with the same.
    """
    check_evaluation(scenario, trials, methods)
    chosen, cases = tuple(methods or METHODS), tuple(choose_paths(scenario))
    work = [
        PathSeed(type(scenario), tuple(overrides), scenario.physics, scenario.seed + k, chosen, cases)
        for k in range(trials)
    ]
    rows, workers = rows or RowFile(), workers or Workers()

    def found() -> dict[str, Any]:
        flat = [row for seed in rows.of(i for job in work for i in job.ids) for row in seed]
        return {"rows": flat, "table": summarise(flat)}

    return evaluate_jobs(work, workers, rows, found, progress, _label)


def chosen_variants(methods: Collection[str]) -> list[PathVariant]:
    """The methods that learn and follow, by name, or by name and number of samples."""
    return [v for v in VARIANTS if v.method in methods or v.label in methods]


def _label(last: str, done: int, total: int) -> str:
    return f"{done} of {total} seeds"


@dataclass(frozen=True)
class PathSeed:
    """All methods on one seed, a job of the runner; its one finding is the list of their rows.

    Attributes:
        kind: the scenario's class; a worker process makes its own.
        overrides: its settings.
        physics: of the world.
        seed: of demonstrations, starts and noise.
        methods: as for `evaluate_paths`.
        cases: names of the paths.
    """

    kind: type[PathScenario]
    overrides: tuple[str, ...]
    physics: Physics
    seed: int
    methods: tuple[str, ...]
    cases: tuple[str, ...]

    @property
    def ids(self) -> tuple[str, ...]:
        """The seed."""
        return (f"seed {self.seed}",)

    @property
    def variants(self) -> list[PathVariant]:
        """The methods that learn and follow."""
        return chosen_variants(self.methods)

    def run(self, ids: Collection[str]) -> Iterator[tuple[str, list[dict[str, Any]]]]:
        """The seed's rows."""
        with threadpool_limits(limits=1):
            yield self.ids[0], self._rows()

    def failed(self, name: str, reason: str) -> list[dict[str, Any]]:
        """Rows without success, one for each path and method."""
        try:
            scenario = self.kind(self.overrides, self.physics, self.seed)
        except Exception:  # the reason may be this very thing
            return []
        what = [(v.method, v.samples) for v in self.variants]
        what += [(ORACLE, 0)] if ORACLE in self.methods and not scenario.no_oracle else []
        rows = [plain_row(method, n, scenario, case, reason) for method, n in what for case in self.cases]
        if FIRST_LINK in self.methods and isinstance(scenario, HasWantedStates):
            rows += _no_first_link_rows(scenario, reason)
        return rows

    def _rows(self) -> list[dict[str, Any]]:
        most = max([v.samples for v in self.variants if not v.monolithic], default=FULL)
        scenario = self.kind([*self.overrides, f"learning.samples={most}"], self.physics, self.seed)
        pieces = list(scenario.record_demonstrations()) if self.variants else []
        whole = [scenario.monolithic_demonstration(2 * FULL)] if any(v.monolithic for v in self.variants) else []
        rows: list[dict[str, Any]] = []
        for variant in self.variants:
            rows += _evaluate_variant(scenario, variant, whole if variant.monolithic else pieces)
        if ORACLE in self.methods and not scenario.no_oracle:
            for number, (name, path) in enumerate(choose_paths(scenario).items()):
                rows.append(path_row(ORACLE, 0, scenario, name, oracle_follow(scenario, name, path, number)))
        if FIRST_LINK in self.methods and isinstance(scenario, HasWantedStates):
            rows += _first_link_rows(scenario, pieces)
        return rows


def _first_link_rows(scenario: PathScenario, pieces: Sequence[Demonstration]) -> list[dict[str, Any]]:
    """One row for the end of a wanted state's first tick, one for the next; errors in the child's units."""
    graph = first_link_graph(scenario.graph, scenario.target)
    edge = graph.interactions[0]
    # The recording of later links is not waited for: pieces come one by one.
    shown = (p for p in (pieces or scenario.record_demonstrations()) if p.has(graph.root, graph.objects[graph.root]))
    first = [shorten(next(shown), FULL)]
    rows = []
    try:
        chain = learn_first_link(scenario, first, replace_samples(scenario.config.learning.candidates(), FULL))
        found = measure_first_link(scenario, chain)
    except IchainError as error:
        return _no_first_link_rows(scenario, str(error))
    for case, off, true_off in (
        ("moving", found.moving, found.true_moving),
        ("rest", found.rest, found.true_rest),
    ):
        reason = "" if found.held else f"{edge.name} was not active throughout"
        row = plain_row(FIRST_LINK, found.samples, scenario, f"link:{edge.name} {case}", reason)
        rows.append(row | {"success": found.held, "error": off, "true_error": true_off, "unit": _first_unit(graph)})
    return rows


def _no_first_link_rows(scenario: PathScenario, reason: str) -> list[dict[str, Any]]:
    graph = first_link_graph(scenario.graph, scenario.target)
    cases = [f"link:{graph.interactions[0].name} {case}" for case in ("moving", "rest")]
    return [plain_row(FIRST_LINK, FULL, scenario, case, reason) | {"unit": _first_unit(graph)} for case in cases]


def _first_unit(graph: InteractionGraph) -> str:
    child = graph.objects[graph.interactions[0].child].observable
    return ", ".join(dict.fromkeys(v.unit for v in child.variables))


def shorten(piece: Demonstration, samples: int) -> Demonstration:
    """The first transitions of a piece in which its interactions are active."""
    flags = [name for name in piece.table.columns if "->" in name]
    on = (piece.table[flags] > 0.5).all(axis=1).to_numpy()
    done = np.cumsum(on[:-1] & on[1:])
    rows = int(np.searchsorted(done, samples)) + 2
    return replace(piece, table=piece.table.iloc[:rows])


def _evaluate_variant(
    scenario: PathScenario, variant: PathVariant, pieces: Sequence[Demonstration]
) -> list[dict[str, Any]]:
    paths = choose_paths(scenario)
    try:
        chain, controller = learn_variant(scenario, variant, pieces)
    except IchainError as error:
        return [path_row(variant.method, variant.samples, scenario, name, None, str(error)) for name in paths]
    return [
        path_row(
            variant.method, variant.samples, scenario, name, follow(scenario, chain, controller, name, path, number)
        )
        for number, (name, path) in enumerate(paths.items())
    ]


def learn_variant(
    scenario: PathScenario, variant: PathVariant, pieces: Sequence[Demonstration]
) -> tuple[LearnedChain, ChainController]:
    """Learn and build the controller of one variant.

    Raises:
        IchainError: if it can't be learned, with the reason.
    """
    candidates = replace_samples(scenario.config.learning.candidates(), variant.samples)
    candidates = {k: replace(c, action=variant.action) for k, c in candidates.items()}  # type: ignore[arg-type]
    graph = scenario.graph
    if variant.monolithic:
        graph, candidates = monolithic(scenario, candidates)
    # Nothing of what lies beyond the samples is used: not for the command map, the limits or validation either.
    pieces = [shorten(piece, variant.samples) for piece in pieces]
    chain = learn_chain(pieces, graph, scenario.target, scenario.target_variables, candidates)
    control = scenario.config.control.candidates()
    return chain, make_controller(chain, variant.control, scenario.path_limits(), control)


def monolithic(
    scenario: PathScenario, candidates: Mapping[str, LinkCandidates]
) -> tuple[InteractionGraph, dict[str, LinkCandidates]]:
    """The graph that knows nothing between robot and target, with the last link's candidates."""
    names = scenario.graph.chain(scenario.target)
    objects = {n: scenario.graph.objects[n] for n in (names[0], names[-1])}
    last = candidates[f"{names[-2]}->{names[-1]}"]
    return InteractionGraph(objects, [(names[0], names[-1])]), {f"{names[0]}->{names[-1]}": last}


def path_row(
    method: str, samples: int, scenario: PathScenario, case: str, result: PathResult | None, reason: str = ""
) -> dict[str, Any]:
    """The row of a run, or of one that there is none of, with the reason."""
    if result is not None and not result.completed:
        reason = result.reason
    row = plain_row(method, samples, scenario, case, reason)
    if result is None or not result.completed:
        return row
    return row | {"success": True, "error": result.error, "paper_metric": result.paper_metric}


def plain_row(method: str, samples: int, scenario: PathScenario, case: str, reason: str) -> dict[str, Any]:
    """A row without success, of an error in the path's unit."""
    return {
        "method": method,
        "samples": samples,
        "physics": scenario.physics,
        "case": case,
        "seed": scenario.seed,
        "success": False,
        "error": None,
        "paper_metric": None,
        "unit": scenario.unit,
        "reason": reason,
    }
