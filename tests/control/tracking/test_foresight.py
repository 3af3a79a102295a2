"""Where a chain is a part of a tick later: beside the exact flow of a linear system."""

import numpy as np
import pandas as pd
import pytest
from scipy.linalg import expm

from ichain_drake.control.tracking.foresight import foreseen
from ichain_drake.demonstrations import Demonstration
from ichain_drake.graph import InteractionGraph
from ichain_drake.learning.chain.chain import LearnedChain, LinkCandidates, learn_chain
from ichain_drake.learning.chain.link import EstimatorSpec
from ichain_drake.state import StateSpace, Variable
from ichain_drake.timing import TICK

HAND, STICK = StateSpace("hand", (Variable("x", "m"),)), StateSpace("stick", (Variable("a"),))
CART = StateSpace("cart", (Variable("s", "m"), Variable("v", "m/s")))
GRAPH = InteractionGraph({"hand": HAND, "stick": STICK, "cart": CART}, ["hand->stick", "stick->cart"])
LAG = 0.15
RATE = np.array([[0.0, 1.0, 0.0], [0.0, -1 / LAG, 1 / LAG], [0.0, 0.0, 0.0]])  # s, v, and the stick that it settles to


def flow(cart: np.ndarray, stick: float, seconds: float) -> np.ndarray:
    return (expm(RATE * seconds) @ [*cart, stick])[:2]


@pytest.fixture(scope="module")
def chain() -> LearnedChain:
    rng = np.random.default_rng(0)
    hand = rng.uniform(-1.0, 1.0, 60)
    cart = [np.zeros(2)]
    for x in hand[1:]:
        cart.append(flow(cart[-1], 2.0 * x, TICK))
    table = {"time": TICK * np.arange(60), "hand.x": hand, "command.x": np.roll(hand, -1), "stick.a": 2.0 * hand}
    table |= {"cart.s": [c[0] for c in cart], "cart.v": [c[1] for c in cart]}
    spec = EstimatorSpec("polynomial", {"degree": 1})
    candidates = {
        "hand->stick": LinkCandidates((spec,), (spec,), features=("none",)),
        "stick->cart": LinkCandidates((spec,), (spec,), features=("raw",), forward_actions=("next",)),
    }
    return learn_chain([Demonstration(pd.DataFrame(table))], GRAPH, "cart", ("s",), candidates)


@pytest.mark.parametrize("ticks", [0.1, 0.5, 0.9, 1.0, 1.5, 3.0])
def test_any_part_of_a_tick_is_on_the_true_flow(chain: LearnedChain, ticks: float) -> None:
    cart = np.array([0.3, -0.8])
    states = [np.array([[0.1]]), np.array([[0.2]]), cart[None]]
    hand, stick, later = foreseen(chain, states, np.array([[0.4]]), ticks)
    np.testing.assert_array_equal(hand, [[0.4]])  # where it was sent
    np.testing.assert_allclose(stick, [[0.8]], atol=1e-3)  # at once
    np.testing.assert_allclose(later[0], flow(cart, 0.8, ticks * TICK), atol=2e-3)


def test_nothing_is_foreseen_in_no_time(chain: LearnedChain) -> None:
    states = [np.array([[0.1]]), np.array([[0.2]]), np.array([[0.3, -0.8]])]
    for was, now in zip(states, foreseen(chain, states, np.array([[0.4]]), 0.0), strict=True):
        np.testing.assert_array_equal(now, was)


def test_states_in_a_batch_are_foreseen_each_by_itself(chain: LearnedChain) -> None:
    rng = np.random.default_rng(1)
    states = [rng.normal(size=(4, n)) for n in (1, 1, 2)]
    command = rng.normal(size=(4, 1))
    both = foreseen(chain, states, command, 0.6)
    for k in range(4):
        one = foreseen(chain, [s[k : k + 1] for s in states], command[k : k + 1], 0.6)
        for a, b in zip(both, one, strict=True):
            np.testing.assert_allclose(a[k : k + 1], b, atol=1e-9)
