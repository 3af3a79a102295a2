"""Figures of calibration on other seeds: against plain numpy, of graphs and chains, and summed over seeds."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import small_world
from linked_library import CHAIN

from ichain_drake.demonstrations import Demonstration
from ichain_drake.errors import InputError
from ichain_drake.learning import InteractionModel, KnownParts, learn_interactions
from ichain_drake.learning.intervals import conformal_intervals
from ichain_drake.learning.residuals import tick_scores
from ichain_drake.learning.selection import calibration_error
from ichain_drake.runs import calibration
from ichain_drake.runs.calibration import (
    CalibrationEvaluation,
    CalibrationTrial,
    bins_of,
    interval_figures,
    interval_lines,
    status_figures,
    status_lines,
)

HELD_OUT, ASIDE = small_world.pieces(1), small_world.pieces(2)


@pytest.fixture(scope="module")
def model() -> InteractionModel:
    return learn_interactions(small_world.pieces(0), small_world.GRAPH)


def test_statuses_are_judged_given_the_row_before(model: InteractionModel) -> None:
    found = status_figures(model, HELD_OUT)
    assert set(found) == {e.name for e in model.graph.interactions}
    for edge in model.graph.interactions:
        figures, status = found[edge.name], model.edges[edge].status
        p, alone, truth = [], [], []
        for piece in HELD_OUT:
            states = {n: piece.states(n, s) for n, s in model.graph.objects.items()}
            flags = piece.table[edge.name].to_numpy() > 0.5
            around = {n: states[n] for n in (edge.child, *model.graph.parents(edge.child))}
            p.append(status.probability(around, np.concatenate([[False], flags[:-1]])))
            alone.append(model.probability(edge, states))
            truth.append(flags)
        told, on = np.concatenate(p), np.concatenate(truth)
        assert figures["brier"] == pytest.approx(np.mean((told - on) ** 2))
        tenth = np.minimum(np.floor(told * 10), 9)
        off = sum(abs(np.sum(on[tenth == k] - told[tenth == k])) for k in range(10)) / len(on)
        assert figures["error"] == pytest.approx(off)
        assert (figures["rows"], figures["active"]) == (len(on), on.sum()) == (len(np.concatenate(alone)), on.sum())
        assert figures["left_out"] == status.calibration_error
        assert figures["alone"] == pytest.approx(calibration_error(np.concatenate(alone), on))
        assert sum(figures["bins"]["rows"]) == len(on)


def test_intervals_are_counted_by_variable_over_what_acts(model: InteractionModel) -> None:
    found = interval_figures(model, HELD_OUT, ASIDE)
    scores, scaled = tick_scores(model, HELD_OUT), conformal_intervals(model, ASIDE)
    water = model.graph.objects["box"].observable.index("water")
    mine = {p: s for p, s in scores.items() if p[:2] == ("box", water)}
    row = found["box.water"]
    assert row["rows"] == sum(len(s.sizes) for s in mine.values())
    assert row["covered"][1] == sum(np.sum(s.sizes <= 1.6448536269514722) for s in mine.values())
    assert row["covered_acting"][0] == sum(np.sum((s.sizes <= 0.6744897501960817) & s.acting) for s in mine.values())
    assert row["scaled"][1] == sum(np.sum(s.sizes <= scaled.factor(p, 0.9)) for p, s in mine.items())
    assert 0 < row["acting"] < row["rows"]
    assert row["open"] == 0
    assert "valve.level" not in found
    few = interval_figures(model, HELD_OUT, [_rows(p, 3) for p in ASIDE[:2]])
    assert few["lamp.glow"]["open"] == few["lamp.glow"]["rows"] == few["lamp.glow"]["scaled"][1]


def _rows(piece: Demonstration, count: int) -> Demonstration:
    return replace(piece, table=piece.table.iloc[:count])


def test_a_chain_has_intervals_and_no_statuses(monkeypatch: pytest.MonkeyPatch) -> None:
    chain = InteractionModel.of_chain(CHAIN, [], KnownParts())
    monkeypatch.setattr(calibration, "interval_figures", lambda *given: {"car.x": {}})
    assert calibration.figures(chain, [], []) == {"statuses": {}, "intervals": {"car.x": {}}}


def line(error: float, rows: int = 10) -> dict:
    return {
        "rows": rows, "active": 4, "error": error, "alone": 0.2, "left_out": 0.1, "brier": error / 2,
        "bins": {"rows": [rows - 4, 0, 4], "predicted": [0.6, 0.0, 3.6], "happened": [0, 0, 4]},
    }  # fmt: skip


def test_lines_are_over_all_seeds_that_were_finished() -> None:
    rows = [
        {"seed": 1, "reason": "", "statuses": {"a->b": line(0.01)}, "intervals": {}},
        {"seed": 2, "reason": "", "statuses": {"a->b": line(0.03)}, "intervals": {}},
        {"seed": 3, "reason": "no piece", "statuses": {}, "intervals": {}},
    ]
    (found,) = status_lines(rows)
    assert (found["interaction"], found["seeds"], found["rows"], found["active"]) == ("a->b", 2, 20, 8)
    assert (found["error"], found["largest"], found["brier"]) == pytest.approx((0.02, 0.03, 0.01))
    assert bins_of(found) == [(pytest.approx(0.1), 0.0, 12), (pytest.approx(0.9), 1.0, 8)]
    counts = {"rows": 10, "acting": 0, "open": 3, "covered": [5, 9], "scaled": [4, 8]}
    counts |= {"covered_acting": [0, 0], "scaled_acting": [0, 0]}
    (told,) = interval_lines([{"statuses": {}, "intervals": {"b.x": counts}}] * 2)
    assert (told["rows"], told["open"], told["covered"], told["scaled"]) == (20, 6, [0.5, 0.9], [0.4, 0.8])
    assert told["covered_acting"] == [None, None], "no effect acts"
    assert status_lines([]) == interval_lines([]) == []


def test_a_trial_learns_from_its_seed_and_is_judged_by_others(monkeypatch: pytest.MonkeyPatch) -> None:
    class Small:
        """A scenario of pieces of small worlds."""

        def __init__(self, overrides: tuple, physics: str, seed: int) -> None:
            self.seed, self.graph = seed, "a graph"

        def record_demonstrations(self) -> list[str]:
            return [f"piece of {self.seed}"]

    monkeypatch.setattr(calibration, "learn", lambda scenario, shown: ("model", scenario.seed, shown))
    monkeypatch.setattr(calibration, "figures", lambda *given: {"given": given})
    trial = CalibrationTrial(Small, (), "ideal", 7)  # type: ignore[arg-type]
    ((name, row),) = trial.run(trial.ids)
    assert name == "calibration/7"
    assert row["given"] == (("model", 7, ["piece of 7"]), ["piece of 507"], ["piece of 1007"])
    assert trial.failed(name, "no piece") == {
        "method": "calibration", "seed": 7, "reason": "no piece", "statuses": {}, "intervals": {},
    }  # fmt: skip


@pytest.mark.parametrize(
    ("trials", "methods", "words"),
    [
        (5, ("calibration", "slip"), "slip can't be evaluated beside calibration; ask for it by itself"),
        (0, ("calibration",), "--trials: give 1 to 500 seeds"),
        (501, ("calibration",), "--trials: give 1 to 500 seeds for calibration; beyond, seeds are held out"),
    ],
)
def test_what_cannot_be_evaluated_is_refused(trials: int, methods: tuple[str, ...], words: str) -> None:
    with pytest.raises(InputError, match=words):
        CalibrationEvaluation(SimpleNamespace(seed=0), (), trials, methods).check()  # type: ignore[arg-type]
