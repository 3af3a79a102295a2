"""The road car and the ship against what their sources' models must do."""

from __future__ import annotations

import numpy as np
import pytest

from ichain_drake.errors import InputError
from ichain_drake.objects import (
    Car,
    Hovercraft,
    Joystick,
    ObjectSettings,
    RoadCar,
    RoadCarParameters,
    Ship,
    ShipParameters,
    Wheel,
    WorldObject,
    check_object,
)
from ichain_drake.objects.controls.wheel import TRAVEL
from ichain_drake.state import StateSpace, Variable
from ichain_drake.timing import FRAME

WHEELS = {"wheel": Wheel.state_space}
CAR, SHIP = RoadCar("car", WHEELS), Ship("ship", WHEELS)


def drive(thing: WorldObject, state: list[float], angle_deg: float, slide: float, seconds: float) -> np.ndarray:
    now = np.array(state, dtype=float)
    wheel, still = np.array([np.radians(angle_deg), slide]), np.zeros(thing.process_noise_size)
    for _ in range(round(seconds / FRAME)):
        now = thing.step(now, {"wheel": wheel}, {"wheel": np.float64(1)}, still, FRAME)
    return now


def test_a_slow_car_turns_as_its_geometry_says() -> None:
    after = drive(CAR, [0, 0, 0, 5, 0, 0, 0], 60.0, 0.0012, 3.0)
    steer = np.radians(60) / 10
    radius = (1.1562 + 1.4227) / np.tan(steer)
    assert after[3] / after[4] == pytest.approx(radius, rel=0.05)


def test_tyres_saturate() -> None:
    """No more side acceleration than friction allows, however fast the bend is entered."""
    most = RoadCarParameters().friction * 9.81
    for speed in (12, 20, 30):
        after = drive(CAR, [0, 0, 0, speed, 0, 0, 0], 120.0, 0.004, 1.5)
        assert 0.6 * most < abs(after[3] * after[4]) < 1.15 * most


def test_brakes_stop_the_car_and_it_stays() -> None:
    after = drive(CAR, [0, 0, 0, 12, 0, 0, 0], 60.0, -TRAVEL, 5.0)
    np.testing.assert_allclose(after[3:6], 0.0, atol=1e-6)
    later = drive(CAR, list(after), 60.0, -TRAVEL, 1.0)
    np.testing.assert_allclose(later[:3], after[:3], atol=1e-6)


def test_turning_left_is_the_mirror_image_of_right() -> None:
    p = ShipParameters(current=(0.0, 0.0))
    ship = Ship("ship", WHEELS, parameters=p)
    for thing, start, odd in (
        (CAR, [0, 0, 0, 9, 0, 0, 0], (1, 2, 4, 5, 6)),
        (ship, [0, 0, 0, 0.7, *[0] * 6], (1, 2, 4, 5, 7)),
    ):
        left, right = (drive(thing, start, sign * 50, 0.01, 4.0) for sign in (1, -1))
        assert left[2] > 0.1
        mirrored = right.copy()
        mirrored[list(odd)] *= -1
        np.testing.assert_allclose(left, mirrored, atol=1e-9)


def test_the_ship_keeps_service_speed_answers_slowly_and_drifts() -> None:
    p = ShipParameters(current=(0.0, 0.0))
    ship = Ship("ship", WHEELS, parameters=p)
    ahead = TRAVEL / p.full_ahead
    straight = drive(ship, [0, 0, 0, 0.5, 0, 0, 1, 0, 0, 0], 0.0, ahead, 120.0)
    assert straight[3] == pytest.approx(p.service, rel=1e-3)
    turn = [drive(ship, [0, 0, 0, p.service, 0, 0, 1, 0, 0, 0], 100.0, ahead, s) for s in (0.5, 2.0, 6.0)]
    assert turn[0][7] < 0.5 * turn[1][7] < 0.8 * turn[2][7]
    assert turn[2][4] < -0.02  # it slides outwards
    adrift = drive(SHIP, [0, 0, 0, 0, 0, 0, 0, 0, *ShipParameters().current], 0.0, 0.0, 60.0)
    assert adrift[:2] @ ShipParameters().current > 0  # the current takes it along


def test_a_ship_has_momentum() -> None:
    stopped = drive(SHIP, [0, 0, 0, 0.77, 0, 0, 0, 0, 0, 0], 0.0, 0.0, 5.0)
    assert 0.4 < stopped[3] < 0.75


@pytest.mark.parametrize(("thing", "what"), [(RoadCar, "a road car"), (Ship, "a ship")])
def test_contract_and_parents(thing: type[WorldObject], what: str) -> None:
    check_object(thing("thing", WHEELS))
    with pytest.raises(InputError, match=f"{what} has one parent with two"):
        thing("thing", {"lever": StateSpace("lever", (Variable("level"),))})
    with pytest.raises(InputError, match=f"{what} has one parent with two"):
        thing("thing", {})


@pytest.mark.parametrize(
    ("kind", "parents"),
    [
        (Car, {"stick": Joystick.state_space}),
        (Hovercraft, {"stick": Joystick.state_space}),
        (RoadCar, WHEELS),
        (Ship, WHEELS),
    ],
)
def test_readings_are_the_truth_unless_their_noise_is_asked_for(kind: type, parents: dict[str, StateSpace]) -> None:
    state = np.tile(kind("it", parents).default_state(), (4000, 1))
    noise = np.random.default_rng(0).standard_normal((4000, len(kind.state_space.observable)))
    exact = kind("it", parents).measure(state, noise)
    np.testing.assert_array_equal(exact, state[:, kind.state_space.observable_indices])
    read = kind("it", parents, settings=ObjectSettings(reading_scale=2.0)).measure(state, noise)
    np.testing.assert_allclose((read - exact).std(axis=0), 2 * np.array(kind.reading_std), rtol=0.05)
