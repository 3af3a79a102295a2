"""Effects of interactions that are always active together: told apart by what explains most, in any order."""

import numpy as np
import pytest

from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning import InteractionSpec
from ichain_drake.learning.data import GraphData, Piece
from ichain_drake.learning.effects.effects import Effect, learn_effects
from ichain_drake.learning.noise import measurement_std
from ichain_drake.learning.passive import learn_passive
from ichain_drake.state import StateSpace, Variable

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


def labels(effects: tuple[Effect, ...]) -> dict[int, list[str]]:
    return {e.variable: [c.label for c in e.columns] for e in effects}


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
