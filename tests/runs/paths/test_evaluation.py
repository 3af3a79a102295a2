"""Evaluation: a table made of rows, and nobody sees more samples than the table says."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from ichain_drake.demonstrations.table import Demonstration
from ichain_drake.errors import InputError
from ichain_drake.runs.paths import evaluation
from ichain_drake.runs.paths.evaluation import (
    METHODS,
    PathSeed,
    PathVariant,
    check_evaluation,
    evaluate_paths,
    learn_variant,
    monolithic,
    shorten,
)
from ichain_drake.runs.paths.summary import summarise
from ichain_drake.systems import load_scenario
from ichain_drake.systems.car_game.scenario import CarGame
from ichain_drake.timing import TICK


def row(method: str, samples: int, case: str, seed: int, error: float | None) -> dict:
    return {
        "method": method, "samples": samples, "case": case, "seed": seed, "success": error is not None, "error": error,
        "unit": "m",
    }  # fmt: skip


def test_mean_spread_and_ratio_over_the_seeds_that_both_completed():
    rows = [
        row("default", 500, "eight", 0, 1.0),
        row("default", 500, "eight", 1, 2.0),
        row("default", 500, "eight", 2, None),
        row("oracle", 0, "eight", 0, 0.5),
        row("oracle", 0, "eight", 1, None),
        row("oracle", 0, "eight", 2, 0.7),
    ]
    default, oracle = summarise(rows)
    assert (default["runs"], default["completed"]) == (3, 2)
    assert (default["mean_error"], default["std_error"], default["max_error"]) == (1.5, 0.5, 2.0)
    assert default["ratio_to_oracle"] == pytest.approx(2.0)  # seed 0 alone
    assert default["unit"] == oracle["unit"] == "m"
    assert oracle["ratio_to_oracle"] == pytest.approx(1.0)


def test_rows_without_any_success_or_oracle_give_none():
    (line,) = summarise([row("paper", 50, "eight", 0, None)])
    assert line["completed"] == 0
    assert [line[k] for k in ("mean_error", "std_error", "max_error", "ratio_to_oracle")] == [None] * 4
    (line,) = summarise([row("paper", 50, "eight", 0, 1.0)])
    assert line["ratio_to_oracle"] is None
    assert summarise([]) == []


def test_a_shortened_piece_has_so_many_transitions_and_no_row_more():
    flags = np.array([0, 1, 1, 0, 1, 1, 1, 1, 1, 1])
    table = pd.DataFrame({"time": TICK * np.arange(10), "a->b": flags})
    piece = Demonstration(table, {}, "piece")
    for samples, rows in ((1, 3), (2, 6), (3, 7), (100, 10)):
        short = shorten(piece, samples).table
        on = short["a->b"].to_numpy() > 0.5
        assert len(short) == rows
        assert (on[:-1] & on[1:]).sum() == min(samples, 6)
    free = Demonstration(table[["time"]], {}, "piece")
    assert len(shorten(free, 4)) == 5


def test_a_method_at_one_number_of_samples():
    scenario = load_scenario("car_game", ["path.speed=60"], "ideal", 0)
    found = evaluate_paths(scenario, ["path.speed=60"], 1, ["default@100"])
    assert {(r["method"], r["samples"]) for r in found["rows"]} == {("default", 100)}
    with pytest.raises(InputError, match="no method 'default@77'; .* default@50, default@100"):
        check_evaluation(scenario, 1, ["default@77"])


def test_what_is_refused():
    scenario = load_scenario("car_game", (), "ideal", 0)
    check_evaluation(scenario, 1, METHODS)
    with pytest.raises(InputError, match="no method 'magic'; there are paper, default"):
        check_evaluation(scenario, 1, ["magic"])
    for trials in (0, -1):
        with pytest.raises(InputError, match="give numbers from 1"):
            evaluate_paths(scenario, (), trials, ["oracle"])


def test_a_seed_that_raises_has_rows_with_the_reason():
    class Broken(CarGame):
        def record_demonstrations(self, progress=None, known=()):
            raise InputError(f"no joystick on seed {self.seed}")

    found = evaluate_paths(Broken((), "ideal", 3), (), 2, ["default@100", "oracle"], rows=None)
    assert len(found["rows"]) == 2 * 2 * 3
    assert {r["reason"] for r in found["rows"]} == {"no joystick on seed 3", "no joystick on seed 4"}
    assert {(r["method"], r["samples"]) for r in found["rows"]} == {("default", 100), ("oracle", 0)}
    assert not any(r["success"] for r in found["rows"])
    assert {(line["seeds"], line["completed"]) for line in found["table"]} == {("3-4", 0)}
    first = evaluate_paths(Broken((), "ideal", 3), (), 1, ["first_link"], rows=None)["rows"]
    assert [(r["method"], r["case"].rpartition(" ")[2], r["reason"], r["success"]) for r in first] == [
        ("first_link", case, "no joystick on seed 3", False) for case in ("moving", "rest")
    ]


def test_nothing_beyond_the_samples_of_a_row_is_used_for_it() -> None:
    """Not for models, command map, limits or validation: what comes later in a piece may be anything."""
    settings = ["learning.samples=150", "learning.estimator=polynomial(degree=2)", "control.efforts=[0.05]"]
    scenario = load_scenario("car_game", settings, "ideal", 0)
    pieces = list(scenario.record_demonstrations())
    variant = PathVariant("default", "predictive", 50)
    later = []
    for piece in pieces:
        table = piece.table.copy()
        after = len(shorten(piece, 50).table)
        assert len(table) - after > 90
        numbers = [c for c in table.columns if c != "time" and "->" not in c]
        table.loc[table.index[after:], numbers] *= 0.5
        later.append(replace(piece, table=table))
    found = [learn_variant(scenario, variant, shown) for shown in (pieces, later)]
    (first, control), (second, other) = found
    errors = [[o.error for o in made.options] for made in (control, other)]  # not a number where only one is tried
    np.testing.assert_array_equal(*errors)
    assert [replace(o, error=0.0) for o in control.options] == [replace(o, error=0.0) for o in other.options]
    for name in ("hand_limit", "command_lower", "command_upper"):
        np.testing.assert_array_equal(getattr(first, name), getattr(second, name))
    for one, same in zip(first.links, second.links, strict=True):
        np.testing.assert_array_equal(one.child_limit, same.child_limit)
        for key, array in one.forward.model.frozen.arrays().items():
            np.testing.assert_array_equal(array, same.forward.model.frozen.arrays()[key])


def test_without_a_factoring_the_robot_moves_the_target_by_the_last_links_candidates():
    scenario, last = CarGame((), "ideal"), object()
    graph, candidates = monolithic(scenario, {"joystick->car": last, "hand->joystick": object()})
    assert set(graph.objects) == {scenario.graph.root, "car"}
    (edge,) = graph.interactions
    assert (edge.parent, edge.child) == (scenario.graph.root, "car")
    assert candidates == {edge.name: last}


def test_the_oracle_has_a_row_for_each_path(monkeypatch: pytest.MonkeyPatch) -> None:
    scenario = load_scenario("car_game", (), "ideal", 4)
    names = tuple(scenario.reference_paths())

    def followed(scenario: object, name: str, path: object, number: int) -> object:
        return SimpleNamespace(
            completed=name != names[1], error=0.5 + number, paper_metric=2.0 + number, reason="it took too long"
        )

    monkeypatch.setattr(evaluation, "oracle_follow", followed)
    rows = PathSeed(CarGame, (), "ideal", 4, ("oracle",), names)._rows()
    assert [(r["method"], r["samples"], r["seed"], r["case"]) for r in rows] == [("oracle", 0, 4, n) for n in names]
    assert [r["error"] for r in rows] == [0.5, None, 2.5]
    assert [r["paper_metric"] for r in rows] == [2.0, None, 4.0]
    assert [r["reason"] for r in rows] == ["", "it took too long", ""]
    assert [r["success"] for r in rows] == [True, False, True]


@pytest.mark.parametrize(
    ("methods", "shown"),
    [
        (("default@100", "paper@50"), {"paper@50": "100 samples", "default@100": "100 samples"}),
        (("monolithic",), {"monolithic@1000": "whole of 1000"}),
        (("oracle",), {}),
    ],
)
def test_each_variant_learns_from_the_pieces_that_are_meant_for_it(
    monkeypatch: pytest.MonkeyPatch, methods: tuple[str, ...], shown: dict[str, str]
) -> None:
    """No sample more is recorded than the largest of them needs; and nothing that none of them learns from."""
    recorded = []

    class Shown(CarGame):
        def record_demonstrations(self, progress=None, known=()):
            recorded.append("pieces")
            return [f"{self.config.learning.samples} samples"]

        def monolithic_demonstration(self, samples):
            recorded.append("whole")
            return f"whole of {samples}"

    seen = {}
    monkeypatch.setattr(evaluation, "oracle_follow", lambda *_: SimpleNamespace(completed=False, reason=""))
    monkeypatch.setattr(
        evaluation, "_evaluate_variant", lambda scenario, v, pieces: [seen.__setitem__(v.label, " ".join(pieces))]
    )
    PathSeed(Shown, (), "ideal", 0, methods, ())._rows()
    assert seen == shown
    assert recorded.count("whole") == ("monolithic" in methods)
    assert ("pieces" in recorded) is bool(shown)
