"""Effects of interactions that are always active together: told apart by what explains most, in any order."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning import InteractionSpec
from ichain_drake.learning.data import GraphData, Piece
from ichain_drake.learning.effects import effects
from ichain_drake.learning.effects.active_ticks import ActiveTicks
from ichain_drake.learning.effects.alignment import Alignment, PositionGroup
from ichain_drake.learning.effects.columns import Column
from ichain_drake.learning.effects.effects import (
    Effect,
    _gain,
    _holds_alone,
    _meaningless,
    _overlapping,
    _shows,
    learn_effects,
)
from ichain_drake.learning.noise import measurement_std
from ichain_drake.learning.passive import learn_passive
from ichain_drake.learning.settings import LEARNING
from ichain_drake.state import Role, StateSpace, Variable

PIECES, ROWS, NOISE, RATE, COOLING = 9, 50, 0.004, 0.03, -0.012
BUTTON, KNOB, LID = (Interaction(parent, "pot") for parent in ("button", "knob", "lid"))
SPACES = {
    "hand": StateSpace("hand", (Variable("x"),)),
    "button": StateSpace("button", (Variable("depth"),)),
    "knob": StateSpace("knob", (Variable("angle"),)),
    "lid": StateSpace("lid", (Variable("height"),)),
    "pot": StateSpace("pot", (Variable("place"), Variable("heat"))),
}
GRAPH = InteractionGraph(SPACES, [*(f"hand->{n}" for n in ("button", "knob", "lid")), BUTTON, KNOB, LID])

ORDERS = [(BUTTON, KNOB), (KNOB, BUTTON)]


def first(order: tuple[Interaction, ...]) -> str:
    """For the test's name."""
    return order[0].name


def pieces(seed: int, button: float = 0.0, airing: int = 0) -> tuple[Piece, ...]:
    """Pots on a stove, hotter by RATE a tick and radian, and by `button` and metre of it.

    Where a pot stands happens to go with how far the knob is turned, as it may in nine pieces. An open lid cools it by
    COOLING a tick, and is open in the last `airing` rows of heating and as many after it.
    """
    rng, out = np.random.default_rng(seed), []
    for k in range(PIECES):
        angle = 0.4 + 0.15 * k + np.where(np.arange(ROWS) < ROWS // 2, 0.0, rng.uniform(-0.2, 0.2))
        depth = np.repeat(rng.uniform(0.2, 1.0, 5), ROWS // 5)
        place = 0.1 * k + rng.uniform(-0.1, 0.1)
        on = (np.arange(ROWS) >= 5) & (np.arange(ROWS) < ROWS - 5)
        lid = (np.arange(ROWS) >= ROWS - 5 - airing) & (np.arange(ROWS) < ROWS - 5 + airing)
        change = on * (RATE * angle + button * depth) + lid * COOLING
        heat = np.cumsum(change) - change[0]
        noise = rng.normal(size=(5, ROWS))
        states = {
            "hand": np.zeros((ROWS, 1)),
            "button": (depth + 1e-3 * noise[0])[:, None],
            "knob": (angle + 1e-3 * noise[1])[:, None],
            "lid": (lid + 1e-3 * noise[2])[:, None],
            "pot": np.stack([place + 1e-3 * noise[3], heat + NOISE * noise[4]], axis=1),
        }
        idle = {e: np.zeros(ROWS, dtype=bool) for e in GRAPH.interactions}
        out.append(Piece(f"piece_{k}", states, idle | {BUTTON: on, KNOB: on, LID: lid}))
    return tuple(out)


def learned(shown: tuple[Piece, ...], edges: tuple[Interaction, ...]) -> dict[Interaction, tuple[Effect, ...]]:
    variables = {n: tuple(range(len(s))) for n, s in SPACES.items()}
    data = GraphData(GRAPH, SPACES, shown, edges, variables)
    noise, spec = {n: measurement_std(data, n) for n in SPACES}, InteractionSpec()
    passive = learn_passive(data, "pot", spec, noise)
    return learn_effects(data, "pot", passive, dict.fromkeys(edges), spec, noise)


def labels(found: tuple[Effect, ...]) -> dict[int, list[str]]:
    return {e.variable: [c.label for c in e.columns] for e in found}


@pytest.mark.parametrize("order", ORDERS, ids=first)
@pytest.mark.parametrize("seed", range(2))
def test_what_is_only_active_at_the_same_time_has_no_effect(seed: int, order: tuple[Interaction, ...]) -> None:
    found = learned(pieces(seed), order)
    assert found[BUTTON] == ()
    assert labels(found[KNOB]) == {1: ["parent angle"]}
    (effect,) = found[KNOB]
    pot, angle = np.array([[0.3, 0.2], [0.6, 0.5]]), np.array([[0.5], [1.5]])
    np.testing.assert_allclose(effect(angle, angle, pot), RATE * angle[:, 0], atol=1.5e-3)


@pytest.mark.parametrize("order", ORDERS, ids=first)
def test_two_that_both_act_are_both_found(order: tuple[Interaction, ...]) -> None:
    shown = pieces(0, button=0.04)
    found = learned(shown, order)
    assert "parent angle" in labels(found[KNOB])[1]
    assert "parent depth" in labels(found[BUTTON])[1]
    ends = {e: np.concatenate([p.states[e.parent][10:40:10] for p in shown]) for e in (KNOB, BUTTON)}
    pot = np.concatenate([p.states["pot"][10:40:10] for p in shown])
    together = sum(f(end, end, pot) for e, end in ends.items() for f in found[e])
    np.testing.assert_allclose(together, RATE * ends[KNOB][:, 0] + 0.04 * ends[BUTTON][:, 0], atol=3e-3)


@pytest.mark.parametrize("order", [(BUTTON, KNOB, LID), (KNOB, BUTTON, LID), (LID, BUTTON, KNOB)], ids=first)
def test_what_also_acts_alone_is_taken_off_first(order: tuple[Interaction, ...]) -> None:
    found = learned(pieces(1, airing=4), order)
    assert found[BUTTON] == ()
    assert labels(found[KNOB]) == {1: ["parent angle"]}
    (cooling,) = found[LID]
    one = np.ones((1, 1))
    np.testing.assert_allclose(cooling(one, one, np.array([[0.3, 0.5]])), COOLING, atol=3e-3)


class Adds:
    """An effect that always adds the same."""

    def __init__(self, amount: float, variable: int = 1) -> None:
        self.amount, self.variable = amount, variable

    def __call__(self, parent: np.ndarray, parent_next: np.ndarray, child: np.ndarray) -> np.ndarray:
        return np.full(len(child), self.amount)


class Stays:
    """A pot that does nothing by itself."""

    def __init__(self, kind: str = "hold", upper: float = np.inf, lower: float = -np.inf) -> None:
        heat = Variable("heat", lower=lower, upper=upper)
        self.space = StateSpace("pot", (Variable("place"), heat))
        self.variables = [SimpleNamespace(kind="hold"), SimpleNamespace(kind=kind)]

    def __call__(self, state: np.ndarray) -> np.ndarray:
        return state.copy()


def ticks(change: list[float], other: str = "", start: float = 0.0, parent_step: float = 0.0) -> ActiveTicks:
    """Of a pot whose heat changes so; another interaction acts where it is said."""
    n = len(change)
    heat = start + np.concatenate([[0.0], np.cumsum(change)])
    pot = np.column_stack([np.zeros(n + 1), heat])
    on = np.array([c == "1" for c in other or "0" * n])
    rows = np.arange(n)
    parent = parent_step * rows[:, None].astype(float)
    return ActiveTicks(
        parent, parent + parent_step, pot[:-1], pot[1:], pot[np.maximum(rows - 1, 0)],
        {LID: (np.zeros((n, 1)), np.zeros((n, 1)), on)}, rows // 10, rows % 10,
    )  # fmt: skip


@pytest.mark.parametrize(("amount", "holds"), [(0.5, True), (1.0, True), (1.9, True), (2.1, False), (-0.1, False)])
def test_an_effect_holds_where_it_predicts_no_worse_than_none_what_happens_without_others(
    amount: float, *, holds: bool
) -> None:
    """The heat rises by 1 a tick, and while the lid is open by 9."""
    effect: Any = Adds(amount)
    passive: Any = Stays()
    assert _holds_alone(effect, ticks([1.0, 1.0, 9.0, 9.0], "0011"), passive) is holds
    assert _holds_alone(effect, ticks([9.0, 9.0], "11"), passive), "where others always act nothing tells"


def test_what_a_bound_stops_speaks_not_against_it() -> None:
    full: Any = Stays(upper=5.0)
    effect: Any = Adds(3.0)
    assert _holds_alone(effect, ticks([1.0, 0.0, 0.0], start=4.0), full), "it would rise, but for its bound"
    free: Any = Stays()
    assert not _holds_alone(effect, ticks([1.0, 0.0, 0.0], start=4.0), free)


def test_what_explains_most_of_all_rows_gains_most() -> None:
    def of(explained: float, scale: float, samples: int) -> float:
        found: Any = SimpleNamespace(regression=SimpleNamespace(explained=explained, scale=scale, samples=samples))
        return _gain(found)

    assert of(0.5, 2.0, 10) == pytest.approx(20.0)
    assert of(0.9, 1.0, 20) < of(0.5, 2.0, 10) < of(0.3, 2.0, 20)


def test_who_overlaps_with_what_is_known_to_do_something() -> None:
    known: Any = {LID: Adds(1.0)}
    assert _overlapping(ticks([0.0, 0.0], "01"), known)
    assert not _overlapping(ticks([0.0, 0.0], "00"), known)
    assert not _overlapping(ticks([0.0, 0.0], "11"), {})


@pytest.mark.parametrize("kind", ["real", "binary"])
def test_a_motion_of_the_parent_is_an_input_where_it_is_more_than_its_noise(kind: Any) -> None:
    space = StateSpace("hand", (Variable("x", kind=kind),))
    noise = np.array([0.1])
    least = LEARNING.moving * np.sqrt(2.0) * 0.1
    for step, shows in ((0.9 * least, False), (1.1 * least, True)):
        rows = ticks([0.0] * 9, parent_step=step)
        assert bool(_shows(Column("parent_change", "", 0), rows, space, noise)) is (shows or kind == "binary")
        assert _shows(Column("parent", "", 0), rows, space, noise), "a place is none"
        group = PositionGroup("room", ("x",), (0,))
        along = Alignment(group, group, (), np.eye(1), np.zeros((1, 0)), np.zeros(1), 9, 0.0)
        assert bool(_shows(Column("aligned_change", "", 0, alignment=along), rows, space, noise)) is shows


def fitted(rows: ActiveTicks, monkeypatch: pytest.MonkeyPatch, *, use: np.ndarray | None = None, **more: Any) -> Any:
    """What an effect on the heat would be fitted to: changes, by row, and the window that they are judged by."""
    asked: list[Any] = []

    def choose(x: Any, y: Any, piece: Any, row: Any, estimators: Any, window: int, *rest: Any) -> None:
        asked.append((x, y, (10 * piece + row).tolist(), window))

    monkeypatch.setattr(effects, "choose_regression", choose)
    passive: Any = Stays(**{k: v for k, v in more.items() if k in ("kind", "lower", "upper")})
    columns = [Column("child", "heat", 1), Column("parent", "x", 0)]
    others: Any = more.get("others", {})
    found = effects._fit(1, rows, columns, passive, others, InteractionSpec(), np.full(2, 0.01), use)
    assert found is None
    return asked[0] if asked else None


def test_an_effect_is_fitted_to_what_nobody_else_explains(monkeypatch: pytest.MonkeyPatch) -> None:
    rows = ticks([1.0, 1.0, 4.0, 4.0, 1.0], "00110")
    x, y, at, window = fitted(rows, monkeypatch, others={LID: Adds(3.0)})
    np.testing.assert_allclose(y, 1.0)
    assert (at, window, x.shape) == ([0, 1, 2, 3, 4], InteractionSpec().window, (5, 2))
    _, y, at, _ = fitted(rows, monkeypatch, use=rows.alone)
    assert (y.tolist(), at) == ([1.0, 1.0, 1.0], [0, 1, 4])
    assert fitted(rows, monkeypatch, use=np.zeros(5, dtype=bool)) is None


def test_what_stands_at_a_bound_shows_nothing_that_pushes_it_there(monkeypatch: pytest.MonkeyPatch) -> None:
    full = ticks([1.0, 1.0, 0.0, 0.0, -1.0], start=3.0)
    assert fitted(full, monkeypatch, upper=5.0)[2] == [0, 1, 4], "but for what leaves it"
    assert fitted(full, monkeypatch)[2] == [0, 1, 2, 3, 4]
    empty = ticks([-1.0, -1.0, 0.0, 0.0, 1.0], start=2.0)
    assert fitted(empty, monkeypatch, lower=0.0)[2] == [0, 1, 4]
    brought = ticks([1.5, 0.0, 0.0], "110", start=3.5)
    assert fitted(brought, monkeypatch, upper=5.0, others={LID: Adds(2.0)}) is None, "another brings it there"
    less = ticks([1.0, 0.5, 0.0], "110", start=3.5)
    assert fitted(less, monkeypatch, upper=5.0, others={LID: Adds(2.0)})[2] == [0], "it would be there, and is not"


def test_what_has_no_memory_is_judged_tick_by_tick_and_does_not_predict_itself(monkeypatch: pytest.MonkeyPatch) -> None:
    x, _, _, window = fitted(ticks([1.0] * 5), monkeypatch, kind="constant")
    assert (window, x.shape[1]) == (1, 1)


def test_what_is_dissolved_in_next_to_nothing_tells_nothing() -> None:
    cup = StateSpace(
        "cup", (Variable("water", role=Role("amount")), Variable("heat", role=Role("intensive", of="water")))
    )
    least = LEARNING.empty * 0.01
    states = np.array([[0.9 * least, 5.0], [least, 5.0], [1.1 * least, 5.0]])
    assert _meaningless(cup, 1, states, np.full(2, 0.01)).tolist() == [True, False, False]
    assert not _meaningless(cup, 0, states, np.full(2, 0.01)).any()
