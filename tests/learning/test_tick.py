"""One tick of one object: who acts on it, from which state, and when it is over."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ichain_drake.graph import Interaction
from ichain_drake.learning.tick import advance, effects_of
from ichain_drake.state import FloatArray

PUSH, WIND = Interaction("hand", "box"), Interaction("fan", "box")


class Status:
    """Active where the box is less than `reach` beyond the parent; what was active, half as far again."""

    def __init__(self, parent: str, reach: float) -> None:
        self.parent, self.reach = parent, reach

    def active(self, states: Any, previous: Any = None) -> np.ndarray:
        far = 1.0 + (0.5 * previous if previous is not None else 0.0)
        return np.asarray(np.abs(states["box"][:, 0] - states[self.parent][:, 0]) < self.reach * far)


class Passive:
    """It falls by 1 by itself, and not below the floor."""

    def __call__(self, state: FloatArray) -> FloatArray:
        return state - [0.0, 1.0]

    def settle(self, state: FloatArray, after: FloatArray) -> FloatArray:
        return np.maximum(after, [-np.inf, 0.0])


def effect(variable: int, change: Any) -> Any:
    """On one variable, from the parent's states and the child's."""
    return type("Effect", (), {"variable": variable, "__call__": lambda self, *states: change(*states)})()


def edges(reach: float = 1.0) -> dict[Interaction, Any]:
    push = effect(0, lambda p, q, c: q[:, 0] - p[:, 0])
    lift = effect(1, lambda p, q, c: np.full(len(c), 3.0))
    return {
        PUSH: SimpleNamespace(status=Status("hand", reach), effects=(push, lift)),
        WIND: SimpleNamespace(status=Status("fan", reach), effects=(effect(0, lambda p, q, c: np.full(len(c), 10.0)),)),
    }


def box(x: float, y: float, hand: float, hand_next: float | None = None, fan: float = 99.0, **more: Any) -> Any:
    """The box a tick later, and who acted."""
    rows = {"hand": np.array([[hand]]), "fan": np.array([[fan]]), "box": np.array([[x, y]])}
    after = {} if hand_next is None else {"hand": np.array([[hand_next]])}
    on: dict[Interaction, np.ndarray] = {}
    passive: Any = Passive()
    told = {k: {e: np.array([v]) for e, v in more.get(k, {}).items()} for k in ("forced", "before")}
    out = advance(edges(), (PUSH, WIND), passive, rows, after, told["forced"], told["before"], on)
    return out[0].tolist(), {e: bool(v[0]) for e, v in on.items()}


def test_alone_it_does_what_it_does_by_itself() -> None:
    assert box(0.0, 5.0, 50.0) == ([0.0, 4.0], {PUSH: False, WIND: False})
    assert box(0.0, 0.5, 50.0)[0] == [0.0, 0.0], "the floor is there"


def test_who_is_near_acts_by_where_it_goes() -> None:
    assert box(0.0, 5.0, 0.5, 0.9) == ([pytest.approx(0.4), 7.0], {PUSH: True, WIND: False})
    assert box(0.0, 5.0, 0.5) == ([0.0, 7.0], {PUSH: True, WIND: False}), "who is not known to move stays"
    assert box(0.0, 5.0, 4.0, 0.9)[1][PUSH], "who comes near in this tick acts in it"


def test_who_was_near_acts_once_more_unless_it_is_left_behind_by_that() -> None:
    """The box goes along with the hand, so that it is as near as before; the wind blows it away."""
    assert box(0.0, 5.0, 0.5, 7.0) == ([6.5, 7.0], {PUSH: True, WIND: False})
    assert box(0.0, 5.0, 99.0, fan=0.5) == ([0.0, 4.0], {PUSH: False, WIND: False})
    assert box(0.0, 5.0, 0.5, 0.9, fan=0.5) == ([0.0, 4.0], {PUSH: False, WIND: False}), "it takes both along"


def test_what_is_told_of_a_status_counts() -> None:
    assert box(0.0, 5.0, 50.0, 52.0, forced={PUSH: True}) == ([2.0, 7.0], {PUSH: True, WIND: False})
    assert box(0.0, 5.0, 0.5, 0.9, forced={PUSH: False, WIND: True}) == ([10.0, 4.0], {PUSH: False, WIND: True})
    assert box(0.0, 5.0, 1.2, before={PUSH: True}) == ([0.0, 7.0], {PUSH: True, WIND: False}), "a little further"
    assert box(0.0, 5.0, 1.6, before={PUSH: True}) == ([0.0, 4.0], {PUSH: False, WIND: False})
    assert box(0.0, 5.0, 0.5, 7.0, before={PUSH: False})[1][PUSH] is False


def test_effects_on_one_child_are_added_by_variable() -> None:
    out = effects_of(edges()[PUSH], np.array([[1.0]]), np.array([[1.5]]), np.zeros((1, 2)))
    np.testing.assert_allclose(out, [[0.5, 3.0]])
