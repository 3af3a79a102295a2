"""Several hands that may take the same thing: one at a time, by closing around it."""

import numpy as np
import pytest

from ichain_drake.errors import InputError
from ichain_drake.objects.hands import Hands
from ichain_drake.state import Role, StateSpace, Variable

HAND = StateSpace(
    "hand",
    (
        Variable("z", "m", role=Role("position", "robot", "z")),
        Variable("y", "m", role=Role("position", "robot", "y")),
        Variable("grip", "1", 0.0, 1.0, "binary"),
    ),
)
THING = StateSpace("thing", (Variable("y", "m"), Variable("z", "m"), *Hands.variables(["a", "b"])))
FREE = {"a": False, "b": False}


def hands() -> Hands:
    return Hands("thing", THING, {"a": HAND, "b": HAND}, (0.02, 0.03))


def at(y: float, z: float, grip: float) -> np.ndarray:
    return np.array([z, y, grip])


AWAY = at(1.0, 1.0, 0.0)


@pytest.mark.parametrize(
    ("hand", "taken"),
    [
        (at(0.519, 0.2, 1.0), True),
        (at(0.521, 0.2, 1.0), False),
        (at(0.5, 0.229, 1.0), True),
        (at(0.5, 0.231, 1.0), False),
        (at(0.5, 0.2, 0.0), False),
    ],
)
def test_a_hand_takes_what_it_closes_around(hand: np.ndarray, *, taken: bool) -> None:
    state = np.array([0.5, 0.2, 0.0, 0.0])
    assert hands().holding(state, {"a": AWAY, "b": hand}, FREE) == {"a": False, "b": taken}


def test_a_closed_hand_that_comes_by_takes_nothing_and_one_that_opens_lets_go() -> None:
    both, state = hands(), np.array([0.5, 0.2, 0.0, 0.0])
    near = {"a": at(0.5, 0.2, 1.0), "b": AWAY}
    both.remember(state, near)
    assert state.tolist() == [0.5, 0.2, 1.0, 0.0]
    assert both.holding(state, near, FREE) == FREE
    held = {"a": True, "b": False}
    assert both.holding(state, {"a": at(0.9, 0.9, 1.0), "b": AWAY}, held) == held
    assert both.holding(state, {"a": at(0.5, 0.2, 0.0), "b": AWAY}, held) == FREE


def test_what_one_holds_the_other_does_not_take() -> None:
    state, near = np.array([0.5, 0.2, 1.0, 0.0]), at(0.5, 0.2, 1.0)
    held = {"a": True, "b": False}
    assert hands().holding(state, {"a": near, "b": near}, held) == held
    fresh = np.array([0.5, 0.2, 0.0, 0.0])
    assert sum(hands().holding(fresh, {"a": near, "b": near}, FREE).values()) == 1


@pytest.mark.parametrize(
    ("parents", "message"),
    [
        ({}, "a thing has a hand among its parents; none given"),
        ({"a": StateSpace("tank", HAND.variables[:2])}, "its parent a has no grip"),
        ({"a": StateSpace("tank", HAND.variables[1:])}, "its parent a has no position along z"),
    ],
)
def test_parents_that_are_no_hands_are_refused(parents: dict[str, StateSpace], message: str) -> None:
    with pytest.raises(InputError, match=message):
        Hands("thing", THING, parents, (0.02, 0.03))
