"""What scenarios with a held control share: which noise meets which world."""

import itertools

import numpy as np
import pytest

from ichain_drake.control.tracking.path import TimedPath
from ichain_drake.systems import load_scenario
from ichain_drake.systems.car_game.scenario import CarGame


@pytest.fixture
def keyed(monkeypatch: pytest.MonkeyPatch) -> tuple[CarGame, list[tuple[int, int]]]:
    """A scenario, and the noise's keys (seed, object) of every object in every world that it builds."""
    scenario = load_scenario("car_game", ["learning.samples=2"], "ideal", 3)
    assert isinstance(scenario, CarGame)
    keys: list[tuple[int, int]] = []
    build = scenario.build_world

    def noted(*args, **kwargs):
        world = build(*args, **kwargs)
        settings = [system.settings for system in world.objects.values()]
        keys.extend((s.seed, s.object_id) for s in settings)
        return world

    monkeypatch.setattr(scenario, "build_world", noted)
    return scenario, keys


def test_no_demonstration_shares_noise_with_another_or_with_a_run(keyed) -> None:
    scenario, keys = keyed
    shown = [list(scenario.record_demonstrations()), [scenario.monolithic_demonstration(2)]]
    assert [p.name for p in itertools.chain(*shown)] == ["play", "drive", "drive"]
    demonstrated = list(keys)
    assert len(set(demonstrated)) == len(demonstrated) == 6, "two objects in three worlds"
    keys.clear()
    path = TimedPath(np.array([[200.0, 300.0], [400.0, 300.0], [600.0, 300.0]]), scenario.path_limits())
    for run in range(5):
        scenario.make_world(path, run)
    assert not set(keys) & set(demonstrated)
    # Every run's key is this seed's: so of so many runs none meets a demonstration's, or another seed's.
    assert {k // 1000 for k, _ in demonstrated} == {k // 1000 for k, _ in keys} == {3}
    assert min(k % 1000 for k, _ in demonstrated) > 900 > max(k % 1000 for k, _ in keys)
