"""Passive dynamics: what holds its value, what springs back, and what returns slowly, however long it rests."""

from typing import Any

import numpy as np
import pandas as pd
import pytest

from ichain_drake.demonstrations import Demonstration
from ichain_drake.graph import InteractionGraph
from ichain_drake.learning import InteractionModel, learn_interactions
from ichain_drake.learning.data import GraphData, Piece, collect
from ichain_drake.learning.noise import measurement_std
from ichain_drake.learning.passive import PassiveDynamics, PassiveVariable, learn_passive
from ichain_drake.learning.settings import LEARNING
from ichain_drake.learning.spec import InteractionSpec
from ichain_drake.state import Role, StateSpace, Variable
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


def test_left_alone_each_variable_does_what_its_kind_does_within_its_bounds() -> None:
    space = StateSpace(
        "cup",
        (
            Variable("water", lower=0.0, upper=2.0, role=Role("amount")),
            Variable("flow", role=Role("change", of="water")),
            Variable("lid"),
            Variable("yaw", "rad", kind="angle"),
            Variable("heat", lower=-5.0, upper=5.0),
        ),
    )
    drift: Any = lambda rows: rows @ [-0.5, 0.25]  # noqa: E731
    turn: Any = lambda rows: np.full(len(rows), 0.4)  # noqa: E731
    passive = PassiveDynamics(
        space,
        (
            PassiveVariable("learned", drift=drift, inputs=(0, 4)),
            PassiveVariable("change", amount=0),
            PassiveVariable("constant", value=0.3),
            PassiveVariable("learned", drift=turn, inputs=(0,)),
            PassiveVariable("hold"),
        ),
    )
    state = np.array([[1.0, 7.0, 9.0, 3.0, 4.0], [0.2, 7.0, 9.0, 0.0, -4.0]])
    after = passive(state)
    np.testing.assert_allclose(after, [[1.5, 0.0, 0.3, 3.4, 4.0], [-0.9, 0.0, 0.3, 0.4, -4.0]])
    np.testing.assert_array_equal(state[:, 1], 7.0, "what is handed in stays")
    settled = passive.settle(state, after + [[0, 0, 0, 0, 9.0], [0, 0, 0, 0, 0]])
    np.testing.assert_allclose(settled, [[1.5, 0.5, 0.3, 3.4 - 2 * np.pi, 5.0], [0.0, -0.2, 0.3, 0.4, -4.0]])


def learned_alone(values: list[np.ndarray], busy: list[np.ndarray], noise: float = 0.01) -> PassiveVariable:
    """What is learned of a spring's only variable, in pieces in which something acts in some rows."""
    edge = GRAPH.interactions[0]
    pieces = [
        Piece(f"p{k}", {"finger": np.zeros((len(v), 1)), "spring": v[:, None]}, {edge: b})
        for k, (v, b) in enumerate(zip(values, busy, strict=True))
    ]
    spaces = {n: s.observable for n, s in GRAPH.objects.items()}
    data = GraphData(GRAPH, spaces, tuple(pieces), (edge,), {"finger": (0,), "spring": (0,)})
    (variable,) = learn_passive(data, "spring", InteractionSpec(), {"spring": np.full(1, noise)}).variables
    return variable


def sprung(depth: float, rest: float = 0.2, *, holds: bool = False) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """Three pieces in which a spring is pressed twice for five rows, and then is at rest again, or stays."""
    rng, values, busy = np.random.default_rng(0), [], []
    for _ in range(3):
        on = np.arange(40) // 5 % 4 == 1
        value = np.where(on, rest + depth, rest)
        if holds:
            value = np.cumsum(on) * depth / 5 + rest
        values.append(value + 0.01 * rng.normal(size=40))
        busy.append(on)
    return values, busy


def test_what_is_back_at_once_is_told_from_what_stays_where_it_was_left() -> None:
    back = learned_alone(*sprung(0.5))
    assert back.kind == "constant"
    assert back.value == pytest.approx(0.2, abs=0.005)
    assert 0.01 <= back.std < 0.02
    stays = learned_alone(*sprung(0.5, holds=True))
    assert stays.kind == "hold"
    assert stays.std == pytest.approx(np.sqrt(2.0) * 0.01, rel=0.3), "of a change: two readings'"
    assert back.samples == stays.samples == 3 * 29, "ticks that end with nothing acting"
    tiny = learned_alone(*sprung(0.03))
    assert tiny.kind == "hold", "within some noises of rest nothing tells"


def test_where_it_was_hardly_left_alone_it_holds() -> None:
    values = [np.array([0.5, 0.4, 0.1, 0.2, 0.9, 0.7])]
    for quiet in (LEARNING.short - 1, LEARNING.short):
        busy = np.arange(6) > quiet
        found = learned_alone(values, [busy])
        assert (found.kind, found.samples) == ("hold", quiet)
        assert (found.std == 0.01) is (quiet < LEARNING.short)
