"""The kettle and a bottle: pouring either way, heating on the plate, conservation."""

import numpy as np
import pytest
from dispenser_scene import FORWARD, HAND, hand
from hypothesis import given, settings
from hypothesis import strategies as st
from pydrake.math import RigidTransform, RollPitchYaw

from ichain_drake.errors import InputError
from ichain_drake.objects import (
    Button,
    CameraFrame,
    Cup,
    CupSettings,
    Kettle,
    KettleSettings,
    Region,
    Surface,
    check_object,
)
from ichain_drake.objects.base import WorldObject
from ichain_drake.timing import FRAME

CAMERA = CameraFrame(0.6, (0.03, -0.02, -0.05))
ON_PLATE = np.array([0.735, 0.045, 0.135])  # tip of the spout
PARENTS = {"hand": HAND, "bottle": Cup.space(["kettle"]), "switch": Button.state_space}
INTO_KETTLE = Region((0.0, 0.085, 0.145), (0.04, 0.04, 0.12))
INTO_BOTTLE = Region((0.0, 0.0, 0.085), (0.02, 0.02, 0.08))


def bottle_settings() -> CupSettings:
    return CupSettings(0.18, 0.028, outlets={}, inlets={"kettle": INTO_BOTTLE}, camera=CAMERA)


def kettle_settings() -> CupSettings:
    return CupSettings(0.115, 0.055, (0.0, -0.085), outlets={}, inlets={"bottle": INTO_KETTLE}, camera=CAMERA)


class Loop:
    """Bottle and kettle without a diagram; poses are set, a frame advances what follows from them."""

    def __init__(self, water: tuple[float, float], temperature: tuple[float, float] = (0.1, 0.8)) -> None:
        spaces = {"bottle": Cup.space(["kettle"]), "kettle": Kettle.space(["bottle"])}
        self.objects: dict[str, Cup] = {
            "bottle": Cup("bottle", {"hand": HAND, "kettle": spaces["kettle"]}, cup=bottle_settings()),
            "kettle": Kettle("kettle", PARENTS, cup=kettle_settings()),
        }
        self.states = {
            "bottle": self.objects["bottle"].state_at((0.70, -0.15, 0.18), water[0], temperature[0]),
            "kettle": self.objects["kettle"].state_at(ON_PLATE, water[1], temperature[1]),
        }
        self.active = {n: dict.fromkeys(o.parents, False) for n, o in self.objects.items()}
        self.level = 0.0

    def pose(self, name: str, mouth: np.ndarray, tilt: float) -> None:
        self.states[name][:4] = (*CAMERA.from_robot(mouth), tilt)

    def over(self, giver: str, tilt: float, off: float = 0.0) -> None:
        """One vessel's mouth over the other, which stands upright."""
        if giver == "bottle":
            self.pose("bottle", ON_PLATE + [off, 0.085, 0.1], tilt)
        else:
            self.pose("kettle", np.array([0.70 + off, -0.15, 0.25]), tilt)

    def frame(self) -> None:
        before = self.states | {"hand": hand(0.5, 0.0, 0.5), "switch": np.array([self.level, 0.0])}
        settled = dict(before)
        for name, system in self.objects.items():
            self.active[name] = dict(system.decide_active(before[name], before, self.active[name], None))
            settled[name] = np.array(system.settle(before[name], before, self.active[name]))
        for name, system in self.objects.items():
            on = {p: np.float64(v) for p, v in self.active[name].items()}
            self.states[name] = system.step(settled[name], settled, on, np.zeros(0), FRAME)

    def value(self, name: str, variable: str) -> float:
        return float(self.states[name][self.objects[name].state_space.index(variable)])

    def totals(self) -> tuple[float, float]:
        """Water, and heat less what was added: in vessels, spilled and in flight."""
        water = sum(self.value(n, v) for n in self.objects for v in ("water", "spilled", "flow"))
        heat = sum(self.value(n, "water") * self.value(n, "temperature") for n in self.objects)
        heat += sum(self.value(n, v) for n in self.objects for v in ("spilled_heat", "flow_heat"))
        return water, heat - self.value("kettle", "heat_added")


def test_it_keeps_the_contract_of_a_world_object() -> None:
    check_object(Kettle("kettle", PARENTS, cup=kettle_settings()))
    bottle: WorldObject = Cup("bottle", {"hand": HAND, "kettle": Kettle.space(["bottle"])}, cup=bottle_settings())
    check_object(bottle)


def test_the_same_pair_gives_in_one_direction_and_then_in_the_other() -> None:
    loop = Loop((0.9, 0.0))
    loop.over("bottle", -1.92)
    for _ in range(150):
        loop.frame()
    assert loop.active["kettle"]["bottle"]
    assert not loop.active["bottle"]["kettle"]
    assert loop.value("kettle", "water") == pytest.approx(0.9, abs=1e-3)
    loop.pose("bottle", np.array([0.70, -0.15, 0.18]), 0.0)
    loop.over("kettle", 1.15)
    for _ in range(150):
        loop.frame()
    assert loop.active["bottle"]["kettle"]
    assert not loop.active["kettle"]["bottle"]
    assert loop.value("bottle", "water") == pytest.approx(0.9, abs=1e-3)


moves = st.lists(
    st.tuples(
        st.sampled_from(["bottle", "kettle"]),
        st.floats(-2.5, 2.5),
        st.floats(-0.06, 0.06),
        st.sampled_from([0.0, 2.0, 6.0]),
    ),
    min_size=1,
    max_size=5,
)


@given(st.tuples(st.floats(0, 1), st.floats(0, 1)), st.tuples(st.floats(0, 1), st.floats(0, 1)), moves)
@settings(max_examples=40, deadline=None)
def test_water_and_heat_are_conserved_whatever_is_poured_where(
    water: tuple[float, float], temperature: tuple[float, float], poses: list[tuple[str, float, float, float]]
) -> None:
    loop = Loop(water, temperature)
    first = loop.totals()
    for giver, tilt, off, loop.level in poses:
        loop.pose("bottle", np.array([0.70, -0.15, 0.18]), 0.0)
        loop.pose("kettle", ON_PLATE, 0.0)
        loop.over(giver, tilt, off)
        for _ in range(12):
            loop.frame()
            np.testing.assert_allclose(loop.totals(), first, atol=1e-9)
            for name in loop.objects:
                assert 0.0 <= loop.value(name, "water") <= 1.0
                assert 0.0 <= loop.value(name, "temperature") <= 1.0


@pytest.mark.parametrize(
    ("level", "shift", "tilt", "heats"),
    [
        (6.0, (0.0, 0.0, 0.0), 0.0, True),
        (4.0, (0.015, -0.015, 0.0), 0.0, True),
        (3.0, (0.0, 0.0, 0.0), 0.0, False),
        (6.0, (0.025, 0.0, 0.0), 0.0, False),
        (6.0, (0.0, 0.0, 0.02), 0.0, False),
        (6.0, (0.0, 0.0, 0.0), 0.5, False),
    ],
)
def test_it_heats_while_it_stands_on_its_plate_and_the_switch_is_pressed(
    level: float, shift: tuple[float, float, float], tilt: float, heats: bool
) -> None:
    loop = Loop((0.0, 0.5))
    loop.pose("kettle", ON_PLATE + shift, tilt)
    loop.level = level
    for _ in range(60):
        loop.frame()
    assert loop.active["kettle"]["switch"] is heats
    assert loop.value("kettle", "temperature") == pytest.approx(0.8 + (2.0 / 40.0 if heats else 0.0))


def test_it_pours_by_the_spout_sooner_than_over_the_rim() -> None:
    kettle = Kettle("kettle", PARENTS, cup=kettle_settings())
    state = np.zeros((4, len(kettle.state_space)))
    state[:, 3] = 0.2, 0.7, 1.12, -0.65
    np.testing.assert_allclose(kettle.stays(state.T), [1.0, 0.5, 0.0, 1 - 0.35 / 1.5], atol=1e-12)


def test_a_tilted_vessel_catches_nothing() -> None:
    loop = Loop((0.9, 0.1))
    loop.over("bottle", -1.5)
    loop.pose("kettle", ON_PLATE, 0.4)
    loop.frame()
    assert not loop.active["kettle"]["bottle"]


def test_a_kettle_let_go_stands_below_its_middle_and_not_below_its_spout() -> None:
    plate = Surface((0.675, 0.795), (0.07, 0.19), 0.02)
    cup = CupSettings(0.115, 0.055, (0.0, -0.085), outlets={}, inlets={"bottle": INTO_KETTLE}, surfaces=(plate,))
    kettle = Kettle("kettle", PARENTS, cup=cup)
    assert float(kettle.support(*np.array([0.735, 0.045, 0.2]))) == 0.02
    assert float(kettle.support(*np.array([0.735, 0.13, 0.2]))) == 0.0
    np.testing.assert_allclose(kettle.default_state()[:3], [0.0, -0.085, 0.115])


@given(st.floats(-1.5, 1.5), st.floats(-1.2, 1.2), st.floats(-3, 3))
@settings(max_examples=30, deadline=None)
def test_a_body_gives_the_spouts_tip_and_the_axis(roll: float, pitch: float, yaw: float) -> None:
    kettle = Kettle("kettle", PARENTS, cup=kettle_settings())
    pose = RigidTransform(RollPitchYaw(roll, pitch, yaw), [0.6, 0.1, 0.2])
    body = np.concatenate([pose.rotation().ToQuaternion().wxyz(), pose.translation(), np.zeros(6)])
    sampled = kettle.sample_body(body)
    np.testing.assert_allclose(CAMERA.to_robot(sampled[:3]), pose @ [0.0, -0.085, 0.115], atol=1e-12)
    axis = pose.rotation().matrix()[:, 2]
    np.testing.assert_allclose(sampled[3:], [np.arctan2(-axis[1], axis[2]), np.arcsin(axis[0])], atol=1e-9)


def test_it_is_held_by_its_handle() -> None:
    kettle = Kettle("kettle", PARENTS, cup=CupSettings(inlets={"bottle": INTO_KETTLE}, outlets={}))
    state = kettle.state_at((0.6, 0.0, 0.1), 0.5, 0.1)
    parents = {p: np.zeros(len(s)) for p, s in PARENTS.items()} | {"hand": hand(0.6, 0.0, 0.06, 0.0, FORWARD, 1.0)}
    assert kettle.decide_active(state, parents, dict.fromkeys(PARENTS, False), None)["hand"]


@pytest.mark.parametrize(
    ("parents", "cup", "kettle", "says"),
    [
        (PARENTS, None, KettleSettings(switch="knob"), "'knob' is to be the switch"),
        (PARENTS | {"switch": HAND}, None, None, "'switch' is to be the switch"),
        (PARENTS, None, KettleSettings(heat_rate=0.0), "heat_rate"),
        (PARENTS, CupSettings(outlets={}), None, "no outlet is given for its parent bottle"),
        ({k: v for k, v in PARENTS.items() if k != "hand"}, None, None, "one hand among its parents; 0 given"),
    ],
)
def test_what_does_not_fit_is_refused_in_a_line(
    parents: dict, cup: CupSettings | None, kettle: KettleSettings | None, says: str
) -> None:
    with pytest.raises(InputError, match=says) as error:
        Kettle("kettle", parents, cup or kettle_settings(), kettle)
    assert "\n" not in str(error.value)
