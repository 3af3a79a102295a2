"""How well labels, edges and cuts are found out of states: against true flags, graph and pieces, fresh each trial.

Only an evaluator looks at true flags.
"""

from __future__ import annotations

import time
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

from threadpoolctl import threadpool_limits

from ichain_drake.demonstrations import Demonstration
from ichain_drake.errors import InputError
from ichain_drake.graph import InteractionGraph
from ichain_drake.learning.discovery.cuts import cut_pieces
from ichain_drake.learning.discovery.edges import discover_graph
from ichain_drake.learning.discovery.labels import raw_piece
from ichain_drake.learning.discovery.search import search
from ichain_drake.robot import Physics
from ichain_drake.runs.baselines import BASELINES, PCMCI, RUPTURES, check_baselines, pcmci_edges, ruptures_cuts
from ichain_drake.runs.clusters.workers import Say, Workers
from ichain_drake.runs.discovery_scores import Row, cut_scores, edge_scores, one_recording_each, scores, summary
from ichain_drake.runs.distractors import SPACES as DISTRACTORS
from ichain_drake.runs.distractors import distracted
from ichain_drake.runs.goals.run import GraphRun, own_goal, run_graph
from ichain_drake.runs.goals.unlabelled import Taught
from ichain_drake.runs.learn import learn
from ichain_drake.runs.row_file import RowFile
from ichain_drake.runs.runner import evaluate_jobs
from ichain_drake.scenarios.base import Scenario
from ichain_drake.scenarios.graph_scenario import GraphScenario

LABELS, EDGES, CUTS, DISTRACTED, TASK = "labels", "edges", "cuts", "edges@distractors", "task"
METHODS = (LABELS, EDGES, CUTS, DISTRACTED, TASK, *BASELINES)


@dataclass(frozen=True)
class DiscoveryTrial:
    """Demonstrations of one seed, and what is found of their flags and edges from states alone.

    Attributes:
        kind: the scenario's class; a worker process makes its own.
        overrides: its settings.
        physics: of the world.
        seed: of the demonstrations.
        methods: `labels` (the graph is given), `edges` (it isn't; `@distractors` among objects that act on nothing),
            `cuts` (all pieces in one recording), `task` (the goal, from states alone and from true flags), and others.
    """

    kind: type[Scenario]
    overrides: tuple[str, ...]
    physics: Physics
    seed: int
    methods: tuple[str, ...]

    @property
    def ids(self) -> tuple[str, ...]:
        """Method and seed."""
        return tuple(f"{m}/{self.seed}" for m in self.methods)

    def run(self, ids: Collection[str]) -> Iterator[tuple[str, Row]]:
        """A row a method; `seconds` are of processor time."""
        scenario = self.kind(self.overrides, self.physics, self.seed)
        with threadpool_limits(limits=1):
            pieces = list(scenario.record_demonstrations())
            for name, method in zip(self.ids, self.methods, strict=True):
                if name in ids:
                    began = time.process_time()
                    if method == TASK:
                        figures = _task(pieces, scenario)
                    else:
                        figures = _figures(pieces, scenario.graph, method, self.seed)
                    seconds = round(time.process_time() - began, 1)
                    yield name, self._row(method) | figures | {"seconds": seconds}

    def _row(self, method: str) -> Row:
        return {"method": method, "seed": self.seed, "reason": ""}

    def failed(self, name: str, reason: str) -> Row:
        """The row of a trial that raised."""
        return self._row(self.methods[self.ids.index(name)]) | {"reason": reason}


def _figures(pieces: Sequence[Demonstration], graph: InteractionGraph, method: str, seed: int) -> Row:
    if method in (CUTS, RUPTURES):
        logs, resets = one_recording_each(pieces)
        if method == RUPTURES:
            return cut_scores([ruptures_cuts(log, graph) for log in logs], resets)
        cuts = cut_pieces(logs, graph).cuts
        return cut_scores([[c.row for c in cuts if c.log == log.name] for log in logs], resets)
    if method == PCMCI:
        return edge_scores(pcmci_edges(pieces, graph), graph)
    if method == DISTRACTED:
        raw, spaces = distracted(pieces, graph, seed)
    else:
        raw, spaces = [raw_piece(p, graph) for p in pieces], {n: s.observable for n, s in graph.objects.items()}
    if method == LABELS:
        return scores(search(raw, spaces, graph.only_root("inferring flags"), graph.interactions), pieces, graph)
    found = discover_graph(raw, spaces, graph.only_root("finding edges")).found
    if method == EDGES:
        return scores(found, pieces, graph)
    # What acts on a distractor (on the follower the robot does) is no mistake.
    about = [f for f in found if f.edge.child not in DISTRACTORS or f.edge.parent in DISTRACTORS]
    rivals = [f"{f.edge.name} or {r.parent}" for f in about for r in f.rivals]
    return scores(about, pieces, graph) | {"rivals": rivals}


def _task(pieces: Sequence[Demonstration], scenario: Any) -> Row:
    """What `run --unlabelled --no-graph` makes of a seed, and the same run from true flags and graph."""
    goal = own_goal(scenario)
    alone = GraphRun(scenario, goal, taught=Taught(unlabelled=True, no_graph=True))
    try:
        run_graph(alone)
        why = "" if alone.goal_reached else alone.reason
    except InputError as error:  # from what was found nothing can be learned
        why = str(error)
    told = GraphRun(scenario, goal)
    run_graph(told, known=learn(scenario, pieces))
    found = () if alone.labels is None else alone.labels.found
    figures = scores(found, pieces, scenario.graph)
    return figures | {"reached": not why, "why": why, "reached_with_flags": told.goal_reached}


@dataclass(frozen=True)
class DiscoveryEvaluation:
    """What is evaluated.

    Attributes:
        scenario: with the first seed and the physics.
        overrides: its settings, for worker processes.
        trials: number of seeds.
        methods: see `DiscoveryTrial`.
        workers: who works.
    """

    scenario: Scenario
    overrides: tuple[str, ...]
    trials: int
    methods: tuple[str, ...] = field(default=(LABELS, EDGES, CUTS))
    workers: Workers = Workers()

    def check(self) -> None:
        """Refuse what can't be evaluated.

        Raises:
            InputError: on other methods beside these, one that isn't for the system, or no trial.
        """
        other = [m for m in self.methods if m not in METHODS]
        if other:
            raise InputError(f"{other[0]} can't be evaluated beside {', '.join(METHODS)}; ask for it by itself")
        check_baselines(self.methods)
        if TASK in self.methods and not isinstance(self.scenario, GraphScenario):
            raise InputError(f"{self.scenario.name} follows paths: {TASK} is for systems with a goal")
        if self.trials < 1:
            raise InputError("--trials and --jobs: give numbers from 1")


def evaluate_discovery(what: DiscoveryEvaluation, say: Say, rows: RowFile) -> dict[str, Any]:
    """Evaluate; see `DiscoveryEvaluation`.

    Returns:
        `rows` (one a method and seed) and `table` (one a method).

    Raises:
        InputError: as `DiscoveryEvaluation.check`.
        EvaluationInterrupted: on Ctrl-C, with what was finished.
        WorkerLostError: if a process was killed.
    """
    what.check()
    first = what.scenario.seed
    trials = [
        DiscoveryTrial(type(what.scenario), what.overrides, what.scenario.physics, seed, what.methods)
        for seed in range(first, first + what.trials)
    ]

    def found() -> dict[str, Any]:
        flat = rows.of(f"{m}/{t.seed}" for m in what.methods for t in trials)
        return {"rows": flat, "table": [summary(m, [r for r in flat if r["method"] == m]) for m in what.methods]}

    return evaluate_jobs(trials, what.workers, rows, found, say)
