"""`evaluate` for goals over an interaction graph: faults, monitors, roles, number of pieces, and classifier figures."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, cast

from joblib import delayed
from threadpoolctl import threadpool_limits

from ichain_drake.demonstrations import Demonstration
from ichain_drake.errors import InputError, WorkerLostError
from ichain_drake.learning import InteractionModel
from ichain_drake.runs.clusters.backend import Backend, opened
from ichain_drake.runs.clusters.workers import Say, Workers
from ichain_drake.runs.goals.fresh import FreshSeed, SharedTrial, join, record_pieces, try_to_learn
from ichain_drake.runs.goals.settings import graph_spec
from ichain_drake.runs.goals.status_accuracy import (
    LEAST_EVENTS,
    count_events,
    held_out_scores,
    probe_scores,
)
from ichain_drake.runs.goals.trial import Trial, summarise
from ichain_drake.runs.goals.variants import (
    ALL_PIECES,
    CLASSIFIERS,
    NUMBER,
    PIECES,
    GoalVariant,
    choose_variants,
    piece_order,
    possible_variants,
)
from ichain_drake.runs.row_file import RowFile
from ichain_drake.runs.runner import EvaluationInterrupted, run_all, run_jobs
from ichain_drake.scenarios.base import Scenario
from ichain_drake.scenarios.goal_scenario import GoalScenario
from ichain_drake.scenarios.probes import HasProbes

MOST_TRIALS = 900
"""Runs of a seed that are not its demonstrations."""

_HELD_OUT = (2, 8)  # seeds of held-out pieces: at least, at most
_PROBES = 200  # inside, and as many near misses


def check_graph_evaluation(scenario: GoalScenario, trials: int, methods: Sequence[str]) -> None:
    """Refuse what `evaluate_goals` would refuse, before work starts.

    Raises:
        InputError: on an unknown method or case, a number out of range, or a setting that is for paths.
    """
    graph_spec(scenario.config)
    if trials < 1:
        raise InputError("--trials and --jobs: give numbers from 1")
    if trials > MOST_TRIALS:
        raise InputError(f"--trials: at most {MOST_TRIALS} runs of one seed; choose another --seed for more")
    choose_variants(methods, scenario, PIECES[-1])


@dataclass(frozen=True)
class GoalEvaluation:
    """What is evaluated.

    Attributes:
        scenario: with the (first) seed of the demonstrations, and the physics.
        overrides: its settings, for the worker processes.
        goal: as text.
        trials: runs of each line.
        methods: only these; `method` or `method/case`; empty for all.
        workers: who works; the result does not depend on it.
        shared: runs that all have the demonstrations of the scenario's seed; starts, noise and faults are their own.
        fresh: runs with demonstrations of their own: of the scenario's seed and those that follow.
    """

    scenario: GoalScenario
    overrides: tuple[str, ...]
    goal: tuple[str, ...]
    trials: int
    methods: tuple[str, ...] = ()
    workers: Workers = Workers()
    shared: bool = True
    fresh: bool = False

    @property
    def kind(self) -> type[Scenario]:
        """The scenario's class."""
        return cast("type[Scenario]", type(self.scenario))

    @property
    def wants_scores(self) -> bool:
        """Whether classifiers are scored."""
        return not self.methods or CLASSIFIERS in self.methods

    @property
    def needs_shared(self) -> bool:
        """Whether the demonstrations of the scenario's seed are needed beforehand."""
        return self.shared or self.wants_scores or any(m.partition("/")[0] == NUMBER for m in self.methods)


def evaluate_goals(what: GoalEvaluation, progress: Say | None = None, rows: RowFile | None = None) -> dict[str, Any]:
    """Evaluate a goal over an interaction graph.

    Classifiers are learned from the demonstrations of the scenario's seed and scored on the pieces of the next ones. A
    trial that raises has a row with the reason.

    Args:
        what: see there.
        progress: called with a line and the fraction done.
        rows: what was found before, and where rows are kept.

    Returns:
        `rows` (one a run), `table` (one a line), `classifiers` (one an interaction), `skipped` (cases that this
        physics has not, with the reason) and `held_out` (seeds and number of pieces).

    Raises:
        InputError: as `check_graph_evaluation`, or on shared demonstrations that can't be learned from.
        EvaluationInterrupted: on Ctrl-C, with the trials that were finished.
        WorkerLostError: if processes were killed again and again, with the same.
    """
    check_graph_evaluation(what.scenario, what.trials, what.methods)
    say: Say = progress or (lambda line, fraction: None)
    rows = rows or RowFile()
    found: dict[str, Any] = {"rows": [], "table": [], "classifiers": [], "skipped": {}, "held_out": {}}
    work: list[FreshSeed | SharedTrial] = []
    try:
        with opened(what.workers, say) as backend:
            work += _prepare(what, backend, say, found)
            run_jobs(join(work, what.workers), backend, rows, say, timeout=what.workers.trial_timeout)
    except WorkerLostError as lost:
        lost.found = found
        raise
    except KeyboardInterrupt:
        raise EvaluationInterrupted(found) from None
    finally:
        found["rows"] = rows.of(sorted((i for job in work for i in job.ids), key=_order(work)))
        found["table"] = summarise(found["rows"])
    return found


def _order(work: Sequence[FreshSeed | SharedTrial]) -> Callable[[str], tuple[int, int]]:
    """Rows of one line stand together, in the order of their seeds, whichever way they were grouped into jobs."""
    lines: dict[str, int] = {}
    place = {i: (lines.setdefault(i.rpartition("/")[0] + str(type(job)), len(lines)), k)
             for k, job in enumerate(work) for i in job.ids}  # fmt: skip
    return place.__getitem__


def _prepare(what: GoalEvaluation, backend: Backend, say: Say, found: dict[str, Any]) -> list[FreshSeed | SharedTrial]:
    """Record and learn what trials share, score classifiers, and lay the trials out."""
    scenario, kind, overrides = what.scenario, what.kind, what.overrides
    pieces: list[Demonstration] = []
    held_out: list[list[Demonstration]] = []
    if what.needs_shared:
        seeds = [scenario.seed + k for k in range(_HELD_OUT[0] + 1 if what.wants_scores else 1)]
        say(f"recording demonstrations of {len(seeds)} seed(s)", None)
        record = (delayed(record_pieces)(kind, overrides, scenario.physics, s) for s in seeds)
        (pieces, *held_out) = run_all(record, backend, "recording demonstrations")

    variants = possible_variants(
        choose_variants(what.methods, scenario, len(pieces)), scenario, overrides, found["skipped"]
    )
    work: list[FreshSeed | SharedTrial] = []
    if what.fresh:
        seeds = [scenario.seed + k for k in range(what.trials)]
        work += [FreshSeed(kind, overrides, scenario.physics, s, what.goal, tuple(variants)) for s in seeds if variants]
    if not (what.shared or what.wants_scores):
        return work

    needed = list(dict.fromkeys([*(v.learning for v in variants if what.shared), *([ALL_PIECES] * what.wants_scores)]))
    say(f"learning from {len(pieces)} pieces, {len(needed)} time(s)", None)
    shown, spec = piece_order(pieces, scenario.seed), graph_spec(scenario.config)
    learn = (
        delayed(try_to_learn)(scenario.graph, shown[:k] if isinstance(k, int) else pieces, k, spec) for k in needed
    )
    learned = dict(zip(needed, run_all(learn, backend, "learning"), strict=True))
    if isinstance(learned.get(ALL_PIECES), str):
        raise InputError(str(learned[ALL_PIECES]))
    if what.wants_scores:
        _score(what, pieces, held_out, cast("InteractionModel", learned[ALL_PIECES]), say, found)
    if what.shared:
        for v in variants:
            for number in range(what.trials):
                trial = _trial(v, number, what, len(pieces))
                work.append(SharedTrial(trial, learned[v.learning]))
    return work


def _score(
    what: GoalEvaluation,
    pieces: Sequence[Demonstration],
    held_out: list[list[Demonstration]],
    known: InteractionModel,
    say: Say,
    found: dict[str, Any],
) -> None:
    """Figures of classifiers, on as many held-out pieces as it takes to see them switch often enough."""
    scenario = what.scenario
    while len(held_out) < _HELD_OUT[1] and _fewest(held_out, scenario) < LEAST_EVENTS:
        seed = scenario.seed + len(held_out) + 1
        say(f"recording held-out pieces, seed {seed}", None)
        held_out.append(record_pieces(what.kind, what.overrides, scenario.physics, seed))
    say("scoring classifiers", None)
    flat = [p for group in held_out for p in group]
    found["classifiers"] = score_classifiers(scenario, known, flat)
    found["held_out"] = {
        "seeds": [scenario.seed + 1 + k for k in range(len(held_out))],
        "pieces": len(flat),
        "from_pieces": len(pieces),
    }


def score_classifiers(
    scenario: GoalScenario, model: InteractionModel, held_out: Sequence[Demonstration]
) -> list[dict[str, Any]]:
    """One line per interaction; see `held_out_scores` and `probe_scores`.

    Args:
        scenario: knows true regions if it is a `HasProbes`.
        model: what was learned.
        held_out: pieces that it was not learned from.
    """
    with threadpool_limits(limits=1):
        scores = held_out_scores(model, held_out)
        lines = []
        for edge in scenario.graph.interactions:
            probes = scenario.probes(edge, held_out, _PROBES) if isinstance(scenario, HasProbes) else None
            lines.append({"interaction": edge.name, **scores[edge], **probe_scores(model, edge, probes)})
        return lines


def _trial(variant: GoalVariant, number: int, what: GoalEvaluation, pieces: int) -> Trial:
    shown = variant.learning if isinstance(variant.learning, int) else pieces
    settings, scenario = (*what.overrides, *variant.settings), what.scenario
    return Trial(
        variant.method, variant.case, what.kind, settings, scenario.physics, scenario.seed, number, what.goal,
        variant.monitors, shown,
    )  # fmt: skip


def _fewest(held_out: Sequence[Sequence[Demonstration]], scenario: GoalScenario) -> int:
    """Switching events of the interaction that has the fewest."""
    flat = [p for group in held_out for p in group]
    return min(count_events(flat, e) for e in scenario.graph.interactions)
