"""The button: levels, edges of the press, stiffness, misreadings."""

import numpy as np
import pytest
from dispenser_scene import HAND, hand

from ichain_drake.errors import InputError
from ichain_drake.objects import Button, ButtonMount, ObjectSettings, check_object
from ichain_drake.state import StateSpace, Variable

TOP = (0.5, 0.18, 0.06)


def pressed(button: Button, height: float, state: np.ndarray | None = None) -> np.ndarray:
    """The button's state below a hand at a height."""
    state = button.default_state() if state is None else state
    parents = {"hand": hand(*TOP[:2], height, pitch=0.0, grip=1.0)}
    return np.array(button.settle(state, parents, button.decide_active(state, parents, {"hand": False}, None)))


def test_it_keeps_the_contract_of_a_world_object() -> None:
    check_object(Button("power", {"hand": HAND}))


@pytest.mark.parametrize("level", range(7))
def test_the_level_follows_the_height_of_the_hand(level: int) -> None:
    button = Button("power", {"hand": HAND}, mount=ButtonMount(TOP))
    assert pressed(button, button.mount.hand_height(level))[0] == level
    assert pressed(button, 0.02)[0] == 6


def test_a_stiff_button_divides_the_depression() -> None:
    stiff = Button("power", {"hand": HAND}, mount=ButtonMount(TOP, stiff=1.5))
    assert pressed(stiff, stiff.mount.hand_height(6))[0] == 4
    assert pressed(stiff, stiff.mount.hand_height(3))[0] == 2
    assert pressed(stiff, stiff.mount.hand_height(9))[0] == 6


def test_a_level_stays_near_the_threshold_where_it_is() -> None:
    button = Button("power", {"hand": HAND}, mount=ButtonMount(TOP))
    state = pressed(button, button.mount.hand_height(3))
    state = pressed(button, button.mount.hand_height(3.6), state)
    assert state[0] == 3
    state = pressed(button, button.mount.hand_height(3.7), state)
    assert state[0] == 4
    assert pressed(button, button.mount.hand_height(3.4), state)[0] == 4


def test_it_is_pressed_by_a_hand_over_it_that_points_down_with_hysteresis() -> None:
    button = Button("power", {"hand": HAND}, mount=ButtonMount(TOP))
    state, touch = button.default_state(), button.mount.touch_height

    def on(at: np.ndarray, before: bool = False) -> bool:
        return bool(button.decide_active(state, {"hand": at}, {"hand": before}, None)["hand"])

    for grip in (0.0, 1.0):
        assert on(hand(0.5, 0.18, touch, pitch=0.0, grip=grip))
    assert not on(hand(0.5, 0.18, touch + 0.003, pitch=0.0))
    assert on(hand(0.5, 0.18, touch + 0.003, pitch=0.0), before=True)
    assert not on(hand(0.5, 0.18, touch + 0.005, pitch=0.0), before=True)
    for axis in (0, 1):
        beside = hand(0.5, 0.18, touch, pitch=0.0)
        beside[axis] += 0.019
        assert (on(beside), on(beside, before=True)) == (False, True)
        beside[axis] += 0.002
        assert not on(beside, before=True)
    assert not on(hand(0.5, 0.18, touch))
    # With a body the force decides.
    assert button.decide_active(state, {"hand": hand(0.5, 0.18, 0.1, pitch=0.0)}, {"hand": False}, 0.4)["hand"]


@pytest.mark.parametrize("scale", [1.0, 3.0])
def test_now_and_then_a_reading_is_one_off(scale: float) -> None:
    button = Button("power", {"hand": HAND}, settings=ObjectSettings(noise_scale=scale))
    states = np.tile([3.0, 0.004], (20000, 1))
    read = button.measure(states, scale * np.random.default_rng(0).standard_normal((20000, 1)))
    assert set(np.unique(read)) == {2.0, 3.0, 4.0}
    assert (read != 3).mean() == pytest.approx(0.03 * scale, rel=0.1)


def test_the_body_gives_travel_and_the_level_follows() -> None:
    button = Button("power", {"hand": HAND}, settings=ObjectSettings(body_size=2))
    assert button.sample_body(np.array([-0.0061, 0.0])) == pytest.approx([0.0061])
    settled = button.settle(np.array([0.0, 0.0061]), {"hand": hand(0, 0, 1)}, {"hand": True})
    assert settled == pytest.approx([5, 0.0061])


def test_bad_input_is_refused() -> None:
    with pytest.raises(InputError, match="power: a button has one parent, the hand; 2 given"):
        Button("power", {"a": HAND, "b": HAND})
    with pytest.raises(InputError, match="power: its parent stick has no position along x"):
        Button("power", {"stick": StateSpace("stick", (Variable("turn"),))})
    with pytest.raises(InputError, match="travel, reach and stiff of a button are above 0"):
        Button("power", {"hand": HAND}, mount=ButtonMount(TOP, stiff=0.0))
