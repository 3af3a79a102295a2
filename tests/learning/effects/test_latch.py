"""What an interaction does at once, in the tick in which it begins: a latch that either of two parents closes."""

import numpy as np

from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning import InteractionSpec
from ichain_drake.learning.data import GraphData, Piece
from ichain_drake.learning.effects.effects import Effect, learn_effects
from ichain_drake.learning.noise import measurement_std
from ichain_drake.learning.passive import learn_passive
from ichain_drake.state import BoolArray, StateSpace, Variable

ROWS = 20
SPACES = {
    "hand": StateSpace("hand", (Variable("x"),)),
    "ball": StateSpace("ball", (Variable("x"),)),
    "trap": StateSpace("trap", (Variable("shut", lower=0, upper=1, kind="binary"), Variable("dust"))),
}
HAND, BALL = Interaction("hand", "trap"), Interaction("ball", "trap")
GRAPH = InteractionGraph(SPACES, ["hand->ball", HAND, BALL])


def between(first: int, last: int) -> BoolArray:
    return (np.arange(ROWS) >= first) & (np.arange(ROWS) < last)


def piece(k: int, hand: BoolArray, ball: BoolArray, dust: float) -> Piece:
    """A trap that shuts in the tick in which it is touched; dust falls on it then, and only then."""
    rng, touched = np.random.default_rng(k), hand | ball
    shut = np.maximum.accumulate(touched).astype(float)
    begins = np.concatenate([[0.0], np.diff(shut)])
    fallen = dust * np.cumsum(begins) + 1e-4 * rng.normal(size=ROWS)
    states = {n: 0.1 * rng.normal(size=(ROWS, 1)) for n in ("hand", "ball")}
    states["trap"] = np.stack([shut, fallen], axis=1)
    idle = np.zeros(ROWS, dtype=bool)
    return Piece(f"piece_{k}", states, {Interaction("hand", "ball"): idle, HAND: hand, BALL: ball})


def learned(shown: tuple[Piece, ...]) -> dict[Interaction, tuple[Effect, ...]]:
    variables = {n: tuple(range(len(s))) for n, s in SPACES.items()}
    data = GraphData(GRAPH, SPACES, shown, GRAPH.interactions, variables)
    noise, spec = {n: measurement_std(data, n) for n in SPACES}, InteractionSpec()
    passive = learn_passive(data, "trap", spec, noise)
    return learn_effects(data, "trap", passive, dict.fromkeys((HAND, BALL)), spec, noise)


def test_both_shut_it_though_they_also_do_it_together_and_touch_it_when_it_is_shut() -> None:
    never = between(0, 0)
    shown = [piece(k, between(5 + k % 3, 12), never, 0.0) for k in range(8)]
    shown += [piece(10 + k, never, between(4 + k % 4, 11), 0.0) for k in range(8)]
    shown += [piece(20 + k, between(6, 12), between(6, 14), 0.0) for k in range(3)]
    shown += [piece(30 + k, between(3, 6), between(8, 12), 0.0) for k in range(3)]
    found = learned(tuple(shown))
    for edge in (HAND, BALL):
        assert [e.variable for e in found[edge]] == [0]
        (effect,) = found[edge]
        np.testing.assert_allclose(effect(np.zeros((1, 1)), np.zeros((1, 1)), np.zeros((1, 2))), 1.0)


def test_what_changes_gradually_is_not_taken_for_a_latch() -> None:
    """A jolt in the tick in which something is touched is no effect that goes on."""
    shown = [piece(k, between(5 + k % 3, 12), between(0, 0), 0.05) for k in range(10)]
    shown += [piece(20 + k, between(0, 0), between(4 + k % 4, 11), 0.05) for k in range(10)]
    assert [e.variable for e in learned(tuple(shown))[HAND]] == [0]
