"""Whether what is known of an object that nothing acts on holds in new pieces."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ichain_drake.graph import Interaction
from ichain_drake.learning.agreement import _drifts, disagreements
from ichain_drake.learning.known import KnownParts
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


PUSH, WIND = Interaction("hand", "box"), Interaction("fan", "box")
BOX = StateSpace("box", (Variable("x", "m"), Variable("heat")))
STILL = 0.01 * np.sqrt(2.0)


class Stays:
    """A box that stays where it is, on this side of a wall."""

    space = BOX
    variables = [SimpleNamespace(kind="hold", std=0.0)] * 2

    def __call__(self, state: FloatArray) -> FloatArray:
        return state.copy()

    def settle(self, state: FloatArray, ahead: FloatArray) -> FloatArray:
        return np.minimum(ahead, [9.0, np.inf])


class Along:
    """An effect on where the box is: it goes along with its parent, by a share."""

    variable = 0
    regression = SimpleNamespace(std=0.0)

    def __init__(self, share: float = 1.0) -> None:
        self.share = share

    def __call__(self, parent: FloatArray, parent_next: FloatArray, child: FloatArray) -> FloatArray:
        return self.share * (parent_next - parent)[:, 0]


def interaction(share: float = 1.0, told: Any = None) -> Any:
    """One that its classifier takes for active where the hand is at more than 0, or as it is told."""
    decide = told or (lambda states: states["hand"][:, 0])
    return SimpleNamespace(status=SimpleNamespace(decide=decide), effects=(Along(share),))


def pushed(rows: int = 80, share: float = 1.0, blown: float = 0.0, start: float = 0.0) -> Any:
    """A box that goes along with a hand by a share, every other four rows, and is blown in the second half."""
    on = np.arange(rows) // 4 % 2 == 0
    wind = np.arange(rows) >= rows // 2
    hand = np.where(on, 1.0, -1.0) * (0.5 + 0.1 * (np.arange(rows) % 4))
    fan = 0.05 * np.arange(rows)
    box = [start]
    for k in range(1, rows):
        move = share * (hand[k] - hand[k - 1]) if on[k] and on[k - 1] else 0.0
        box.append(min(box[-1] + move + (blown if wind[k] and wind[k - 1] else 0.0), 9.0))
    states = {"hand": hand[:, None], "fan": fan[:, None], "box": np.column_stack([box, np.zeros(rows)])}
    piece = SimpleNamespace(states=states, flags={PUSH: on, WIND: wind})
    graph = SimpleNamespace(parents=lambda obj: ("hand", "fan"))
    return SimpleNamespace(
        pieces=[piece], incoming=lambda obj: (PUSH, WIND), graph=graph, spaces={"box": BOX},
        flag=lambda e: piece.flags[e], stacked=lambda obj: states[obj],
    )  # fmt: skip


def known(**edges: Any) -> KnownParts:
    """Of these interactions, by their parents, and of the box."""
    box: Any = SimpleNamespace(passive=Stays(), noise=np.full(2, 0.01))
    return KnownParts({Interaction(k, "box"): v for k, v in edges.items()}, {"box": box})


def test_what_goes_on_as_it_is_known_agrees() -> None:
    assert disagreements(pushed(), known(hand=interaction())) == {}


def test_a_status_that_is_told_badly_disagrees_where_enough_of_it_is_shown() -> None:
    wrong = interaction(told=lambda states: -states["hand"][:, 0])
    found = disagreements(pushed(), known(hand=wrong))
    assert found == {PUSH: "its status is told with F1 0.00 in the 40 rows in which it is active here"}
    assert disagreements(pushed(rows=24), known(hand=wrong)) != {}, "12 rows are enough"
    assert disagreements(pushed(rows=16), known(hand=wrong)) == {}
    for share, agrees in ((0.79, False), (0.81, True)):  # of its rows all are told, and others for each
        extra = round(80 / share - 80)
        some = interaction(
            told=lambda s, n=extra: np.where((s["hand"][:, 0] > 0) | (np.cumsum(s["hand"][:, 0] < 0) <= n), 1.0, -1.0)
        )
        assert (disagreements(pushed(), known(hand=some)) == {}) is agrees


@pytest.mark.parametrize(("share", "agrees"), [(1.0, True), (0.6, True), (0.4, False), (-1.0, False)])
def test_an_effect_that_leaves_most_of_the_motion_disagrees(share: float, agrees: bool) -> None:
    """Here the box goes along with the hand: of what is known less than half of it must be left."""
    found = disagreements(pushed(), known(hand=interaction(share)))
    if agrees:
        assert found == {}
        return
    off, moved = abs(1.0 - share) * 0.1, 0.1
    assert found == {PUSH: f"what it does to box.x is off by {off:.3g} of {moved:.3g} a tick here"}


def test_what_noise_leaves_of_a_small_motion_is_none() -> None:
    for scale, agrees in ((0.9, True), (1.1, False)):
        share = scale * LEARNING.clear * STILL / 0.1
        assert (disagreements(pushed(share=share), known(hand=interaction(0.0))) == {}) is agrees


def test_ticks_in_which_others_act_count_where_they_are_known() -> None:
    """The wind is far stronger than the hand."""
    blown = pushed(blown=3.0, start=-150.0)
    assert disagreements(blown, known(hand=interaction())) == {}, "of an unknown wind's ticks nothing is said"
    wind = interaction(told=lambda states: np.where(np.arange(80) >= 40, 1.0, -1.0))

    class Blows(Along):
        def __call__(self, parent: FloatArray, parent_next: FloatArray, child: FloatArray) -> FloatArray:
            return np.full(len(child), 3.0)

    wind.effects = (Blows(),)
    assert disagreements(blown, known(hand=interaction(), fan=wind)) == {}
    assert set(disagreements(blown, known(hand=interaction(-1.0), fan=wind))) == {PUSH}
    calm = pushed()
    assert WIND in disagreements(calm, known(hand=interaction(), fan=wind)), "there is none here"


def test_at_a_bound_an_effect_may_be_without_effect() -> None:
    """It would go on, but for the wall."""
    assert disagreements(pushed(share=0.0, start=9.0), known(hand=interaction(5.0))) == {}
    assert set(disagreements(pushed(share=0.0, start=0.0), known(hand=interaction(5.0)))) == {PUSH}


def test_where_an_object_moves_by_itself_in_another_way_all_that_is_known_to_act_on_it_is_in_doubt() -> None:
    drifting = pushed(blown=0.0)
    drifting.pieces[0].states["box"][:, 1] = 0.5 * np.arange(80)
    found = disagreements(drifting, known(hand=interaction(), fan=interaction()))
    said = "left alone, box.heat changes by 0.5 a tick more than is known of it"
    assert found == {PUSH: said, WIND: said}
