"""The cup: grasp, pouring, catching, conservation, faults."""

import numpy as np
import pytest
from dispenser_scene import FORWARD, HAND, DispenserLoop, hand
from hypothesis import given, settings
from hypothesis import strategies as st

from ichain_drake.errors import InputError
from ichain_drake.objects import Button, CameraFrame, Cup, CupFaults, CupSettings, Region, Tank, check_object
from ichain_drake.robot import HandSpec
from ichain_drake.robot.pose import hand_rotation
from ichain_drake.state import wrap_angle

PARENTS = {"hand": HAND, "tank": Tank.state_space}
CAMERA = CameraFrame(0.6, (0.03, -0.02, -0.05))


def grasped(loop: DispenserLoop, water: float = 0.8, at: tuple[float, float] = (0.6, -0.2)) -> np.ndarray:
    """A cup on the table, closed around; returns the hand."""
    loop.place((*at, 0.10), water, 0.1)
    loop.frame(hand(*at, 0.06))
    closed = hand(*at, 0.06, grip=1.0)
    loop.run(closed, 2)
    assert loop.active["cup"]["hand"]
    return closed


def rim(loop: DispenserLoop) -> np.ndarray:
    return loop.cup.cup.camera.to_robot(loop.states["cup"][:3])


def test_it_keeps_the_contract_of_a_world_object() -> None:
    check_object(Cup("cup", PARENTS))


def test_settling_a_batch_is_settling_row_by_row() -> None:
    cup = Cup("cup", PARENTS, cup=CupSettings(camera=CAMERA))
    rng = np.random.default_rng(1)
    states = np.tile(cup.state_at((0.6, -0.2, 0.3), 0.5, 0.3), (2, 3, 1))
    states[..., 8] = rng.integers(0, 2, (2, 3))
    states[..., 9:15] = rng.normal(0, 0.1, (2, 3, 6)) + [0, 0, 0.05, 0.5, 0, 0.8]
    hands = hand(0.6, -0.2, 0.3) + rng.normal(0, 0.05, (2, 3, 6))
    tanks = np.zeros((2, 3, len(Tank.state_space)))
    on = {"hand": rng.integers(0, 2, (2, 3)).astype(float), "tank": rng.integers(0, 2, (2, 3)).astype(float)}
    settled = cup.settle(states, {"hand": hands, "tank": tanks}, on)
    for index in np.ndindex(2, 3):
        parents = {"hand": hands[index], "tank": tanks[index]}
        row = cup.settle(states[index], parents, {p: v[index] for p, v in on.items()})
        np.testing.assert_allclose(row, settled[index], atol=1e-14)


@given(st.floats(-2.2, 2.2), st.floats(0.6, 2.4), st.floats(0.5, 0.7), st.floats(0.25, 0.4))
@settings(max_examples=40, deadline=None)
def test_a_held_cup_moves_with_the_hand_as_one_body(roll: float, pitch: float, x: float, z: float) -> None:
    loop = DispenserLoop(CAMERA)
    closed = grasped(loop, water=0.0)
    moved = hand(x, -0.1, z, roll, pitch, 1.0)
    loop.frame(moved)
    before, after = hand_rotation(0, FORWARD, 0), hand_rotation(0, pitch, roll)
    turn = after @ before.T
    np.testing.assert_allclose(rim(loop), moved[:3] + turn @ (np.array([0.6, -0.2, 0.10]) - closed[:3]), atol=1e-12)
    axis = turn[:, 2]
    assert wrap_angle(loop.value("cup", "tilt") - np.arctan2(-axis[1], axis[2])) == pytest.approx(0.0, abs=1e-9)
    assert loop.value("cup", "lean") == pytest.approx(np.arcsin(axis[0]), abs=1e-9)


@pytest.mark.parametrize(
    ("offset", "pitch", "expected"),
    [
        ((0.0, 0.0, 0.0), FORWARD, True),
        ((0.014, -0.014, 0.024), FORWARD, True),
        ((0.017, 0.0, 0.0), FORWARD, False),
        ((0.0, 0.017, 0.0), FORWARD, False),
        ((0.0, 0.0, 0.027), FORWARD, False),
        ((0.0, 0.0, 0.0), 0.0, False),
    ],
)
def test_the_hand_grasps_by_closing_around_the_cup(
    offset: tuple[float, float, float], pitch: float, expected: bool
) -> None:
    loop = DispenserLoop(CAMERA)
    loop.place((0.6, -0.2, 0.10), 0.5, 0.1)
    at = np.array([0.6, -0.2, 0.06]) + offset
    loop.frame(hand(*at, pitch=pitch))
    loop.frame(hand(*at, pitch=pitch, grip=1.0))
    assert loop.active["cup"]["hand"] is expected


def test_a_closed_hand_that_comes_near_does_not_grasp_and_an_open_one_lets_go() -> None:
    loop = DispenserLoop()
    loop.place((0.6, -0.2, 0.10), 0.5, 0.1)
    loop.run(hand(0.5, -0.2, 0.06, grip=1.0), 3)
    loop.run(hand(0.6, -0.2, 0.06, grip=1.0), 3)
    assert not loop.active["cup"]["hand"]
    loop = DispenserLoop()
    closed = grasped(loop)
    closed[2] = 0.3
    loop.frame(closed)
    assert rim(loop)[2] == pytest.approx(0.34)
    closed[5] = 0.0
    loop.frame(closed)
    assert not loop.active["cup"]["hand"]
    np.testing.assert_allclose(rim(loop), [0.6, -0.2, 0.10], atol=1e-12)
    assert loop.value("cup", "water") == 0.8


def test_a_cup_let_go_over_the_tray_stands_on_it() -> None:
    loop = DispenserLoop()
    closed = grasped(loop)
    closed[:3] = 0.68, 0.06, 0.09
    loop.frame(closed)
    loop.frame(closed * [1, 1, 1, 1, 1, 0])
    np.testing.assert_allclose(rim(loop), [0.68, 0.06, 0.11], atol=1e-12)
    loop.frame(closed * [1, 1, 1, 1, 1, 0])
    assert loop.active["cup"] == {"hand": False, "tank": True}


def test_it_pours_what_its_tilt_does_not_hold() -> None:
    loop = DispenserLoop()
    closed = grasped(loop)
    closed[2:4] = 0.3, -0.25
    loop.run(closed, 60)
    assert loop.value("cup", "water") == 0.8
    closed[3] = -0.3 - 0.75
    loop.run(closed, 150)
    assert loop.value("cup", "water") == pytest.approx(0.5, abs=1e-3)
    closed[3] = 1.9
    loop.run(closed, 300)
    assert loop.value("cup", "water") < 1e-3
    assert loop.value("cup", "spilled") == pytest.approx(0.8, abs=1e-3)
    assert loop.water() == pytest.approx(0.8, abs=1e-12)


def test_let_go_while_tilted_it_spills_all() -> None:
    loop = DispenserLoop()
    closed = grasped(loop)
    closed[2:4] = 0.3, -0.4
    loop.frame(closed)
    closed[5] = 0.0
    loop.frame(closed)
    assert loop.value("cup", "water") == 0.0
    assert loop.value("cup", "tilt") == 0.0
    assert loop.water() == pytest.approx(0.8, abs=1e-12)


def test_change_is_over_one_tick() -> None:
    loop = DispenserLoop()
    closed = grasped(loop)
    closed[2:4] = 0.3, -1.9
    amounts = [0.8] * 10
    for _ in range(25):
        loop.frame(closed)
        amounts.append(loop.value("cup", "water"))
        assert loop.value("cup", "change") == pytest.approx(amounts[-1] - amounts[-11], abs=1e-12)


def test_it_catches_what_the_tank_lets_out_and_a_full_one_runs_over() -> None:
    loop = DispenserLoop()
    loop.place((0.68, 0.06, 0.11), 0.4, 0.1)
    loop.fill(0.9, 0.9)
    loop.run(hand(0.5, 0.26, 0.062, pitch=0.0, grip=1.0), 16 * 30)
    assert loop.value("cup", "water") == pytest.approx(1.0, abs=1e-12)
    assert loop.value("tank", "spilled") == pytest.approx(0.3, abs=3e-3)
    assert loop.value("cup", "temperature") == pytest.approx((0.4 * 0.1 + 0.6 * 0.9) / 1.0, abs=1e-3)
    assert loop.water() == pytest.approx(1.3, abs=1e-12)


def test_a_cup_of_two_tanks_takes_from_the_one_it_stands_under_and_pours_into_the_one_below_it() -> None:
    names = ("left", "right")
    outlets = {"left": Region((0.6, 0.2, 0.11), (0.02,) * 3), "right": Region((0.6, -0.2, 0.11), (0.02,) * 3)}
    tank_space = Tank.space(["cup"])
    cup = Cup("cup", {"hand": HAND} | dict.fromkeys(names, tank_space), cup=CupSettings(outlets=outlets))
    state = cup.state_at((0.6, -0.2, 0.11), 0.2, 0.1)
    tanks = {n: np.zeros(len(tank_space)) for n in names}
    for tank, flow in zip(tanks.values(), (0.01, 0.02), strict=True):
        tank[tank_space.index("flow")] = flow
    parents = {"hand": hand(0, 0, 0.3)} | tanks
    modes = cup.decide_active(state, parents, dict.fromkeys(cup.parents, False), None)
    assert modes == {"hand": False, "left": False, "right": True}
    stepped = cup.step(cup.settle(state, parents, modes), parents, modes, np.zeros(0), 1 / 30)
    assert stepped[4] == pytest.approx(0.22)
    # What it gave itself is spilled but for what one of the two takes.
    state[cup.state_space.index("flow")] = 0.03
    tanks["left"][tank_space.index("from_cup")] = 1.0
    tanks["left"][0] = 0.99
    stepped = cup.step(cup.settle(state, parents, modes), parents, modes, np.zeros(0), 1 / 30)
    assert stepped[cup.state_space.index("spilled")] == pytest.approx(0.02)


moves = st.tuples(
    st.sampled_from(["cup", "inlet", "outlet", "power", "dispense", "air"]),
    st.floats(-2.2, 2.2),
    st.booleans(),
    st.integers(1, 25),
)


@given(st.lists(moves, min_size=5, max_size=25), st.floats(0, 1), st.floats(0, 1), st.floats(0, 1), st.floats(0, 1))
@settings(max_examples=40, deadline=None)
def test_water_and_heat_are_conserved_whatever_the_hand_does(
    sequence: list[tuple[str, float, bool, int]], water: float, cold: float, amount: float, hot: float
) -> None:
    faults = CupFaults(slips=(1.5, 3.0), knocks=((1.0, 0.02, 0.0),))
    loop = DispenserLoop(CAMERA, faults)
    loop.place((0.68, 0.06, 0.11), water, cold)
    loop.fill(amount, hot)
    all_water, all_heat = loop.water(), loop.heat()
    places = {"inlet": (0.68, 0.06, 0.37), "outlet": (0.68, 0.06, 0.07), "air": (0.5, -0.1, 0.3)}
    for place, roll, closed, frames in sequence:
        if place in ("power", "dispense"):
            now = hand(0.5, 0.18 if place == "power" else 0.26, 0.0625, pitch=0.0, grip=float(closed))
        elif place == "cup":
            loop.frame(hand(*(rim(loop) - [0, 0, 0.04])))
            now = hand(*(rim(loop) - [0, 0, 0.04]), grip=1.0)
        else:
            now = hand(*places[place], roll=roll, grip=float(closed))
        for _ in range(frames):
            loop.frame(now)
            assert loop.water() == pytest.approx(all_water, abs=1e-9)
            assert loop.heat() == pytest.approx(all_heat, abs=1e-9)


def test_a_slip_waits_until_the_cup_is_in_the_air_and_happens_once() -> None:
    loop = DispenserLoop(faults=CupFaults(slips=(0.2,)))
    closed = grasped(loop)
    loop.run(closed, 30)
    assert loop.active["cup"]["hand"]
    closed[2] = 0.3
    loop.run(closed, 3)
    assert not loop.active["cup"]["hand"]
    assert rim(loop)[2] == pytest.approx(0.10)
    # Only a hand that opens and closes anew gets it back.
    loop.run(hand(0.6, -0.2, 0.06, grip=1.0), 3)
    assert not loop.active["cup"]["hand"]
    loop.run(hand(0.6, -0.2, 0.06), 2)
    loop.run(hand(0.6, -0.2, 0.06, grip=1.0), 2)
    loop.run(hand(0.6, -0.2, 0.3, grip=1.0), 30)
    assert loop.active["cup"]["hand"]
    assert loop.value("cup", "slips_done") == 1


def test_a_knock_displaces_a_standing_cup_once() -> None:
    loop = DispenserLoop(CAMERA, CupFaults(knocks=((0.5, 0.03, -0.02),)))
    loop.place((0.6, -0.2, 0.10), 0.5, 0.1)
    away = hand(0.4, 0.0, 0.3)
    loop.run(away, 14)
    np.testing.assert_allclose(rim(loop), [0.6, -0.2, 0.10], atol=1e-12)
    loop.run(away, 30)
    np.testing.assert_allclose(rim(loop), [0.63, -0.22, 0.10], atol=1e-12)


@given(st.floats(-1.4, 1.4), st.floats(-1.2, 1.2), st.floats(-3, 3))
def test_rim_and_tilt_are_read_off_the_free_body(tilt: float, lean: float, spin: float) -> None:
    from pydrake.math import RotationMatrix

    cup = Cup("cup", PARENTS, cup=CupSettings(camera=CAMERA))
    turn = RotationMatrix.MakeXRotation(tilt) @ RotationMatrix.MakeYRotation(lean) @ RotationMatrix.MakeZRotation(spin)
    body = np.concatenate([turn.ToQuaternion().wxyz(), [0.6, 0.1, 0.2], np.zeros(6)])
    sampled = cup.sample_body(body)
    np.testing.assert_allclose(CAMERA.to_robot(sampled[:3]), [0.6, 0.1, 0.2] + turn.matrix() @ [0, 0, 0.1], atol=1e-9)
    np.testing.assert_allclose(sampled[3:], [tilt, lean], atol=1e-9)


def test_the_camera_turns_points_and_turns_them_back() -> None:
    point = np.array([[0.3, 0.1, 0.2], [-0.2, 0.5, 0.0]])
    np.testing.assert_allclose(CAMERA.to_robot(CAMERA.from_robot(point)), point, atol=1e-15)
    turned = CameraFrame(np.pi / 2, (0, 0, 1)).from_robot(np.array([1.0, 0, 0]))
    np.testing.assert_allclose(turned, [0, 1, 1], atol=1e-15)


def test_parents_that_do_not_fit_are_refused() -> None:
    with pytest.raises(InputError, match="cup: a cup has one hand among its parents; 2 given"):
        Cup("cup", {"a": HAND, "b": HAND})
    with pytest.raises(InputError, match="cup: its parent hand has no grip"):
        Cup("cup", {"hand": HandSpec(["x", "y", "z"]).space})
    with pytest.raises(InputError, match="cup: no outlet is given for its parent boiler"):
        Cup("cup", {"hand": HAND, "boiler": Tank.state_space})
    with pytest.raises(InputError, match="mug: its parent tank has no hidden variable from_mug"):
        Cup("mug", PARENTS)
    with pytest.raises(InputError, match="a cup has one hand among its parents; 2 given"):
        Cup("cup", PARENTS | {"button": Button.state_space})
