"""What goes back to a value by itself, and what keeps its own."""

import numpy as np
import pytest

from ichain_drake.learning.discovery.log import RawPiece, make_log
from ichain_drake.learning.discovery.passive_kind import constant_values
from ichain_drake.state import Role, StateSpace, Variable


@pytest.mark.filterwarnings("ignore:Mean of empty slice", "ignore:invalid value")  # of a hand that stands still
@pytest.mark.parametrize("back", [False, True])
def test_what_goes_back_within_a_tick_has_a_rest_value_and_what_differs_from_piece_to_piece_has_none(
    back: bool,
) -> None:
    """Pieces of two rows: in one half of them it is off its rest, for both rows or for one."""
    spaces = {
        "hand": StateSpace("hand", (Variable("x"),)),
        "can": StateSpace("can", (Variable("a", role=Role("amount")),)),
    }
    pieces = []
    for k in range(41):
        off = float(k % 2)
        level = np.array([[off], [0.0 if back else off]])
        pieces.append(RawPiece(f"p{k}", {"hand": np.zeros((2, 1)), "can": level}))
    log = make_log(pieces, spaces, "hand", {})
    log.noise["can"][:] = 1e-3
    found = constant_values(log, "can", ("hand",))
    assert found == {0: 0.0 if back else None}


@pytest.mark.parametrize("follows", [True, False])
def test_what_follows_its_parent_by_a_curve_has_no_memory_though_it_is_hardly_ever_at_rest(follows: bool) -> None:
    """A stick that goes with the hand, or that is moved on by it."""
    rng = np.random.default_rng(0)
    spaces = {"hand": StateSpace("hand", (Variable("x"),)), "stick": StateSpace("stick", (Variable("axis"),))}
    pieces = []
    for k in range(6):
        hand = 0.5 + np.cumsum(rng.normal(scale=0.2, size=80))
        hand = 2.0 * np.abs((0.5 * hand) % 2.0 - 1.0) - 1.0  # to and fro between -1 and 1
        stick = np.tanh(1.5 * hand) if follows else 0.2 * np.cumsum(hand)
        stick = stick + rng.normal(scale=0.005, size=80)
        pieces.append(RawPiece(f"p{k}", {"hand": hand[:, None], "stick": stick[:, None]}))
    log = make_log(pieces, spaces, "hand", {})
    log.noise["stick"][:] = 0.005
    (rest,) = constant_values(log, "stick", ("hand",)).values()
    assert (rest is not None) == follows
    assert np.mean(np.abs(np.concatenate([p.states["stick"] for p in pieces])) < 0.05) < 0.2, "hardly ever at rest"
