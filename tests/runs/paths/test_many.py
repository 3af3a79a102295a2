"""Many runs: together where that is possible, else one after another; a run that raises is a finding about itself."""

from typing import Any

import numpy as np
import pytest

from ichain_drake.control.tracking.path import TimedPath
from ichain_drake.errors import InputError
from ichain_drake.objects import Car
from ichain_drake.runs.paths import many
from ichain_drake.runs.paths.following import oracle_follow
from ichain_drake.runs.paths.many import oracle_follow_many
from ichain_drake.scenarios.base import PathScenario
from ichain_drake.systems.car_game.scenario import CarGame
from ichain_drake.world.world import World

POINTS = np.stack([np.linspace(300.0, 320.0, 20), np.full(20, 300.0)], axis=1)


@pytest.fixture
def alone(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Seeds of the runs that were run alone."""
    seeds: list[int] = []

    def counted(scenario: PathScenario, *given: Any) -> Any:
        seeds.append(scenario.seed)
        return oracle_follow(scenario, *given)

    monkeypatch.setattr(many, "oracle_follow", counted)
    return seeds


def followed(kind: type[CarGame], seeds: range) -> tuple[list[PathScenario], TimedPath, list[Any]]:
    scenarios: list[PathScenario] = [kind((), "ideal", seed) for seed in seeds]
    path = TimedPath(POINTS, scenarios[0].path_limits())
    return scenarios, path, oracle_follow_many(scenarios, "line", path, 0)


def same(one: Any, other: Any) -> bool:
    return (one.error, one.paper_metric, one.completed, one.reason, one.control_steps) == (
        other.error, other.paper_metric, other.completed, other.reason, other.control_steps,
    )  # fmt: skip


def test_one_is_run_alone_too_and_the_others_together(alone: list[int]) -> None:
    scenarios, path, found = followed(CarGame, range(20, 24))
    assert alone == [21]
    assert all(same(f, oracle_follow(s, "line", path, 0)) for f, s in zip(found, scenarios, strict=True))
    assert len({f.error for f in found}) == 4


def test_few_are_run_alone(alone: list[int]) -> None:
    followed(CarGame, range(20, 23))
    assert alone == [20, 21, 22]


class Tabular(Car):
    """A car of a user's that takes one state."""

    def step(self, state: Any, *given: Any) -> Any:
        if state.ndim > 2:
            raise ValueError("one state, please")
        return super().step(state, *given)

    def measure(self, state: Any, noise: Any) -> Any:
        if state.ndim > 1:
            raise ValueError("one state, please")
        return super().measure(state, noise)


class TabularGame(CarGame):
    """A game with such a car, which can't be made for one seed."""

    target_type = Tabular

    def make_world(self, path: TimedPath, run: int) -> World:
        if self.seed == 22:
            raise InputError("no world for this seed")
        return super().make_world(path, run)


def test_what_cannot_be_calculated_together_is_run_alone_and_an_error_is_that_of_its_run(alone: list[int]) -> None:
    scenarios, path, found = followed(TabularGame, range(20, 25))
    assert alone == [21, 20, 22, 23, 24]
    assert [str(f) for f in found if isinstance(f, Exception)] == ["no world for this seed"]
    assert isinstance(found[2], InputError)
    assert same(found[4], oracle_follow(scenarios[4], "line", path, 0))
    with pytest.warns(UserWarning, match="one by one: together they end in ValueError: one state, please"):
        scenarios, path, found = followed(TabularGame, range(23, 27))
    assert alone[5:] == [24, 23, 25, 26]


def test_a_bit_that_differs_is_reason_enough(alone: list[int], monkeypatch: pytest.MonkeyPatch) -> None:
    calculated = many.follow_path_together

    def off(*given: Any) -> Any:
        runs = calculated(*given)
        states = runs[1][0].states["car"]
        states[-1, 0] = np.nextafter(states[-1, 0], np.inf)
        return runs

    monkeypatch.setattr(many, "follow_path_together", off)
    followed(CarGame, range(20, 24))
    assert alone == [21, 20, 22, 23]
