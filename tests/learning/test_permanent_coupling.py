"""A gear: an interaction that is active in every row is learned, and no piece without it is asked for."""

import numpy as np
import pandas as pd

from ichain_drake.demonstrations import Demonstration
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning import learn_interactions
from ichain_drake.state import StateSpace, Variable
from ichain_drake.timing import TICK

GRAPH = InteractionGraph(
    {
        "crank": StateSpace("crank", (Variable("turn", "rad", -50.0, 50.0),)),
        "lift": StateSpace("lift", (Variable("height", "m", -5.0, 5.0),)),
    },
    ["crank->lift"],
)
RATIO = 0.1


def turned(k: int) -> Demonstration:
    rng = np.random.default_rng(k)
    turn = np.cumsum(rng.uniform(-0.5, 0.5, 8).repeat(10))
    table = {
        "time": TICK * np.arange(len(turn)),
        "crank.turn": turn + 0.002 * rng.normal(size=len(turn)),
        "lift.height": RATIO * turn + 0.002 * rng.normal(size=len(turn)),
        "crank->lift": 1.0,
    }
    return Demonstration(pd.DataFrame(table), name=f"turn_{k}")


def test_a_gear_is_learned() -> None:
    model = learn_interactions([turned(k) for k in range(5)], GRAPH)
    edge = Interaction("crank", "lift")
    states = {"crank": np.array([1.0]), "lift": np.array([0.3])}
    after, active = model.step(states, np.array([1.4]))
    assert bool(active[edge])
    assert model.edges[edge].status.estimator == "always"
    np.testing.assert_allclose(after["lift"], [0.3 + RATIO * 0.4], atol=0.01)
    assert not any("without" in w for w in model.report()["warnings"])
