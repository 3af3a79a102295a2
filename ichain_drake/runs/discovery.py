"""How well labels, edges and cuts are found out of states: against true flags, graph and pieces, fresh each trial.

Only an evaluator looks at true flags.
"""

from __future__ import annotations

import time
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pandas as pd
from threadpoolctl import threadpool_limits

from ichain_drake.demonstrations import Demonstration
from ichain_drake.demonstrations.columns import TIME
from ichain_drake.errors import InputError
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning.discovery.cuts import cut_pieces
from ichain_drake.learning.discovery.edges import discover_graph
from ichain_drake.learning.discovery.labels import raw_piece
from ichain_drake.learning.discovery.search import FoundEdge, search
from ichain_drake.learning.status.scores import event_f1, f1
from ichain_drake.robot import Physics
from ichain_drake.runs.clusters.workers import Say, Workers
from ichain_drake.runs.row_file import RowFile
from ichain_drake.runs.runner import evaluate_jobs
from ichain_drake.scenarios.base import Scenario
from ichain_drake.state import BoolArray
from ichain_drake.timing import TICK

LABELS, EDGES, CUTS = "labels", "edges", "cuts"
METHODS = (LABELS, EDGES, CUTS)
_KEYS = ("all", "shown", "switchings")

Row = dict[str, Any]


@dataclass(frozen=True)
class DiscoveryTrial:
    """Demonstrations of one seed, and what is found of their flags and edges from states alone.

    Attributes:
        kind: the scenario's class; a worker process makes its own.
        overrides: its settings.
        physics: of the world.
        seed: of the demonstrations.
        methods: `labels` (the graph is given), `edges` (it isn't), `cuts` (of all pieces in one recording).
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
                    figures = _figures(pieces, scenario.graph, method)
                    seconds = round(time.process_time() - began, 1)
                    yield name, self._row(method) | figures | {"seconds": seconds}

    def _row(self, method: str) -> Row:
        return {"method": method, "seed": self.seed, "reason": ""}

    def failed(self, name: str, reason: str) -> Row:
        """The row of a trial that raised."""
        return self._row(self.methods[self.ids.index(name)]) | {"reason": reason}


def _figures(pieces: Sequence[Demonstration], graph: InteractionGraph, method: str) -> Row:
    if method == CUTS:
        return cut_scores(pieces, graph)
    raw = [raw_piece(p, graph) for p in pieces]
    spaces = {n: s.observable for n, s in graph.objects.items()}
    if method == EDGES:
        return scores(discover_graph(raw, spaces, graph.root).found, pieces, graph)
    return scores(search(raw, spaces, graph.root, graph.interactions), pieces, graph)


def cut_scores(pieces: Sequence[Demonstration], graph: InteractionGraph) -> Row:
    """Figures of the cuts in all pieces joined, those that hold the same columns in one recording each.

    Returns:
        As `scores`: `true` (how many resets there are), `missing` and `extra` (`recording/row`), `shd` (both together).
    """
    alike: dict[tuple[str, ...], list[Demonstration]] = {}
    for piece in pieces:
        alike.setdefault(tuple(sorted(map(str, piece.table.columns))), []).append(piece)
    logs = [joined(parts, f"recording{k}") for k, parts in enumerate(alike.values())]
    true = {
        f"{log.name}/{row}"
        for log, parts in zip(logs, alike.values(), strict=True)
        for row in np.cumsum([len(p) for p in parts])[:-1]
    }
    got = {f"{c.log}/{c.row}" for c in cut_pieces(logs, graph).cuts}
    missing, extra = sorted(true - got), sorted(got - true)
    return {"true": len(true), "missing": missing, "extra": extra, "shd": len(missing) + len(extra), "flags": {}}


def joined(pieces: Sequence[Demonstration], name: str) -> Demonstration:
    """One recording without a mark between its pieces: states alone, its clock going on."""
    table = pd.concat([p.table[[c for c in p.table.columns if "->" not in str(c)]] for p in pieces], ignore_index=True)
    return Demonstration(table.assign(**{TIME: TICK * np.arange(len(table))}), pieces[0].units, name)


def scores(found: Sequence[FoundEdge], pieces: Sequence[Demonstration], graph: InteractionGraph) -> Row:
    """Figures of what was found.

    Returns:
        `true` (how many there are), `missing`, `extra` and `shd` (structural Hamming distance: both together, a turned
        edge once), and `flags`: per true edge that was found F1 on all rows, on rows in which its effect shows, and of
        its switchings within one row; of those that were not found 0.
    """
    true, got = set(graph.interactions), {f.edge for f in found}
    missing, extra = true - got, got - true
    turned = sum(Interaction(e.child, e.parent) in extra for e in missing)
    by_edge = {f.edge: f for f in found}
    return {
        "true": len(true),
        "missing": sorted(e.name for e in missing),
        "extra": sorted(e.name for e in extra),
        "shd": len(missing) + len(extra) - turned,
        "flags": {e.name: _flag_scores(by_edge.get(e), pieces, e) for e in graph.interactions},
    }


def _flag_scores(found: FoundEdge | None, pieces: Sequence[Demonstration], edge: Interaction) -> dict[str, float]:
    if found is None:
        return {"all": 0.0, "shown": 0.0, "switchings": 0.0}
    truths: list[BoolArray] = []
    told: list[BoolArray] = []
    shown: list[BoolArray] = []
    for piece in pieces:
        if edge.name in piece.table and piece.name in found.on:
            truths.append(np.asarray(piece.table[edge.name].to_numpy(dtype=float) > 0.5))  # noqa: PLR2004 - a flag
            told.append(found.on[piece.name])
            shown.append(~found.open[piece.name])
    if not truths:  # flagged in no piece: a permanent coupling
        return {"all": 1.0, "shown": 1.0, "switchings": 1.0}
    truth, on, sure = (np.concatenate(parts) for parts in (truths, told, shown))
    return {
        "all": round(f1(truth, on), 4),
        "shown": round(f1(truth[sure], on[sure]), 4),
        "switchings": round(event_f1(truths, told), 4),
    }


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
    methods: tuple[str, ...] = field(default=METHODS)
    workers: Workers = Workers()

    def check(self) -> None:
        """Refuse what can't be evaluated.

        Raises:
            InputError: on other methods beside these, or no trial.
        """
        other = [m for m in self.methods if m not in METHODS]
        if other:
            raise InputError(f"{other[0]} can't be evaluated beside {', '.join(METHODS)}; ask for it by itself")
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


def summary(method: str, rows: Sequence[Mapping[str, Any]]) -> Row:
    """One line of the table: sums over seeds, and the lowest and mean F1 of flags."""
    done = [r for r in rows if not r["reason"]]
    every = [f for r in done for f in r["flags"].values()]
    edges = sum(r["true"] for r in done)
    missing, extra = (sum(len(r[key]) for r in done) for key in ("missing", "extra"))
    got = edges - missing
    return {
        "method": method,
        "seeds": len(rows),
        "failed": len(rows) - len(done),
        "recall": got / edges if edges else None,
        "precision": got / (got + extra) if got + extra else None,
        "mean_shd": float(np.mean([r["shd"] for r in done])) if done else None,
        "exact": sum(r["shd"] == 0 for r in done),
        **{f"f1_{key}": float(np.mean([f[key] for f in every])) if every else None for key in _KEYS},
        "seconds": float(np.mean([r["seconds"] for r in done])) if done else None,
    }
