"""The noise of a run: read off its readings, whatever moves; used where it is surely larger than was learned."""

import numpy as np
import pytest
from toy_models import TAP_START, tap

from ichain_drake.control.execution.sensing import SensorNoise
from ichain_drake.control.settings import EXECUTION

LEARNED = 0.01


def model():
    """The tap, with readings of its cup that are known to have some noise."""
    toy = tap()
    toy.noise = {n: np.full(len(v), LEARNED) for n, v in TAP_START.items()}
    return toy


def seen(toy, scale, ticks, moving=0.0, seed=1):
    """What so many readings tell; the cup's place changes by `moving` a tick, and speeds up now and then."""
    rng, noise, before = np.random.default_rng(seed), SensorNoise(), None
    for tick in range(ticks):
        now = {n: v + LEARNED * scale * rng.standard_normal(v.shape) for n, v in TAP_START.items()}
        now["cup"][0] += moving * (tick + (tick % 10 == 0))
        if before is not None:
            noise = noise.seen(toy, before, now)
        before = now
    return noise


@pytest.mark.parametrize("moving", [0.0, 0.2])
def test_three_times_the_noise_is_noticed(moving):
    toy = model()
    found = seen(toy, 3.0, 100, moving).in_force(toy).noise["cup"][0]
    assert 1.8 * LEARNED < found < 5.0 * LEARNED


def test_what_was_learned_holds_where_readings_tell_no_other():
    toy = model()
    for seed in range(20):
        assert seen(toy, 1.0, 60, seed=seed).in_force(toy) is toy
    assert seen(toy, 0.2, 60).in_force(toy) is toy  # a quieter sensor: what was learned is enough
    assert SensorNoise().in_force(toy) is toy
    assert seen(toy, 30.0, 4).in_force(toy) is toy  # too few to tell


def test_what_is_known_exactly_stays_so():
    toy = model()
    toy.noise["cup"] = np.array([LEARNED, 0.0])
    assert seen(toy, 3.0, 100).in_force(toy).noise["cup"][1] == 0.0


def test_only_the_newest_readings_count():
    toy = model()
    noise = seen(toy, 3.0, 300)
    assert len(noise.bends) == EXECUTION.noise_rows
