"""What is beside something that always stood in one place: the roles say that it is beside it elsewhere, too."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest

from ichain_drake.demonstrations import Demonstration
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning import learn_interactions
from ichain_drake.learning.selection import clearly
from ichain_drake.learning.status.choice import Candidate
from ichain_drake.learning.status.inputs import PlaceInput, RelativeInput
from ichain_drake.learning.status.relative import beside_relative, relative_if_as_good, rested
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


class Told:
    """Inputs that are chosen, and what they tell of some pieces, by the names of the inputs [nat]."""

    def __init__(self, told: dict[str, float], chosen: list[Candidate], pieces: int = 2) -> None:
        self.told, self.chosen, self.piece = told, chosen, np.arange(pieces)

    def left_out(self, inputs: list[Candidate]) -> np.ndarray:
        return np.full(len(self.piece), self.told.get("".join(sorted(str(c.values) for c in inputs)), -99.0))

    def choose(self, candidates: list[Candidate]) -> list[Candidate]:
        return [c for c in self.chosen if c in candidates]

    def clear(self, gains: np.ndarray) -> bool:
        return clearly(gains) and gains.sum() > 1.0


def _three(monkeypatch: pytest.MonkeyPatch) -> dict[str, Candidate]:
    """The place of an oven's button, that of the food, and where the food is relative to the button."""
    monkeypatch.setattr("ichain_drake.learning.status.relative.objects_of", lambda item: item.objects)

    def made(kind: type, name: str, *objects: str) -> Candidate:
        item: Any = kind.__new__(kind)
        for key, value in {"objects": objects, "obj": objects[0], "alignment": SimpleNamespace(rows=0)}.items():
            object.__setattr__(item, key, value)
        return Candidate(item, name, np.ones(1))  # type: ignore[arg-type]

    return {
        "b": made(PlaceInput, "b", "button"),
        "f": made(PlaceInput, "f", "food"),
        "r": made(RelativeInput, "r", "button", "food"),
    }


def test_the_relative_place_takes_that_of_the_end_that_it_tells_best(monkeypatch: pytest.MonkeyPatch) -> None:
    three = _three(monkeypatch)
    told = {"bf": -1.0, "br": -2.0, "fr": -50.0, "r": -60.0}
    out, left = relative_if_as_good(Told(told, [three["r"]]), [three["b"], three["f"]], list(three.values()))  # type: ignore[arg-type]
    assert out == [three["b"], three["r"]], "as the button is pushed, it is no matter where the food is beside it"
    assert left == list(three.values())


@pytest.mark.parametrize(("both", "taken"), [(-1.0, "bf"), (-1.95, "r")])
def test_both_ends_are_taken_where_they_clearly_tell_more_than_one_relative_to_the_other(
    both: float, taken: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A search that takes the relative place first finds that neither end adds anything to it."""
    three = _three(monkeypatch)
    choice = Told({"bf": both, "r": -2.0}, [three["b"], three["f"]], 8)
    out, _ = relative_if_as_good(choice, [three["r"]], list(three.values()))  # type: ignore[arg-type]
    assert "".join(sorted(str(c.values) for c in out)) == taken


@pytest.mark.parametrize(("without", "alone", "kept"), [(-9.0, False, True), (-1.4, False, False), (-9.0, True, False)])
def test_a_place_beside_a_relative_one_is_left_out_unless_it_clearly_tells_more(
    without: float, *, alone: bool, kept: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Not where a wrong flag or two would make up for it, nor in one piece alone."""
    three = _three(monkeypatch)
    choice = Told({"br": -1.0, "r": without}, [three["r"]])
    if alone:
        monkeypatch.setattr(choice, "left_out", lambda inputs: np.array([0.0, -1.0 if len(inputs) > 1 else without]))
    out, left = relative_if_as_good(choice, [three["r"], three["b"]], list(three.values()))  # type: ignore[arg-type]
    assert (out, left) == (([three["r"], three["b"]], list(three.values())) if kept else ([three["r"]], [three["r"]]))


def test_beside_a_relative_place_no_place_of_its_ends_is_asked_about(monkeypatch: pytest.MonkeyPatch) -> None:
    three = _three(monkeypatch)
    every = list(three.values())
    assert beside_relative([three["b"]], every) == every, "none is chosen"
    assert beside_relative([three["b"], three["r"]], every) == [three["r"]]
    three["r"].item.alignment.rows = 40  # type: ignore[attr-defined]
    assert beside_relative([three["r"]], every) == every, "what goes along is no place beside another"


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
