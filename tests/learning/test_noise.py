"""How noisy readings are: from what steady motion and switching leave."""

import numpy as np
import pandas as pd

from ichain_drake.demonstrations import Demonstration
from ichain_drake.graph import InteractionGraph
from ichain_drake.learning.data import GraphData, collect
from ichain_drake.learning.noise import measurement_std
from ichain_drake.state import StateSpace, Variable
from ichain_drake.timing import TICK

HAND = StateSpace("hand", (Variable("x", "m"),))
LAMP = StateSpace("lamp", (Variable("level", kind="integer"), Variable("heat"), Variable("angle", "rad", kind="angle")))
GRAPH = InteractionGraph({"hand": HAND, "lamp": LAMP}, ["hand->lamp"])


def data(noise: float, rows: int = 400, pieces: int = 3) -> GraphData:
    made = []
    for seed in range(pieces):
        rng, t = np.random.default_rng(seed), np.arange(rows)
        table = {
            "time": TICK * t,
            "hand.x": 0.01 * t + noise * rng.normal(size=rows),  # steady motion
            "lamp.level": (t // 50 % 2).astype(float),
            "lamp.heat": np.full(rows, 0.3),
            "lamp.angle": (0.2 * t + noise * rng.normal(size=rows) + np.pi) % (2 * np.pi) - np.pi,
            "hand->lamp": (t // 50 % 2).astype(float),
        }
        made.append(Demonstration(pd.DataFrame(table), name=f"piece_{seed}"))
    return collect(made, GRAPH)


def test_steady_motion_is_no_noise() -> None:
    np.testing.assert_allclose(measurement_std(data(0.003), "hand"), 0.003, rtol=0.1)


def test_turns_of_an_angle_are_no_noise() -> None:
    assert np.isclose(measurement_std(data(0.003), "lamp")[2], 0.003, rtol=0.1)


def test_a_whole_number_is_rounded_and_what_never_varies_has_almost_no_noise() -> None:
    level, heat, _ = measurement_std(data(0.003), "lamp")
    assert level == 12.0**-0.5  # of a number that is uniform between two whole ones
    assert 0 < heat <= 1e-20
    assert 0 < measurement_std(data(0.0), "hand")[0] <= 1e-8  # of a range of 4 m
