"""An evaluation whose trials share demonstrations: the rows of single runs, however they are grouped."""

from collections.abc import Mapping

import numpy as np
import pytest

from ichain_drake.errors import InputError
from ichain_drake.runs.clusters.workers import Workers
from ichain_drake.runs.paths import shared
from ichain_drake.runs.paths.choice import choose_paths
from ichain_drake.runs.paths.evaluation import VARIANTS, learn_variant, path_row
from ichain_drake.runs.paths.following import follow, oracle_follow
from ichain_drake.runs.paths.shared import check_shared_evaluation, evaluate_shared_paths
from ichain_drake.systems.car_game.scenario import CarGame


class ShortGame(CarGame):
    """The car game with one path of two seconds."""

    def reference_paths(self) -> Mapping[str, np.ndarray]:
        t = np.linspace(0.0, 1.0, 50)[:, None]
        return {"bend": np.concatenate([300 + 60 * t, 300 + 10 * t**2], axis=1)}


def test_rows_are_those_of_single_runs_for_any_grouping(monkeypatch: pytest.MonkeyPatch) -> None:
    game, methods = ShortGame((), "ideal", 30), ["paper@50", "oracle"]
    found = evaluate_shared_paths(game, (), 5, methods)
    rows = found["rows"]
    assert [(r["seed"], r["method"]) for r in rows] == [(s, m) for s in range(30, 35) for m in ("paper", "oracle")]
    assert {r["demonstrations"] for r in rows} == {"seed 30"}
    (variant,) = [v for v in VARIANTS if v.label == "paper@50"]
    taught = ShortGame(["learning.samples=50"], "ideal", 30)
    chain, controller = learn_variant(taught, variant, list(taught.record_demonstrations()))
    other = ShortGame((), "ideal", 33)
    ((case, path),) = choose_paths(other).items()
    single = path_row("paper", 50, other, case, follow(other, chain, controller, case, path, 0))
    assert rows[6] == single | {"demonstrations": "seed 30"}
    assert all(r["success"] for r in rows if r["method"] == "oracle")
    monkeypatch.setattr(shared, "_TOGETHER", 1)
    assert evaluate_shared_paths(game, (), 5, methods, Workers(1, "", 600.0)) == found


class Drawn(ShortGame):
    """Each seed has a path of its own."""

    def reference_paths(self) -> Mapping[str, np.ndarray]:
        return {name: points + [0.0, self.seed] for name, points in super().reference_paths().items()}


def test_every_seed_follows_its_own_path() -> None:
    rows = evaluate_shared_paths(Drawn((), "ideal", 30), (), 5, ["oracle"])["rows"]
    other = Drawn((), "ideal", 34)
    ((case, path),) = choose_paths(other).items()
    single = path_row("oracle", 0, other, case, oracle_follow(other, case, path, 0))
    assert rows[4] == single | {"demonstrations": "seed 30"}


class Stuck(ShortGame):
    """One seed has no world."""

    def make_world(self, *given):  # type: ignore[no-untyped-def]
        if self.seed == 31:
            raise InputError("no world for this seed")
        return super().make_world(*given)


def test_reasons_stand_in_their_rows() -> None:
    found = evaluate_shared_paths(Stuck((), "ideal", 30), (), 2, ["paper@50"])
    one, stuck = found["rows"]
    assert "no world" not in one["reason"]
    assert (stuck["reason"], stuck["success"], stuck["error"]) == ("no world for this seed", False, None)


def test_what_cannot_be_learned_is_the_reason_of_all_rows(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*given: object) -> None:
        raise InputError("too few")

    monkeypatch.setattr(shared, "learn_variant", refuse)
    found = evaluate_shared_paths(ShortGame((), "ideal", 30), (), 2, ["paper@50"])
    assert [(r["seed"], r["reason"], r["success"]) for r in found["rows"]] == [
        (30, "too few", False), (31, "too few", False),
    ]  # fmt: skip


def test_what_is_refused() -> None:
    with pytest.raises(InputError, match="first_link has no trials"):
        check_shared_evaluation(CarGame((), "ideal", 0), 2, ["first_link"])
    with pytest.raises(InputError, match="no method 'magic'"):
        check_shared_evaluation(CarGame((), "ideal", 0), 2, ["magic"])
