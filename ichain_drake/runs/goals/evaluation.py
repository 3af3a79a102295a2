"""`evaluate` for goals over an interaction graph: faults, monitors, roles, number of pieces, and classifier figures."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any, cast

import numpy as np
from joblib import Parallel, delayed
from threadpoolctl import threadpool_limits

from ichain_drake.demonstrations import Demonstration
from ichain_drake.errors import IchainError, InputError
from ichain_drake.learning import InteractionSpec
from ichain_drake.robot import Physics
from ichain_drake.runs.goals.knowledge import Knowledge, learn_graph
from ichain_drake.runs.goals.settings import graph_spec
from ichain_drake.runs.goals.status_accuracy import (
    LEAST_EVENTS,
    count_events,
    held_out_scores,
    probe_scores,
)
from ichain_drake.runs.goals.trial import Trial, run_trial, summarise, without_roles
from ichain_drake.runs.paths.evaluation import EvaluationInterrupted
from ichain_drake.scenarios.base import Scenario
from ichain_drake.scenarios.goal_scenario import GoalScenario
from ichain_drake.scenarios.probes import HasProbes

CASES: dict[str, tuple[str, ...]] = {
    "none": (),
    "slip": ("fault.kind=slip",),
    "knock": ("fault.kind=knock",),
    "stiff": ("fault.kind=stiff",),
    "dropout": ("fault.kind=dropout",),
}
"""Settings of each fault. `noise` is the last case: `NOISE` times the configured noise of the world."""

NOISE = 3.0
PIECES = (6, 8, 10, 12, 14, 16)
"""Numbers of pieces to learn from, the first of one order; see `piece_order`."""

MONITORS, NO_MONITORS, NO_ROLES, NUMBER, CLASSIFIERS = "monitors", "no_monitors", "no_roles", "pieces", "classifiers"
METHODS: tuple[str, ...] = (MONITORS, NO_MONITORS, NO_ROLES, NUMBER, CLASSIFIERS)

MOST_TRIALS = 900
"""Runs of a seed that are not its demonstrations."""

_ORDER = 4  # purpose of random numbers
_HELD_OUT = (2, 8)  # seeds of held-out pieces: at least, at most
_PROBES = 200  # inside, and as many near misses
_ALL = "all"

Say = Callable[[str, float | None], None]


@dataclass(frozen=True)
class Variant:
    """What the trials of a table's line share.

    Attributes:
        method, case: names in the report.
        settings: of the world, beside the user's.
        monitors: whether the controller watches.
        learning: key of what was learned: `all`, `no_roles`, or a number of pieces.
    """

    method: str
    case: str
    settings: tuple[str, ...] = ()
    monitors: bool = True
    learning: str | int = _ALL


def choose_variants(methods: Sequence[str], scenario: GoalScenario, pieces: int) -> list[Variant]:
    """The lines of the table.

    Args:
        methods: as on the command line: `method` or `method/case`; empty for all.
        scenario: its faults are the cases; those that it lacks are left out.
        pieces: number that it has.

    Raises:
        InputError: on an unknown method or case.
    """
    noise = f"noise.scale={NOISE * scenario.config.noise.scale:g}"
    faults = getattr(scenario, "faults", ("none",))
    cases = {c: s for c, s in CASES.items() if c in faults} | {"noise": (noise,)}
    known = [Variant(m, c, s, m == MONITORS) for m in (MONITORS, NO_MONITORS) for c, s in cases.items()]
    known.append(Variant(NO_ROLES, "none", learning=NO_ROLES))
    numbers = [n for n in PIECES if n < pieces] + [pieces]
    known += [Variant(NUMBER, f"{n} pieces", learning=_ALL if n == pieces else n) for n in numbers]
    chosen: list[Variant] = []
    for text in methods or METHODS:
        method, slash, case = text.partition("/")
        if method not in METHODS:
            raise InputError(f"there is no method {method!r}; there are {', '.join(METHODS)}")
        found = [v for v in known if v.method == method and case in ("", v.case)]
        if slash and not found:
            has = ", ".join(v.case for v in known if v.method == method) or "none"
            raise InputError(f"method {method} has no case {case!r}; it has {has}")
        chosen += [v for v in found if v not in chosen]
    return chosen


def check_graph_evaluation(scenario: GoalScenario, trials: int, methods: Sequence[str], jobs: int) -> None:
    """Refuse what `evaluate_goals` would refuse, before work starts.

    Raises:
        InputError: on an unknown method or case, a number out of range, or a setting that is for paths.
    """
    graph_spec(scenario.config)
    if trials < 1 or jobs < 1:
        raise InputError("--trials and --jobs: give numbers from 1")
    if trials > MOST_TRIALS:
        raise InputError(f"--trials: at most {MOST_TRIALS} runs of one seed; choose another --seed for more")
    choose_variants(methods, scenario, PIECES[-1])


def evaluate_goals(
    scenario: GoalScenario,
    overrides: Sequence[str],
    goal: Sequence[str],
    trials: int,
    methods: Sequence[str] = (),
    jobs: int = 1,
    progress: Say | None = None,
) -> dict[str, Any]:
    """Evaluate a goal over an interaction graph.

    All trials share what was learned from the demonstrations of the scenario's seed; start, noise and mishaps are those
    of the run. Classifiers are scored on the pieces of the next seeds.

    Args:
        scenario: with the seed of the demonstrations, and the physics.
        overrides: its settings, for the worker processes.
        goal: as text.
        trials: runs of each line.
        methods: only these; `method` or `method/case`; default all.
        jobs: processes; the result does not depend on it.
        progress: called with a line and the fraction done.

    Returns:
        `rows` (one a run), `table` (one a line), `classifiers` (one an interaction), `skipped` (cases that this
        physics has not, with the reason) and `held_out` (seeds and number of pieces).

    Raises:
        InputError: as `check_graph_evaluation`, or on demonstrations that can't be learned from.
        EvaluationInterrupted: on Ctrl-C, with the trials that were finished.
    """
    check_graph_evaluation(scenario, trials, methods, jobs)
    say: Say = progress or (lambda line, fraction: None)
    found: dict[str, Any] = {"rows": [], "table": [], "classifiers": [], "skipped": {}, "held_out": {}}
    try:
        _evaluate(scenario, tuple(overrides), tuple(goal), trials, methods, jobs, say, found)
    except KeyboardInterrupt:
        found["table"] = summarise(found["rows"])
        raise EvaluationInterrupted(found) from None
    return found


def _evaluate(  # noqa: PLR0913 - what `evaluate_goals` was given
    scenario: GoalScenario,
    overrides: tuple[str, ...],
    goal: tuple[str, ...],
    trials: int,
    methods: Sequence[str],
    jobs: int,
    say: Say,
    found: dict[str, Any],
) -> None:
    kind = cast("type[Scenario]", type(scenario))
    pool = Parallel(n_jobs=jobs, return_as="generator")
    wants_scores = not methods or CLASSIFIERS in methods
    seeds = [scenario.seed + k for k in range(_HELD_OUT[0] + 1 if wants_scores else 1)]
    say(f"recording demonstrations of {len(seeds)} seed(s)", None)
    (pieces, *held_out) = _run(pool, (delayed(_record)(kind, overrides, scenario.physics, s) for s in seeds))

    variants = possible_variants(choose_variants(methods, scenario, len(pieces)), scenario, overrides, found["skipped"])
    needed = list(dict.fromkeys([*(v.learning for v in variants), *([_ALL] if wants_scores else [])]))
    say(f"learning from {len(pieces)} pieces, {len(needed)} time(s)", None)
    shown = piece_order(pieces, scenario.seed)
    spec = graph_spec(scenario.config)
    work = (delayed(_learn)(scenario.graph, shown[:k] if isinstance(k, int) else pieces, k, spec) for k in needed)
    learned = dict(zip(needed, _run(pool, work), strict=True))
    if isinstance(learned.get(_ALL), str):
        raise InputError(str(learned[_ALL]))

    if wants_scores:
        while len(held_out) < _HELD_OUT[1] and _fewest(held_out, scenario) < LEAST_EVENTS:
            say(f"recording held-out pieces, seed {scenario.seed + len(held_out) + 1}", None)
            held_out.append(_record(kind, overrides, scenario.physics, scenario.seed + len(held_out) + 1))
        say("scoring classifiers", None)
        known = cast("Knowledge", learned[_ALL])
        flat = [p for group in held_out for p in group]
        found["classifiers"] = score_classifiers(scenario, known, flat)
        found["held_out"] = {
            "seeds": [scenario.seed + 1 + k for k in range(len(held_out))],
            "pieces": len(flat),
            "from_pieces": len(pieces),
        }

    tasks = [
        (_trial(v, number, kind, overrides, scenario, goal, len(pieces)), learned[v.learning])
        for v in variants
        for number in range(trials)
    ]
    for done, row in enumerate(pool(delayed(run_trial)(*task) for task in tasks), start=1):
        found["rows"].append(row)
        if done % trials == 0:
            say(f"{row['method']}, {row['case']}: done", done / len(tasks))
    found["table"] = summarise(found["rows"])


def score_classifiers(
    scenario: GoalScenario, knowledge: Knowledge, held_out: Sequence[Demonstration]
) -> list[dict[str, Any]]:
    """One line per interaction; see `held_out_scores` and `probe_scores`.

    Args:
        scenario: knows true regions if it is a `HasProbes`.
        knowledge: what was learned.
        held_out: pieces that it was not learned from.
    """
    model = knowledge.model
    with threadpool_limits(limits=1):
        scores = held_out_scores(model, held_out)
        lines = []
        for edge in scenario.graph.interactions:
            probes = scenario.probes(edge, held_out, _PROBES) if isinstance(scenario, HasProbes) else None
            lines.append({"interaction": edge.name, **scores[edge], **probe_scores(model, edge, probes)})
        return lines


def _trial(
    variant: Variant,
    number: int,
    kind: type[Scenario],
    overrides: tuple[str, ...],
    scenario: GoalScenario,
    goal: tuple[str, ...],
    pieces: int,
) -> Trial:
    shown = variant.learning if isinstance(variant.learning, int) else pieces
    settings = (*overrides, *variant.settings)
    return Trial(
        variant.method, variant.case, kind, settings, scenario.physics, scenario.seed, number, goal, variant.monitors,
        shown,
    )  # fmt: skip


def possible_variants(
    variants: Sequence[Variant], scenario: GoalScenario, overrides: tuple[str, ...], skipped: dict[str, str]
) -> list[Variant]:
    """Without the cases that the scenario refuses in this physics.

    Args:
        variants: all lines.
        scenario: with the physics.
        overrides: its settings.
        skipped: is given the refused cases with their reasons.
    """
    kind, out = cast("type[Scenario]", type(scenario)), []
    for variant in variants:
        try:
            kind((*overrides, *variant.settings), scenario.physics, scenario.seed)
        except InputError as error:
            skipped[variant.case] = str(error)
        else:
            out.append(variant)
    return out


def _record(kind: type[Scenario], overrides: tuple[str, ...], physics: Physics, seed: int) -> list[Demonstration]:
    with threadpool_limits(limits=1):
        return list(kind(overrides, physics, seed).record_demonstrations())


def _learn(graph: Any, pieces: Sequence[Demonstration], key: str | int, spec: InteractionSpec) -> Knowledge | str:
    """Models, or why there are none: too few pieces are a finding, no mistake of the user's."""
    try:
        return learn_graph(pieces, without_roles(graph) if key == NO_ROLES else graph, spec)
    except IchainError as error:
        return " ".join(str(error).split())


def piece_order(pieces: Sequence[Demonstration], seed: int) -> list[Demonstration]:
    """The pieces shuffled, but first those that show an interaction which no piece before them shows.

    So the first few are what a person would show who has time for no more, and the rest adds experience.
    """
    shuffled = [pieces[i] for i in np.random.default_rng([seed, _ORDER]).permutation(len(pieces))]
    first, seen = [], set[str]()
    for piece in shuffled:
        shown = {c for c in piece.table.columns if "->" in c and (piece.table[c] > 0.5).any()}  # noqa: PLR2004 - a flag
        if shown - seen:
            first.append(piece)
            seen |= shown
    return [*first, *(p for p in shuffled if not any(p is q for q in first))]


def _fewest(held_out: Sequence[Sequence[Demonstration]], scenario: GoalScenario) -> int:
    """Switching events of the interaction that has the fewest."""
    flat = [p for group in held_out for p in group]
    return min(count_events(flat, e) for e in scenario.graph.interactions)


def _run(pool: Parallel, work: Iterable[Any]) -> list[Any]:
    return list(pool(work))
