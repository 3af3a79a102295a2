"""Whether what is known of an object that nothing acts on holds in new pieces."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ichain_drake.graph import Interaction
from ichain_drake.learning.agreement import _drifts
from ichain_drake.learning.settings import LEARNING
from ichain_drake.state import FloatArray, StateSpace, Variable

HIT, SHADE = Interaction("hand", "lamp"), Interaction("blind", "lamp")
NOISE = np.full(3, 0.01)
LIMIT = LEARNING.clear * np.sqrt(2.0) * 0.01


class Halved:
    """A lamp of which half of the light goes in a tick; its angle stays; the third says how the light changed."""

    space = StateSpace("lamp", (Variable("light"), Variable("turn", "rad", kind="angle"), Variable("change")))

    def __init__(self, std: float = 0.0) -> None:
        self.variables = [SimpleNamespace(kind=k, std=std) for k in ("learned", "hold", "change")]

    def __call__(self, state: FloatArray) -> FloatArray:
        return state * [0.5, 1.0, 0.0]

    def settle(self, state: FloatArray, ahead: FloatArray) -> FloatArray:
        return np.maximum(ahead, [0.0, -np.inf, -np.inf])


def data(rows: int, off: float = 0.0, turned: float = 0.0, *, hit: float = 0.0, change: float = 0.0) -> Any:
    """A lamp left alone for so many ticks, by more than is known in each of them; then something acts on it."""
    light, turn = [1.0], [3.0]
    for _ in range(rows):
        light.append(0.5 * light[-1] + off)
        turn.append(turn[-1] + turned)
    for _ in range(20):
        light.append(0.5 * light[-1] + hit)
        turn.append(turn[-1])
    turns = (np.array(turn) + np.pi) % (2 * np.pi) - np.pi
    states = np.column_stack([light, turns, change * np.arange(len(light))])
    alone = np.arange(len(light)) <= rows
    flags = {HIT: ~alone & (np.arange(len(light)) % 2 == 0), SHADE: ~alone}
    return SimpleNamespace(
        pieces=[SimpleNamespace(states={"lamp": states}, flags=flags)], incoming=lambda obj: (HIT, SHADE)
    )


def test_by_more_than_noise_makes_of_it_a_change_is_another_one() -> None:
    known: Any = Halved()
    assert _drifts(data(30), "lamp", known, NOISE) == ""
    assert _drifts(data(30, 0.9 * LIMIT), "lamp", known, NOISE) == ""
    said = f"left alone, lamp.light changes by {1.1 * LIMIT:.3g} a tick more than is known of it"
    assert _drifts(data(30, 1.1 * LIMIT), "lamp", known, NOISE) == said
    assert _drifts(data(30, 1.1 * LIMIT), "lamp", Halved(std=0.02), NOISE) == ""  # type: ignore[arg-type]
    assert _drifts(data(30, turned=0.1), "lamp", known, NOISE).startswith("left alone, lamp.turn changes by 0.1 a tick")


@pytest.mark.parametrize("rows", [2 * LEARNING.rows - 1, 2 * LEARNING.rows])
def test_what_was_hardly_left_alone_is_taken_on_trust(rows: int) -> None:
    assert bool(_drifts(data(rows, 1.0), "lamp", Halved(), NOISE)) is (rows >= 2 * LEARNING.rows)  # type: ignore[arg-type]


def test_nothing_is_said_of_ticks_in_which_something_acts_nor_of_what_follows_from_others() -> None:
    assert _drifts(data(30, hit=0.5), "lamp", Halved(), NOISE) == ""  # type: ignore[arg-type]
    assert _drifts(data(30, change=0.5), "lamp", Halved(), NOISE) == ""  # type: ignore[arg-type]
