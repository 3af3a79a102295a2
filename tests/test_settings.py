"""Settings: declared ranges, and what is refused by them when a scenario is loaded."""

import math
from dataclasses import dataclass, field, fields, is_dataclass
from typing import Any

import pytest

from ichain_drake.control.settings import EXECUTION, PLANNING, TRACKING
from ichain_drake.errors import InputError
from ichain_drake.learning.discovery.settings import DISCOVERY
from ichain_drake.learning.settings import LEARNING
from ichain_drake.scenarios.config import load_config
from ichain_drake.scenarios.yaml_text import read_yaml
from ichain_drake.settings import Declared, check_settings, declared_of, setting
from ichain_drake.systems import SCENARIOS, load_scenario
from ichain_drake.systems.car_game.scenario import CarGame
from ichain_drake.systems.water_dispenser.scenario import WaterDispenser

REFUSED = {
    "robot.gripper_kp=-1": "robot.gripper_kp is -1.0; give a number above 0 and up to 1e+07, in N/m",
    "robot.gripper_kd=-1": "robot.gripper_kd is -1.0; give a number above 0",
    "robot.kp=[0,1,1,1,1,1,1]": "robot.kp is [0.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0]; give one or more numbers above 0",
    "robot.kd=[.nan]": "robot.kd is [nan]; give one or more numbers above 0",
    "robot.plant_step=0": "robot.plant_step is 0.0; give a number from 0.0001 to 0.0333333, in s",
    "robot.plant_step=.inf": "robot.plant_step is inf",
    "robot.ik_rate=0": "robot.ik_rate is 0; give a whole number from 30",
    "robot.angular_speed=0": "robot.angular_speed is 0.0; give a number above 0 and up to 100, in rad/s",
    "robot.linear_speed=0": "robot.linear_speed is 0.0",
    "robot.linear_speed=-1": "robot.linear_speed is -1.0",
    "robot.linear_speed=.inf": "robot.linear_speed is inf",
    "robot.speed_scale=-1": "robot.speed_scale is -1.0",
    "robot.speed_scale=.inf": "robot.speed_scale is inf",
    "robot.arm=''": "robot.arm is ''; give a text that is not empty",
    "robot.home.x=.nan": "robot.home is {'x': nan}; give numbers that are finite, in m or rad",
    "robot.hand.surface={radius: 0}": "robot.hand.surface.radius is 0.0; give a number above 0",
    "path.speed=.inf": "path.speed is inf; give a number above 0 and up to 10000, in px/s",
    "path.tolerance=-1": "path.tolerance is -1.0",
    "control.along=.inf": "control.along is inf; give a number from 0",
    "joystick.handle=1e30": "joystick.handle is 1e+30; give a number above 0 and up to 1, in m",
}


@pytest.mark.parametrize("text", REFUSED)
def test_what_can_not_be_is_refused_when_loaded(text: str) -> None:
    with pytest.raises(InputError) as caught:
        CarGame((text,), "contact")
    assert REFUSED[text] in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("x: " + "[" * 3000 + "]" * 3000, "nested too deeply"),
        ("a: &a [1,1,1,1,1,1,1,1,1,1]\n" + "".join(
            f"{chr(98 + k)}: &{chr(98 + k)} [{', '.join(['*' + chr(97 + k)] * 10)}]\n" for k in range(8)), "aliases"),
        ("a: &a [*a]", "aliases"),
        ("a: 2001-99-99", "malformed value"),
        ("a: " + "9" * 5000, "malformed value"),
        ("a: !!python/object/apply:os.system [true]", "malformed value"),
        ("a" * (10**6 + 1), "characters are no settings"),
    ],
)  # fmt: skip
def test_yaml_that_is_not_meant_well(text: str, message: str) -> None:
    with pytest.raises(InputError, match=message) as caught:
        read_yaml(text, "file.yaml")
    assert str(caught.value).startswith("file.yaml: ")
    assert len(str(caught.value)) < 400


def test_fingers_that_the_gripper_does_not_have_are_refused() -> None:
    with pytest.raises(InputError, match="robot.gripper_open: there is no joint 'nope'; the gripper has finger_left"):
        game = CarGame(("robot.gripper_open={nope: 1, finger_left: 0.04, finger_right: 0.04}",), "contact")
        game.make_world(next(iter(choose(game).values())), 0)


def choose(game: CarGame) -> dict[str, Any]:
    from ichain_drake.runs.paths.choice import choose_paths

    return choose_paths(game, ["eight"])


@dataclass
class Part:
    """Of a user.

    Attributes:
        size: how large.
    """

    size: float = 1.0
    low: float = setting(0.0, "m", lower=-1, below=1)


@dataclass
class Whole:
    parts: list[Part] = field(default_factory=lambda: [Part(), Part()])
    pair: list[float] = setting(lambda: [0.0, 1.0], "s", size=2, rising=True)
    kind: str = setting("a", choices=("a", "b"))
    on: bool = True


def test_fields_without_a_declaration_have_to_be_finite() -> None:
    check_settings(Whole())
    check_settings(Whole(parts=[Part(size=-1e300)]))
    with pytest.raises(InputError, match=r"parts\[1\].size is nan; give a number that is finite"):
        check_settings(Whole(parts=[Part(), Part(size=math.nan)]))


@pytest.mark.parametrize(
    ("whole", "message"),
    [
        (Whole(parts=[Part(low=1.0)]), r"parts\[0\].low is 1.0; give a number from -1 below 1, in m"),
        (Whole(pair=[1.0, 0.0]), "pair is .1.0, 0.0.; give 2 numbers that are finite, from and to, in s"),
        (Whole(pair=[1.0]), "give 2 numbers"),
        (Whole(kind="c"), "kind 'c': choose a or b"),
    ],
)
def test_declared_ranges(whole: Whole, message: str) -> None:
    with pytest.raises(InputError, match=message):
        check_settings(whole)


@pytest.mark.parametrize("name", SCENARIOS)
def test_every_number_of_our_systems_says_its_range(name: str) -> None:
    """And its default is in it."""

    def visit(config: object) -> None:
        for item in fields(config):  # type: ignore[arg-type]
            value = getattr(config, item.name)
            if is_dataclass(value):
                visit(value)
            elif isinstance(value, int | float) and not isinstance(value, bool):
                assert declared_of(item) != Declared(), f"{type(config).__name__}.{item.name}"

    kind = SCENARIOS[name]
    config = load_config(kind.config_class, kind.config_path())
    visit(config)
    check_settings(config)


@pytest.mark.parametrize("ours", [LEARNING, DISCOVERY, PLANNING, EXECUTION, TRACKING], ids=lambda s: type(s).__name__)
def test_our_constants_are_within_their_ranges(ours: object) -> None:
    check_settings(ours)
    assert all(declared_of(item) != Declared() for item in fields(ours))  # type: ignore[arg-type]


@pytest.mark.parametrize("ours", [LEARNING, DISCOVERY, PLANNING, EXECUTION, TRACKING], ids=lambda s: type(s).__name__)
def test_shares_and_prices_may_be_as_small_as_one_likes_but_nothing_negative(ours: object) -> None:
    for item in fields(ours):  # type: ignore[arg-type]
        declared = declared_of(item)
        least = declared.lower if declared.above is None else declared.above
        assert least is not None and least >= 0, item.name
        if declared.unit in ("nat", "share", "probability", "1", "m"):
            assert least == 0, item.name
        if declared.unit in ("share", "probability"):
            assert {declared.below, declared.upper} <= {None, 1}, item.name


def test_one_setting_as_a_text() -> None:
    assert load_scenario("car_game", "noise.scale=2", "ideal").config.noise.scale == 2.0
    assert WaterDispenser("noise.scale=3", "ideal").config.noise.scale == 3.0
