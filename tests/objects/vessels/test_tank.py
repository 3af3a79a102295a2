"""The tank: rates, mixing, gates."""

import math

import numpy as np
import pytest
from dispenser_scene import HAND, DispenserLoop, hand

from ichain_drake.errors import InputError
from ichain_drake.objects import Button, Cup, Tank, TankSettings, check_object
from ichain_drake.objects.camera import CameraFrame

AWAY = hand(0.4, -0.3, 0.3)
ON_POWER = hand(0.5, 0.18, 0.062, pitch=0.0, grip=1.0)
ON_DISPENSE = hand(0.5, 0.26, 0.062, pitch=0.0, grip=1.0)
PARENTS = {"cup": Cup.state_space, "dispense": Button.state_space, "power": Button.state_space}


def test_it_keeps_the_contract_of_a_world_object() -> None:
    check_object(Tank("tank", PARENTS))


def test_it_heats_by_an_eightieth_a_second_up_to_one() -> None:
    loop = DispenserLoop()
    loop.fill(0.5, 0.2)
    loop.run(ON_POWER, 2 + 300)
    assert loop.value("tank", "temperature") == pytest.approx(0.2 + 10 / 80, abs=1e-3)
    assert loop.value("tank", "heat_added") == pytest.approx(0.5 * (loop.value("tank", "temperature") - 0.2))
    loop.run(ON_POWER, 70 * 30)
    assert loop.value("tank", "temperature") == 1.0
    assert loop.active["tank"] == {"cup": False, "dispense": False, "power": True}


def test_it_drains_a_sixteenth_a_second_down_to_nothing_and_what_nobody_catches_is_spilled() -> None:
    loop = DispenserLoop()
    loop.fill(0.5, 0.7)
    loop.run(ON_DISPENSE, 2 + 120)
    assert loop.value("tank", "amount") == pytest.approx(0.5 - 4 / 16, abs=5e-3)
    assert loop.value("tank", "change") == pytest.approx(-1 / 48, abs=1e-9)
    loop.run(ON_DISPENSE, 200)
    assert loop.value("tank", "amount") == 0.0
    assert loop.value("tank", "spilled") == pytest.approx(0.5)
    assert loop.value("tank", "change") == 0.0
    assert loop.water() == pytest.approx(0.5, abs=1e-12)


def test_a_level_of_three_triggers_nothing() -> None:
    loop = DispenserLoop()
    loop.fill(0.5, 0.2)
    loop.run(hand(0.5, 0.26, loop.dispense.mount.hand_height(3), pitch=0.0), 30)
    assert loop.value("dispense", "level") == 3
    assert loop.value("tank", "amount") == 0.5
    loop.run(hand(0.5, 0.26, loop.dispense.mount.hand_height(4), pitch=0.0), 30)
    assert loop.value("tank", "amount") < 0.5


def test_waters_mix_by_volume() -> None:
    loop = DispenserLoop()
    loop.fill(0.3, 0.9)
    loop.place((0.68, 0.06, 0.40), 0.6, 0.1)
    loop.states["cup"][3] = -2.0  # poured out, in the air
    loop.run(AWAY, 300)
    assert loop.value("cup", "water") < 1e-3
    assert loop.value("tank", "amount") == pytest.approx(0.9, abs=1e-3)
    assert loop.value("tank", "temperature") == pytest.approx((0.3 * 0.9 + 0.6 * 0.1) / 0.9, abs=1e-3)


def test_a_full_tank_takes_no_more() -> None:
    loop = DispenserLoop()
    loop.fill(0.9, 0.5)
    loop.place((0.68, 0.06, 0.40), 0.6, 0.1)
    loop.states["cup"][3] = -2.0
    loop.run(AWAY, 300)
    assert loop.value("tank", "amount") == pytest.approx(1.0, abs=1e-12)
    assert loop.value("cup", "spilled") == pytest.approx(0.5, abs=1e-3)
    assert loop.water() == pytest.approx(1.5, abs=1e-12)


def test_a_cup_over_the_inlet_is_let_go_only_beyond_the_margin() -> None:
    loop = DispenserLoop()
    for x, expected in ((0.725, False), (0.719, True), (0.721, True), (0.723, False), (0.721, False)):
        loop.place((x, 0.06, 0.40), 0.1, 0.1)
        loop.frame(AWAY)
        assert loop.active["tank"]["cup"] is expected


def test_bad_input_is_refused() -> None:
    tank = Tank("tank", PARENTS)
    with pytest.raises(InputError, match="tank: amount 1.2 given; it is between 0 and 1"):
        tank.state_at(1.2, 0.5)
    with pytest.raises(InputError, match="tank: temperature -0.1 given"):
        tank.state_at(0.2, -0.1)
    with pytest.raises(InputError, match="'pump' is to be a button that acts on it"):
        Tank("tank", PARENTS, tank=TankSettings(drain="pump"))
    with pytest.raises(InputError, match="its parent hand is neither one of its buttons nor a vessel"):
        Tank("tank", PARENTS | {"hand": HAND})


def test_the_sensor_is_noisy_within_its_range() -> None:
    tank = Tank("tank", PARENTS)
    states = np.tile(tank.state_at(1.0, 0.5), (4000, 1))
    read = tank.measure(states, np.random.default_rng(0).standard_normal((4000, 3)))
    assert read[:, 0].max() == 1.0
    assert read[:, 1].std() == pytest.approx(0.004, rel=0.1)
    assert math.isclose(read[:, 2].mean(), 0.0, abs_tol=1e-3)


def test_where_the_camera_sees_the_machine_its_place_is_measured() -> None:
    camera = CameraFrame(0.3, (0.1, 0.0, -0.1))
    tank = Tank("tank", PARENTS, tank=TankSettings(camera=camera, stands=(0.7, 0.1, 0.0, 0.2)))
    check_object(tank)
    state = tank.state_at(0.5, 0.2)
    read = tank.measure(state, np.zeros(len(tank.state_space.observable)))
    np.testing.assert_allclose(read[3:6], camera.from_robot(np.array([0.7, 0.1, 0.0])))
    assert read[6] == pytest.approx(0.5)
    assert tank.state_space.observable.names == ("amount", "temperature", "change", "x", "y", "z", "turn")
