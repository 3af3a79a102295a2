"""Passive dynamics: what holds its value, what springs back, and what returns slowly, however long it rests."""

import numpy as np
import pandas as pd
import pytest

from ichain_drake.demonstrations import Demonstration
from ichain_drake.graph import InteractionGraph
from ichain_drake.learning import InteractionModel, learn_interactions
from ichain_drake.learning.data import collect
from ichain_drake.learning.noise import measurement_std
from ichain_drake.learning.passive import learn_passive
from ichain_drake.learning.spec import InteractionSpec
from ichain_drake.state import StateSpace, Variable
from ichain_drake.timing import TICK

GRAPH = InteractionGraph(
    {
        "finger": StateSpace("finger", (Variable("z", "m", 0.0, 1.0),)),
        "spring": StateSpace("spring", (Variable("depth", "m", -1.0, 1.0),)),
    },
    ["finger->spring"],
)
NOISE = 0.01


def pressed(kept: float, rest: int) -> list[Demonstration]:
    """A finger that presses a spring now and then; of its depth a share is kept in each tick after the release."""
    out = []
    for k in range(5):
        rng = np.random.default_rng(k)
        z, depth, on = [], [], []
        now = 0.0
        for _ in range(4):
            target = rng.uniform(0.3, 0.6)
            for pressing, count in ((False, rest), (True, 6)):
                for _ in range(count):
                    now = target if pressing else kept * now
                    z.append(target if pressing else 0.0)
                    depth.append(now)
                    on.append(float(pressing))
        noise = NOISE * rng.normal(size=(2, len(z)))
        table = pd.DataFrame(
            {
                "time": TICK * np.arange(len(z)),
                "finger.z": np.clip(z + noise[0], 0.0, 1.0),
                "spring.depth": np.array(depth) + noise[1],
                "finger->spring": on,
            }
        )
        out.append(Demonstration(table, name=f"press_{k}"))
    return out


def learned(kept: float, rest: int) -> InteractionModel:
    return learn_interactions(pressed(kept, rest), GRAPH)


@pytest.mark.parametrize("rest", [4, 60])
def test_what_springs_back_is_seen_however_long_it_rests(rest: int) -> None:
    variable = learned(0.0, rest).passive["spring"].variables[0]
    assert variable.kind == "constant"
    assert variable.value == pytest.approx(0.0, abs=0.01)


def test_what_returns_slowly_does_so_when_predicted() -> None:
    passive = learned(0.6, 40).passive["spring"]
    assert passive.variables[0].kind == "learned"
    assert passive(np.array([[0.4]]))[0, 0] == pytest.approx(0.24, abs=0.03)


def test_what_stays_where_it_is_left_holds() -> None:
    assert learned(1.0, 20).passive["spring"].variables[0].kind == "hold"


@pytest.mark.parametrize("seed", [11, 17])
def test_what_readings_alone_may_give_is_no_drift(seed: int) -> None:
    rng, names = np.random.default_rng(seed), "abcdef"
    still = InteractionGraph(
        {
            "finger": GRAPH.objects["finger"],
            "thing": StateSpace("thing", tuple(Variable(n, "m") for n in names)),
        },
        ["finger->thing"],
    )
    pieces = []
    for k in range(13):
        rows = int(rng.integers(10, 52))
        read = rng.normal(size=len(names)) + 0.1 * rng.normal(size=(rows, len(names)))
        states = {f"thing.{n}": column for n, column in zip(names, read.T, strict=True)}
        table = {"time": TICK * np.arange(rows), "finger.z": rng.uniform(size=rows), **states}
        table["finger->thing"] = (np.arange(rows) >= rows - 2).astype(float)
        pieces.append(Demonstration(pd.DataFrame(table), name=f"rest_{k}"))
    data = collect(pieces, still)
    passive = learn_passive(data, "thing", InteractionSpec(), {"thing": measurement_std(data, "thing")})
    assert {v.kind for v in passive.variables} == {"hold"}
