"""Food and the parts of an oven: who moves what, where, and what heats when."""

import dataclasses
import math

import numpy as np
import pytest

from ichain_drake.errors import InputError
from ichain_drake.objects import check_object
from ichain_drake.objects.camera import CameraFrame
from ichain_drake.objects.parts.food import Food, FoodSettings, OvenSettings
from ichain_drake.objects.parts.oven_part import Dial, OvenPart, PartMount, SlidingPart
from ichain_drake.objects.vessels.cup_settings import CupFaults
from ichain_drake.robot import HandSpec
from ichain_drake.state import FloatArray, StateSpace

HAND = HandSpec(exposed=["x", "y", "z", "roll", "grip"], held={"yaw": 0.0, "pitch": math.pi / 2}).space
DOOR = PartMount((0.6, 0.0, 0.14), 0.2, "y")
BUTTON = PartMount((0.64, -0.13, 0.08), 0.012, "x")
KNOB = PartMount((0.65, -0.13, 0.17), 1.75, "x")
CAMERA = CameraFrame(0.3, (0.03, -0.02, -0.05))
SHUT, OPEN, OUT, IN = 0.0, 0.2, 0.0, 0.012
INSIDE, OUTSIDE = (0.76, 0.045, 0.07), (0.63, -0.28, 0.04)


def hand(place: tuple[float, ...], roll: float = 0.0, grip: float = 0.0) -> FloatArray:
    return np.array([*place, roll, grip])


def move(part: OvenPart, state: FloatArray, way: list[FloatArray]) -> tuple[FloatArray, bool]:
    """The state once a hand went a way, frame by frame, and whether it holds the part then."""
    active = {"hand": False}
    for at in way:
        parents = {"hand": at}
        active = dict(part.decide_active(state, parents, active, None))
        state = np.array(part.settle(state, parents, active))
        state = part.step(state, parents, {"hand": np.float64(active["hand"])}, np.zeros(0), 1 / 30)
    return state, active["hand"]


def food(settings: FoodSettings | None = None) -> Food:
    parents = {
        "hand": HAND,
        "knob": Dial.make_space(KNOB),
        "button": SlidingPart.make_space(BUTTON),
        "door": SlidingPart.make_space(DOOR),
    }
    return Food("food", parents, food=settings or FoodSettings(camera=CAMERA))


def around(thing: Food, at: FloatArray, door: float, button: float, angle: float = 1.0) -> dict[str, FloatArray]:
    """States of the food's parents."""
    parts = {
        "door": SlidingPart("door", {"hand": HAND}, DOOR).state_at(door),
        "button": SlidingPart("button", {"hand": HAND}, BUTTON).state_at(button),
        "knob": Dial("knob", {"hand": HAND}, KNOB).state_at(angle),
    }
    return {"hand": at, **parts}


def test_they_keep_the_contract_of_a_world_object() -> None:
    check_object(SlidingPart("door", {"hand": HAND}, DOOR))
    check_object(Dial("knob", {"hand": HAND}, KNOB))
    check_object(food())


@pytest.mark.parametrize("mount", [DOOR, BUTTON])
def test_a_sliding_part_follows_along_its_axis_and_stays_where_it_is_let_go(mount: PartMount) -> None:
    part = SlidingPart("part", {"hand": HAND}, mount)
    axis = "xyz".index(mount.axis)
    start = np.array(mount.point) + [0.004, -0.004, 0.003]
    goal = start + 0.01
    taken, held = move(part, part.state_at(0.0), [hand(start), hand(start, grip=1.0), hand(goal, grip=1.0)])
    assert held
    expected = np.zeros(3)
    expected[axis] = 0.01
    np.testing.assert_allclose(taken[:3], expected, atol=1e-12)
    left, held = move(part, taken, [hand(goal, grip=0.0), hand(start, grip=0.0)])
    assert not held
    np.testing.assert_allclose(left[:3], expected, atol=1e-12)
    # Its grasping point went along: it is taken anew there, and no more where it was.
    assert np.allclose(part.grasp_point(0.01), np.array(mount.point) + expected)


def test_beyond_its_ends_the_hand_slips_along() -> None:
    part = SlidingPart("door", {"hand": HAND}, DOOR)
    x, y, z = DOOR.point
    way = [hand((x, y, z)), hand((x, y, z), grip=1.0), hand((x, 0.25, z), grip=1.0)]
    end, held = move(part, part.state_at(0.0), way)
    assert (held, end[1]) == (True, 0.2)
    back, _ = move(part, part.state_at(0.0), [*way, hand((x, 0.20, z), grip=1.0)])
    assert back[1] == pytest.approx(0.15)


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_only_a_hand_that_closes_near_its_grasping_point_takes_it(axis: int, sign: float) -> None:
    part = SlidingPart("door", {"hand": HAND}, DOOR)
    state = part.state_at(0.1)
    for share, expected in ((0.9, True), (1.1, False)):
        at = np.array(part.grasp_point(0.1))
        at[axis] += sign * share * DOOR.reach[axis]
        assert move(part, state, [hand(at), hand(at, grip=1.0)])[1] is expected
        closed_before = [hand((0.4, 0.0, 0.2), grip=1.0), hand(at, grip=1.0)]
        assert move(part, state, closed_before)[1] is False


def test_a_dial_turns_with_the_hands_roll_also_where_that_wraps() -> None:
    dial = Dial("knob", {"hand": HAND}, KNOB)
    for start in (0.0, -3.0):
        rolls = [start, start - 0.4, start - 0.8]
        wrapped = [(r + math.pi) % (2 * math.pi) - math.pi for r in rolls]
        way = [hand(KNOB.point, wrapped[0]), *(hand(KNOB.point, r, 1.0) for r in wrapped)]
        turned, held = move(dial, dial.state_at(0.1), way)
        assert held
        assert turned[3] == pytest.approx(0.9)
    back = [hand(KNOB.point), hand(KNOB.point, 0.0, 1.0), hand(KNOB.point, 1.0, 1.0)]
    assert move(dial, dial.state_at(0.1), back)[0][3] == 0


@pytest.mark.parametrize("inside", [False, True])
@pytest.mark.parametrize("door", [SHUT, OPEN])
@pytest.mark.parametrize("button", [OUT, IN])
def test_it_heats_only_inside_with_the_door_shut_and_the_button_in(inside: bool, door: float, button: float) -> None:
    thing = food()
    state = thing.state_at(INSIDE if inside else OUTSIDE, 0.2)
    parents = around(thing, hand((0.5, 0.0, 0.2)), door, button)
    active = thing.decide_active(state, parents, dict.fromkeys(parents, False), None)
    heats = inside and door == SHUT and button == IN
    assert active == {"hand": False, "door": inside, "button": heats, "knob": heats}
    later = thing.step(state, parents, {p: np.float64(on) for p, on in active.items()}, np.zeros(0), 1.0)
    assert later[3] - state[3] == pytest.approx(OvenSettings.rate if heats else 0.0)


def test_the_dial_sets_how_fast_it_heats_and_hot_is_hot() -> None:
    thing = food()
    on = {"hand": np.float64(0), "door": np.float64(1), "button": np.float64(1), "knob": np.float64(1)}
    for angle in (0.0, 0.5, 1.75):
        parents = around(thing, hand((0.5, 0.0, 0.2)), SHUT, IN, angle)
        later = thing.step(thing.state_at(INSIDE, 0.2), parents, on, np.zeros(0), 2.0)
        assert later[3] == pytest.approx(0.2 + 2.0 * OvenSettings.rate * angle)
        assert thing.step(thing.state_at(INSIDE, 0.999), parents, on, np.zeros(0), 2.0)[3] <= 1.0


@pytest.mark.parametrize(
    ("place", "door", "taken"),
    [
        (INSIDE, OPEN, True),
        (INSIDE, SHUT, False),
        (INSIDE, 0.12, False),
        (OUTSIDE, SHUT, True),
        (OUTSIDE, OPEN, True),
    ],
)
def test_a_door_that_is_not_open_keeps_the_hand_from_food_inside(
    place: tuple[float, float, float], door: float, taken: bool
) -> None:
    thing = food()
    state = thing.state_at(place, 0.2)
    parents = around(thing, hand(place, grip=1.0), door, OUT)
    assert thing.decide_active(state, parents, dict.fromkeys(parents, False), None)["hand"] is taken


def test_food_is_carried_through_an_open_door_and_stopped_by_a_shut_one() -> None:
    thing = food()
    for door, expected in ((OPEN, INSIDE), (SHUT, (0.58, 0.045, 0.04))):
        state, active = thing.state_at((0.58, 0.045, 0.04), 0.2), dict.fromkeys(thing.parents, False)
        for x, grip in ((0.58, 0.0), (0.58, 1.0), (INSIDE[0], 1.0), (INSIDE[0], 1.0), (INSIDE[0], 0.0)):
            z = 0.04 if x < 0.6 else INSIDE[2]
            parents = around(thing, hand((x, 0.045, z), grip=grip), door, OUT)
            active = dict(thing.decide_active(state, parents, active, None))
            state = np.array(thing.settle(state, parents, active))
            state = thing.step(state, parents, {p: np.float64(on) for p, on in active.items()}, np.zeros(0), 1 / 30)
        settled = CAMERA.to_robot(state[:3])
        assert not active["hand"]
        np.testing.assert_allclose(settled[:2], expected[:2], atol=1e-9)


def test_fingers_slip_on_a_stiff_part_both_ways() -> None:
    for kind, mount, way in ((SlidingPart, BUTTON, 0.006), (Dial, KNOB, -0.9)):
        part = kind("part", {"hand": HAND}, dataclasses.replace(mount, stiff=1.5))
        places = [mount.point, *((mount.point[0] + way * k / 4, *mount.point[1:]) for k in range(5))]
        turns = [0.0] * 6
        if kind is Dial:
            places, turns = [mount.point] * 6, [0.0, *(way * k / 4 for k in range(5))]
        there = [hand(p, r, float(k > 0)) for k, (p, r) in enumerate(zip(places, turns, strict=True))]
        pushed, held = move(part, part.state_at(0.0), there)
        assert held
        assert pushed[part.coordinate_index] == pytest.approx(abs(way) / 1.5)
        back, _ = move(part, part.state_at(0.0), [*there, *there[:0:-1]])
        assert back[part.coordinate_index] == pytest.approx(0.0, abs=1e-12)


def test_what_cannot_be_is_refused() -> None:
    no_grip = HandSpec(exposed=["x", "y", "z"], held={"grip": 0.0}).space
    no_roll = HandSpec(exposed=["x", "y", "z", "grip"]).space
    sliding: dict[str, StateSpace] = {"hand": HAND}
    for mount in (PartMount((0.6, 0.0, 0.1), -0.1, "y"), PartMount((0.6, 0.0, 0.1), 0.1, "y", stiff=0.0)):
        with pytest.raises(InputError, match="travel, reach and stiff of a part are above 0"):
            SlidingPart("door", sliding, mount)
    with pytest.raises(InputError, match="a part has one parent, the hand; 2 given"):
        SlidingPart("door", {"hand": HAND, "other": HAND}, DOOR)
    with pytest.raises(InputError, match="hand has no grip, a binary variable"):
        SlidingPart("door", {"hand": no_grip}, DOOR)
    with pytest.raises(InputError, match="no orientation about x to turn a dial by"):
        Dial("knob", {"hand": no_roll}, KNOB)
    with pytest.raises(InputError, match=r"door: 0.3 is not within 0..0.2"):
        SlidingPart("door", sliding, DOOR).state_at(0.3)
    with pytest.raises(InputError, match="food: temperature 1.5 is outside"):
        food().state_at(INSIDE, 1.5)
    spaces = food().parents
    with pytest.raises(InputError, match="food: door is not among its parents"):
        Food("food", {n: s for n, s in spaces.items() if n != "door"})
    with pytest.raises(InputError, match="food: food has one hand among its parents; 2 given"):
        Food("food", spaces | {"other": HAND})
    with pytest.raises(InputError, match="food: its parent hand has no grip"):
        Food("food", spaces | {"hand": no_grip})


# Faults.


def played(thing: Food, state: FloatArray, way: list[FloatArray], door: float = OPEN) -> tuple[FloatArray, list[bool]]:
    """The food's state once a hand went a way, frame by frame, and whether the hand held it in each."""
    active, held = dict.fromkeys(thing.parents, False), []
    for at in way:
        parents = around(thing, at, door, OUT)
        active = dict(thing.decide_active(state, parents, active, None))
        state = np.array(thing.settle(state, parents, active))
        state = thing.step(state, parents, {n: np.float64(a) for n, a in active.items()}, np.zeros(0), 1 / 30)
        held.append(active["hand"])
    return state, held


def test_a_slip_waits_until_the_food_is_in_the_air_and_happens_once() -> None:
    thing = food(FoodSettings(camera=CAMERA, faults=CupFaults(slips=(0.2,))))
    high = (*OUTSIDE[:2], 0.2)
    grasp = [hand(OUTSIDE), hand(OUTSIDE, grip=1.0)]
    state, held = played(thing, thing.state_at(OUTSIDE, 0.0), [*grasp, *[hand(OUTSIDE, grip=1.0)] * 12])
    assert held[-1]  # due, but it stands
    state, held = played(thing, state, [hand(OUTSIDE), *grasp, *[hand(high, grip=1.0)] * 3])
    assert held[-4:] == [True, True, False, False]
    np.testing.assert_allclose(CAMERA.to_robot(state[:3]), OUTSIDE, atol=1e-9)
    _, held = played(thing, state, [hand(OUTSIDE, grip=1.0), *grasp, *[hand(high, grip=1.0)] * 9])
    assert held == [False, False, *[True] * 10]


def test_a_knock_displaces_food_that_stands_outside_once() -> None:
    thing = food(FoodSettings(camera=CAMERA, faults=CupFaults(knocks=((0.5, 0.03, -0.02),))))
    away = hand((0.4, 0.0, 0.3))
    state, _ = played(thing, thing.state_at(OUTSIDE, 0.0), [away] * 14)
    np.testing.assert_allclose(CAMERA.to_robot(state[:3]), OUTSIDE, atol=1e-12)
    state, _ = played(thing, state, [away] * 30)
    np.testing.assert_allclose(CAMERA.to_robot(state[:3]), np.add(OUTSIDE, [0.03, -0.02, 0.0]), atol=1e-12)
    inside, _ = played(thing, thing.state_at(INSIDE, 0.0), [away] * 30)
    np.testing.assert_allclose(CAMERA.to_robot(inside[:3]), INSIDE, atol=1e-12)
