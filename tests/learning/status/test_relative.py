"""What is beside something that always stood in one place: the roles say that it is beside it elsewhere, too."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from ichain_drake.demonstrations import Demonstration
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning import learn_interactions
from ichain_drake.learning.status.inputs import PlaceInput, RelativeInput
from ichain_drake.learning.status.relative import relative_if_as_good, rested
from ichain_drake.state import Role, StateSpace, Variable
from ichain_drake.timing import TICK

NOISE = 0.002


def place(frame: str) -> tuple[Variable, ...]:
    return tuple(Variable(a, "m", -2, 2, role=Role("position", frame, a)) for a in "xy")


GRAPH = InteractionGraph(
    {
        "robot": StateSpace("robot", place("base")),
        "lamp": StateSpace("lamp", (*place("base"), Variable("light", lower=-1, upper=9))),
    },
    ["robot->lamp"],
)


def pieces(count: int = 6) -> list[Demonstration]:
    """A robot passes a lamp that shines brighter while it is near; the lamp stands where it is."""
    rng, out = np.random.default_rng(3), []
    for k in range(count):
        way = np.linspace(-0.3, 0.3, 61)
        other = rng.uniform(-0.15, 0.15)
        robot = np.stack([way, np.full(61, other)] if k % 2 else [np.full(61, other), way], axis=1)
        flag = (np.abs(robot) < 0.1).all(axis=1)
        light = np.cumsum(0.1 * flag)
        read = {"robot.x": robot[:, 0], "robot.y": robot[:, 1], "lamp.x": 0.0, "lamp.y": 0.0, "lamp.light": light}
        columns = {n: v + rng.normal(0.0, NOISE, 61) for n, v in read.items()}
        table = pd.DataFrame({"time": np.arange(61) * TICK, **columns, "robot->lamp": flag.astype(float)})
        units = dict.fromkeys(columns, "m") | {"lamp.light": "1"}
        out.append(Demonstration(table, units, f"piece_{k}"))
    return out


def test_the_relative_place_wins_a_tie() -> None:
    model = learn_interactions(pieces(), GRAPH)
    edge = Interaction("robot", "lamp")
    assert model.edges[edge].relative
    away = {"robot": np.array([1.0, 0.5]), "lamp": np.array([1.0, 0.5, 0.0])}
    assert model.decide(edge, away) >= 0.0
    assert model.decide(edge, {**away, "robot": np.zeros(2)}) < 0.0
    assert model.probability(edge, away) > 0.9
    assert "constant" not in {v.kind for v in model.passive["lamp"].variables[:2]}, "it stays where it is put, too"


def test_what_stands_is_read_with_less_noise_and_what_moves_as_it_is() -> None:
    rng = np.random.default_rng(0)
    values = rng.normal(0.0, NOISE, (80, 1))
    values[40:, 0] += np.arange(40) * 0.05
    out = rested(values, np.zeros(80, dtype=np.intp), np.array([NOISE]))
    assert out[:35].std() < 0.5 * NOISE
    np.testing.assert_array_equal(out[46:], values[46:])


@pytest.mark.parametrize("at", [-3.0, 0.0, 5.0])
def test_what_stands_still_does_so_wherever_it_is(at: float) -> None:
    values = at + np.random.default_rng(1).normal(0.0, NOISE, (60, 1))
    out = rested(values, np.zeros(60, dtype=np.intp), np.array([NOISE]))
    assert out.std() < 0.6 * NOISE
    assert out.mean() == pytest.approx(at, abs=NOISE)


@pytest.mark.parametrize(("gains", "relative"), [([1.0, 0.2], True), ([1.0] * 8, False), ([-1.0], True)])
def test_a_place_is_kept_only_where_it_is_surely_better(gains: list[float], relative: bool) -> None:
    """By two standard errors: a little better in a few pieces is chance, and roles say what holds elsewhere."""
    place, beside = object.__new__(PlaceInput), object.__new__(RelativeInput)
    object.__setattr__(place, "obj", "lamp")
    object.__setattr__(beside, "edge", Interaction("robot", "lamp"))
    object.__setattr__(beside, "alignment", SimpleNamespace(rows=5))
    at, off = SimpleNamespace(item=place), SimpleNamespace(item=beside)
    choice = SimpleNamespace(
        piece=np.arange(len(gains)), left_out=lambda chosen: np.array(gains) * (at in chosen)
    )  # fmt: skip
    found, _ = relative_if_as_good(choice, [at], [at, off])  # type: ignore[arg-type, list-item]
    assert found == ([off] if relative else [at])
