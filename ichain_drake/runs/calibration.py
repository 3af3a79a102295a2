"""How honest what was learned is about itself: P(active) and predictive intervals on demonstrations of other seeds."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from ichain_drake.demonstrations import Demonstration
from ichain_drake.errors import InputError
from ichain_drake.learning import InteractionModel
from ichain_drake.learning.calibration import normal_factor, reliability
from ichain_drake.learning.data import collect
from ichain_drake.learning.intervals import conformal_intervals
from ichain_drake.learning.residuals import tick_scores
from ichain_drake.learning.status.candidates import states_around
from ichain_drake.robot import Physics
from ichain_drake.runs.clusters.workers import Say, Workers
from ichain_drake.runs.learn import learn
from ichain_drake.runs.row_file import RowFile
from ichain_drake.runs.runner import evaluate_jobs
from ichain_drake.scenarios.base import Scenario

Row = dict[str, Any]

CALIBRATION = "calibration"
"""The method's name."""

LEVELS = (0.5, 0.9)
"""Shares that predictive intervals are to cover."""

HELD_OUT, SET_ASIDE = 500, 1000
"""How far from a seed the ones are whose demonstrations predictions are compared with, and scale intervals by."""


@dataclass(frozen=True)
class CalibrationTrial:
    """One seed: learned from its demonstrations, judged on those of another, intervals scaled by those of a third.

    Attributes:
        kind: the scenario's class; a worker process makes its own.
        overrides: its settings.
        physics: of the world.
        seed: of the demonstrations that are learned from.
    """

    kind: type[Scenario]
    overrides: tuple[str, ...]
    physics: Physics
    seed: int

    @property
    def ids(self) -> tuple[str, ...]:
        """Method and seed."""
        return (f"{CALIBRATION}/{self.seed}",)

    def run(self, ids: Collection[str]) -> Iterator[tuple[str, Row]]:
        """The row."""
        with threadpool_limits(limits=1):
            shown, held_out, aside = (self._pieces(self.seed + more) for more in (0, HELD_OUT, SET_ASIDE))
            model = learn(self.kind(self.overrides, self.physics, self.seed), shown)
            yield self.ids[0], self._row() | figures(model, held_out, aside)

    def _pieces(self, seed: int) -> list[Demonstration]:
        return list(self.kind(self.overrides, self.physics, seed).record_demonstrations())

    def _row(self) -> Row:
        return {"method": CALIBRATION, "seed": self.seed, "reason": ""}

    def failed(self, name: str, reason: str) -> Row:
        """The row of a trial that raised."""
        return self._row() | {"statuses": {}, "intervals": {}, "reason": reason}


def figures(model: InteractionModel, held_out: Sequence[Demonstration], aside: Sequence[Demonstration]) -> Row:
    """Figures of one model.

    Args:
        model: what was learned.
        held_out: pieces to judge it by.
        aside: further pieces, to scale intervals by.

    Returns:
        `statuses` per interaction (none of a chain, whose interactions always act) and `intervals` per variable.

    Raises:
        InputError: if pieces can't be read as the graph's, or the model was learned from those that were set aside.
    """
    return {
        "statuses": {} if model.chain is not None else status_figures(model, held_out),
        "intervals": interval_figures(model, held_out, aside),
    }


def status_figures(model: InteractionModel, pieces: Sequence[Demonstration]) -> dict[str, Row]:
    """How well P(active) is calibrated, per interaction, given the status of the row before.

    Returns:
        `rows`, `active`, the expected calibration `error`, `brier`, the error `alone` without knowing what was before,
        the error `left_out` that learning found on rows that it left out, and `bins`: `rows`, sum of the probabilities
        `predicted`, and rows that were active, `happened`.
    """
    data = collect(pieces, model.graph, model.graph.interactions)
    piece = data.piece_index()
    found = {}
    for edge in model.graph.interactions:
        status, truth, states = model.edges[edge].status, data.flag(edge), states_around(data, edge)
        before = np.concatenate([[False], truth[:-1] & (piece[1:] == piece[:-1])])
        given = reliability(status.probability(states, before), truth)
        found[edge.name] = {
            "rows": len(truth),
            "active": int(truth.sum()),
            "error": given.error,
            "brier": given.brier,
            "alone": reliability(status.probability(states), truth).error,
            "left_out": float(status.calibration_error),
            "bins": {k: getattr(given, k).tolist() for k in ("rows", "predicted", "happened")},
        }
    return found


def interval_figures(
    model: InteractionModel, held_out: Sequence[Demonstration], aside: Sequence[Demonstration]
) -> dict[str, Row]:
    """How many readings predictive intervals of one tick cover, per `object.variable`.

    Returns:
        `rows` and `acting` (those in which an effect acts on the variable), and of both how many are within the
        intervals of each of `LEVELS`: as made of the spread, `covered` and `covered_acting`, and scaled by the pieces
        that were set aside, `scaled` and `scaled_acting`. `open`: rows that these show too little of for the last.
    """
    intervals, found = conformal_intervals(model, aside), dict[str, Row]()
    for part, scores in tick_scores(model, held_out).items():
        name = f"{part.child}.{model.graph.objects[part.child].observable.names[part.variable]}"
        row = found.setdefault(name, {"rows": 0, "acting": 0, "open": 0, **{k: [0] * len(LEVELS) for k in _COUNTS}})
        row["rows"] += len(scores.sizes)
        row["acting"] += int(scores.acting.sum())
        for k, level in enumerate(LEVELS):
            scaled = intervals.factor(part, level)
            for key, factor in (("covered", normal_factor(level)), ("scaled", scaled)):
                within = scores.sizes <= factor
                row[key][k] += int(within.sum())
                row[f"{key}_acting"][k] += int((within & scores.acting).sum())
        row["open"] += len(scores.sizes) if np.isinf(scaled) else 0
    return found


_COUNTS = ("covered", "covered_acting", "scaled", "scaled_acting")


@dataclass(frozen=True)
class CalibrationEvaluation:
    """What is evaluated.

    Attributes:
        scenario: with the first seed and the physics.
        overrides: its settings, for worker processes.
        trials: number of seeds.
        methods: `calibration`, by itself.
        workers: who works.
    """

    scenario: Scenario
    overrides: tuple[str, ...]
    trials: int
    methods: tuple[str, ...] = (CALIBRATION,)
    workers: Workers = Workers()

    def check(self) -> None:
        """Refuse what can't be evaluated.

        Raises:
            InputError: on other methods beside this one, no trial, or so many that they share demonstrations.
        """
        other = [m for m in self.methods if m != CALIBRATION]
        if other:
            raise InputError(f"{other[0]} can't be evaluated beside {CALIBRATION}; ask for it by itself")
        if not 1 <= self.trials <= HELD_OUT:
            raise InputError(f"--trials: give 1 to {HELD_OUT} seeds for {CALIBRATION}; beyond, seeds are held out")


def evaluate_calibration(what: CalibrationEvaluation, say: Say, rows: RowFile) -> dict[str, Any]:
    """Evaluate; see `CalibrationEvaluation`.

    Returns:
        `rows` (one a seed), and over all seeds `statuses` (one line an interaction) and `intervals` (one a variable).

    Raises:
        InputError: as `CalibrationEvaluation.check`.
        EvaluationInterrupted: on Ctrl-C, with what was finished.
        WorkerLostError: if a process was killed.
    """
    what.check()
    first = what.scenario.seed
    trials = [
        CalibrationTrial(type(what.scenario), what.overrides, what.scenario.physics, seed)
        for seed in range(first, first + what.trials)
    ]

    def found() -> dict[str, Any]:
        flat = rows.of(i for t in trials for i in t.ids)
        return {"rows": flat, "statuses": status_lines(flat), "intervals": interval_lines(flat)}

    return evaluate_jobs(trials, what.workers, rows, found, say)


def status_lines(rows: Sequence[Mapping[str, Any]]) -> list[Row]:
    """One line an interaction: means over seeds of figures of its rows, the `largest` error of one, and summed bins."""
    lines = []
    for name, found in _by_name(rows, "statuses").items():
        mean = {k: float(np.mean([f[k] for f in found])) for k in ("error", "alone", "left_out", "brier")}
        bins = {k: np.sum([f["bins"][k] for f in found], axis=0).tolist() for k in found[0]["bins"]}
        lines.append(
            {
                "interaction": name,
                "seeds": len(found),
                **{k: sum(f[k] for f in found) for k in ("rows", "active")},
                **mean,
                "largest": max(f["error"] for f in found),
                "bins": bins,
            }
        )
    return lines


def interval_lines(rows: Sequence[Mapping[str, Any]]) -> list[Row]:
    """One line a variable: sums over seeds, and the shares of them that `covered` and its like are; None of no row."""
    lines = []
    for name, found in _by_name(rows, "intervals").items():
        sums = {k: sum(f[k] for f in found) for k in ("rows", "acting", "open")}
        shares = {}
        for key in _COUNTS:
            of = sums["acting" if key.endswith("acting") else "rows"]
            shares[key] = [sum(f[key][k] for f in found) / of if of else None for k in range(len(LEVELS))]
        lines.append({"variable": name, "seeds": len(found), **sums, **shares})
    return lines


def _by_name(rows: Sequence[Mapping[str, Any]], key: str) -> dict[str, list[Row]]:
    out: dict[str, list[Row]] = {}
    for row in rows:
        for name, found in row[key].items():
            out.setdefault(name, []).append(found)
    return out


def bins_of(line: Mapping[str, Any]) -> list[tuple[float, float, int]]:
    """Mean probability, share that was active, and number of rows, of each bin that has any."""
    per_bin = zip(*(line["bins"][k] for k in ("rows", "predicted", "happened")), strict=True)
    return [(p / n, h / n, n) for n, p, h in per_bin if n]
