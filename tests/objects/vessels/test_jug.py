"""The jug: held by its rim by one of two hands, it pours what its tilt does not hold."""

import math

import numpy as np
import pytest

from ichain_drake.errors import InputError
from ichain_drake.objects import Jug, JugSettings, check_object
from ichain_drake.robot import HandSpec
from ichain_drake.timing import FRAME

HAND = HandSpec(["y", "z", "roll", "grip"], {"x": 0.6}).space
AWAY = np.array([9.0, 9.0, 0.0, 0.0])


def jug(slips: tuple[float, ...] = ()) -> Jug:
    return Jug("jug", {"a": HAND, "b": HAND}, jug=JugSettings(blocks=((-0.1, 0.1, 0.18),), slips=slips))


def advance(made: Jug, state: np.ndarray, a: np.ndarray, b: np.ndarray = AWAY) -> tuple[np.ndarray, dict[str, bool]]:
    """One frame."""
    parents = {"a": a, "b": b}
    held = {h: bool(state[made.state_space.index(f"held_{h}")]) for h in parents}
    active = dict(made.decide_active(state, parents, held, None))
    settled = made.settle(state, parents, active)
    return made.step(settled, parents, {h: np.float64(v) for h, v in active.items()}, np.zeros(0), FRAME), active  # type: ignore[arg-type]


def test_it_keeps_the_contract_of_a_world_object() -> None:
    check_object(jug())


def test_it_goes_with_the_hand_that_took_it_as_it_was_taken() -> None:
    made = jug()
    state, active = advance(made, made.state_at(0.3, 0.5), np.array([0.31, 0.115, 0.0, 1.0]))
    assert active == {"a": True, "b": False}
    state, active = advance(made, state, np.array([0.01, 0.315, -0.2, 1.0]))
    assert active["a"]
    np.testing.assert_allclose(state[:3], [0.0, 0.32, -0.2], atol=1e-12)
    state, active = advance(made, state, np.array([0.01, 0.315, -0.2, 0.0]))
    assert not any(active.values())
    np.testing.assert_allclose(state[:3], [0.0, 0.18 + 0.12, 0.0], atol=1e-12)  # on the block, upright


def test_what_is_let_go_of_beside_the_block_stands_on_the_table() -> None:
    made = jug()
    state = made.state_at(0.3, 0.5, "b", 0.4)
    state, active = advance(made, state, AWAY, np.array([0.3, 0.4, 0.0, 0.0]))
    assert not any(active.values())
    assert state[1] == pytest.approx(0.12)


def test_the_table_stops_it() -> None:
    made = jug()
    state, _ = advance(made, made.state_at(0.3, 0.5, "a"), np.array([0.3, 0.12, 0.0, 1.0]))
    state, _ = advance(made, state, np.array([0.3, 0.05, 0.0, 1.0]))
    assert state[1] == pytest.approx(0.12)


@pytest.mark.parametrize(("tilt", "left"), [(0.2, 0.8), (-1.05, 0.5), (1.05, 0.5), (-1.9, 0.0)])
def test_it_pours_what_its_tilt_does_not_hold_and_nothing_is_lost(tilt: float, left: float) -> None:
    made, flow = jug(), 0.0
    state = made.state_at(0.0, 0.8, "a", 0.4)
    state[2] = tilt
    for _ in range(150):
        state, _ = advance(made, state, np.array([0.0, 0.4, tilt, 1.0]))
        state[2] = tilt
        flow += state[made.state_space.index("flow")]
    water = state[3]
    assert water == pytest.approx(left, abs=2e-3)
    assert water + flow == pytest.approx(0.8, abs=1e-12)


def test_change_is_over_one_tick() -> None:
    made = jug()
    state, amounts = made.state_at(0.0, 0.9, "a", 0.4), [0.9]
    for _ in range(25):
        state, _ = advance(made, state, np.array([0.0, 0.4, -1.2, 1.0]))
        state[2] = -1.2
        amounts.append(state[3])
    assert state[4] == pytest.approx(amounts[-1] - amounts[-11], abs=1e-12)


def test_a_slip_waits_until_it_is_in_the_air_and_happens_once() -> None:
    made = jug((0.05,))
    state, hand = made.state_at(0.3, 0.5), np.array([0.3, 0.12, 0.0, 1.0])
    for _ in range(4):
        state, active = advance(made, state, hand)
    assert active["a"], "it stands"
    up = np.array([0.3, 0.25, 0.0, 1.0])
    state, _ = advance(made, state, up)
    state, active = advance(made, state, up)
    assert not active["a"]
    assert state[1] == pytest.approx(0.12)
    state, active = advance(made, state, np.array([0.3, 0.12, 0.0, 1.0]))
    assert not active["a"], "the hand has to open first"
    state, _ = advance(made, state, np.array([0.3, 0.12, 0.0, 0.0]))
    state, active = advance(made, state, np.array([0.3, 0.12, 0.0, 1.0]))
    assert active["a"]
    for _ in range(4):
        state, active = advance(made, state, up)
    assert active["a"]


def test_steps_of_a_batch_are_steps_of_its_rows() -> None:
    made, rng = jug(), np.random.default_rng(0)
    rows = np.array([made.state_at(y, w, h, 0.3) for y, w, h in [(0.0, 0.2, "a"), (0.3, 0.9, ""), (-0.3, 0.5, "b")]])
    hands = {h: np.column_stack([rng.uniform(-0.3, 0.3, (3, 2)), rng.uniform(-1, 1, 3), [1.0, 0.0, 1.0]]) for h in "ab"}
    active = {h: (rows[:, made.state_space.index(f"held_{h}")] > 0.5).astype(float) for h in "ab"}
    whole = made.step(made.settle(rows, hands, active), hands, active, np.zeros((3, 0)), FRAME)  # type: ignore[arg-type]
    for k in range(3):
        hand, on = ({h: v[k] for h, v in part.items()} for part in (hands, active))
        single = made.step(made.settle(rows[k], hand, on), hand, on, np.zeros(0), FRAME)
        np.testing.assert_array_equal(whole[k], single)


def test_readings_stay_within_what_can_be() -> None:
    made = jug()
    state = made.state_at(0.0, 0.0)
    state[2] = math.pi - 1e-6
    read = made.measure(state, np.array([0.0, 0.0, 1.0, -5.0, 0.0]))
    assert -math.pi <= read[2] < -3.0
    assert read[3] == 0.0


@pytest.mark.parametrize("water", [-0.1, 1.1])
def test_an_amount_that_can_not_be_is_refused(water: float) -> None:
    with pytest.raises(InputError, match="jug: amount .* given; it is between 0 and 1"):
        jug().state_at(0.0, water)


def test_a_hand_that_can_not_be_turned_is_refused() -> None:
    with pytest.raises(InputError, match="its parent a can't be turned about x"):
        Jug("jug", {"a": HandSpec(["y", "z", "grip"], {"x": 0.6}).space})
