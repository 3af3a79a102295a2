"""Runs that are calculated together are, in every bit of every frame, what each is in a Diagram of its own."""

from collections.abc import Mapping
from functools import cache
from typing import Any

import numpy as np
import pytest

from ichain_drake.control.tracking.chain import ChainController
from ichain_drake.control.tracking.path import TimedPath
from ichain_drake.learning.chain.chain import LearnedChain
from ichain_drake.objects import Car, ObjectSettings
from ichain_drake.objects.base import ParentStates
from ichain_drake.objects.rows import NotTogetherError
from ichain_drake.objects.vehicles.car import CarParameters
from ichain_drake.runs.paths.evaluation import PathVariant, learn_variant
from ichain_drake.runs.paths.following import oracle_controller, oracle_truth
from ichain_drake.scenarios.base import PathScenario
from ichain_drake.simulation.episode import follow_path
from ichain_drake.simulation.together import follow_path_together
from ichain_drake.simulation.wiring import path_controller
from ichain_drake.state import FloatArray
from ichain_drake.systems import load_scenario
from ichain_drake.systems.car_game.scenario import CarGame
from ichain_drake.world.rows import WorldRows

SEEDS = (11, 12, 13)
NOISY = ["noise.scale=1.5", "noise.vehicle=1"]
SYSTEMS = {
    ("car_game", "predictive"): 60.0,
    ("car_game", "inverse"): 60.0,
    ("hover_game", "inverse"): 60.0,
    ("driving", "predictive"): 3.0,
    ("ship", "inverse"): 3.0,
}
"""Systems and methods, and how long a path is followed here, in its unit."""


def bend(scenario: PathScenario, length: float) -> TimedPath:
    """A gentle bend from the middle of the plane."""
    t = np.linspace(0.0, 1.0, 40)[:, None]
    return TimedPath(
        np.array(scenario.size) / 2 + length * np.concatenate([t, 0.15 * t**2], axis=1), scenario.path_limits()
    )


def scenarios_of(name: str, settings: list[str]) -> list[PathScenario]:
    scenarios = [load_scenario(name, settings, "ideal", seed) for seed in SEEDS]
    return [s for s in scenarios if isinstance(s, PathScenario)]


def check(scenarios: list[PathScenario], path: TimedPath, commander: Any, truth: tuple[str, ...] = ()) -> list[int]:
    """Whether all runs are the same together and alone; how many frames each took."""
    worlds = [s.make_world(path, 3) for s in scenarios]
    together = follow_path_together(worlds, commander(worlds[0]), truth)
    for scenario, (log, arrival) in zip(scenarios, together, strict=True):
        world = scenario.make_world(path, 3)
        alone, its_arrival = follow_path(world, commander(world), truth)
        np.testing.assert_array_equal(log.times, alone.times)
        np.testing.assert_array_equal(log.command, alone.command)
        assert set(log.states) == set(alone.states)
        for name, states in log.states.items():
            np.testing.assert_array_equal(states, alone.states[name], err_msg=name)
        assert arrival.arrived == its_arrival.arrived
        assert arrival.reason("", 1.0) == its_arrival.reason("", 1.0)
    return [len(log.times) for log, _ in together]


@cache
def learned(name: str, control: str) -> tuple[LearnedChain, ChainController]:
    teacher = load_scenario(name, ["learning.samples=60"], "ideal", 5)
    assert isinstance(teacher, PathScenario)
    return learn_variant(teacher, PathVariant("", control, 60), list(teacher.record_demonstrations()))


@pytest.mark.parametrize("settings", [[], NOISY], ids=["usual", "noisy"])
@pytest.mark.parametrize(("name", "control"), SYSTEMS)
def test_every_system_that_runs_without_an_arm(name: str, control: str, settings: list[str]) -> None:
    scenarios = scenarios_of(name, settings)
    path = bend(scenarios[0], SYSTEMS[name, control])
    frames = check(scenarios, path, lambda world: path_controller(*learned(name, control), path))
    assert min(frames) > 20


@pytest.mark.parametrize("name", ["car_game", "driving"])
def test_the_oracle(name: str) -> None:
    scenarios = scenarios_of(name, [])
    path = bend(scenarios[0], 30.0 if name == "car_game" else 1.0)
    check(scenarios, path, lambda world: oracle_controller(scenarios[0], world, path), oracle_truth(scenarios[0]))


def test_runs_end_one_by_one() -> None:
    """Some arrive earlier than others, which go on as if nothing had happened."""
    scenarios = scenarios_of("car_game", ["noise.scale=4"])
    path = bend(scenarios[0], 90.0)
    frames = check(scenarios, path, lambda world: path_controller(*learned("car_game", "inverse"), path))
    assert len(set(frames)) > 1


class CarsOfTheirOwn(CarGame):
    """A game in which each seed has another car."""

    def make_target(self, state: FloatArray, settings: ObjectSettings) -> Car:
        car = CarParameters(acceleration=90.0 + self.seed)
        return Car(self.target, {self.control: self.control_type.state_space}, car, initial=state, settings=settings)


class Blurred(Car):
    """A car that a mean over the rows drives."""

    def step(
        self, state: FloatArray, parents: ParentStates, active: Mapping[str, FloatArray], noise: FloatArray, dt: float
    ) -> FloatArray:
        after = super().step(state, parents, active, noise, dt)
        return after if after.ndim == 1 else after + 1e-9 * after.mean(axis=0)


class BlurredGame(CarGame):
    """A game with such a car."""

    target_type = Blurred


@pytest.mark.parametrize("kind", [CarsOfTheirOwn, BlurredGame])
def test_what_would_differ_is_noticed(kind: type[CarGame]) -> None:
    scenarios = [kind((), "ideal", seed) for seed in SEEDS]
    path = bend(scenarios[0], 30.0)
    with pytest.raises(NotTogetherError, match="other bits for many rows than for one"):
        check(scenarios, path, lambda world: path_controller(*learned("car_game", "inverse"), path))


def test_worlds_that_are_not_alike_are_refused() -> None:
    path = bend(CarGame((), "ideal"), 30.0)
    one, noisy = (CarGame(settings, "ideal", 1).make_world(path, 0) for settings in ((), ("noise.scale=2",)))
    with pytest.raises(NotTogetherError, match="joystick differs from run to run"):
        WorldRows([one, noisy])
    with pytest.raises(NotTogetherError, match="no arm"):
        WorldRows([one, CarGame((), "arm", 1).make_world(path, 0)])
    ship = load_scenario("driving", (), "ideal", 1)
    assert isinstance(ship, PathScenario)
    with pytest.raises(NotTogetherError):
        WorldRows([one, ship.make_world(bend(ship, 3.0), 0)])
