"""Scenario files and `--set`: typed, with errors that say which key or file is wrong."""

from dataclasses import dataclass, field
from pathlib import Path

import pytest
import yaml

from ichain_drake.control.tracking.path import PathLimits
from ichain_drake.errors import InputError
from ichain_drake.learning.chain.link import EstimatorSpec
from ichain_drake.robot import models_path
from ichain_drake.scenarios.config import (
    ControlConfig,
    LearningConfig,
    LinkConfig,
    PathConfig,
    ScenarioConfig,
    as_plain,
    load_config,
)
from ichain_drake.scenarios.joystick_game import JoystickGameConfig
from ichain_drake.systems import load_scenario
from ichain_drake.systems.car_game.scenario import CarGame

CAR_GAME = models_path() / "scenarios" / "car_game.yaml"


@dataclass
class Own(ScenarioConfig):
    path: PathConfig = field(default_factory=PathConfig)


def load(folder: Path, text: str, *overrides: str) -> Own:
    (folder / "own.yaml").write_text(text)
    return load_config(Own, folder / "own.yaml", overrides)


def test_an_empty_file_gives_all_defaults(tmp_path: Path) -> None:
    assert as_plain(load(tmp_path, "")) == as_plain(Own())


def test_a_file_fills_in_what_it_names_and_set_goes_over_it(tmp_path: Path) -> None:
    text = "noise: {scale: 2.0}\npath: {speed: 20.0}\n"
    config = load(tmp_path, text, "path.speed=30", "learning.samples=7", "control.horizons=[3, 4]")
    assert (config.noise.scale, config.path.speed, config.path.turn_rate) == (2.0, 30.0, PathConfig().turn_rate)
    assert (config.learning.samples, config.control.horizons) == (7, [3, 4])


def test_later_settings_win_and_do_not_leak_into_the_next_load(tmp_path: Path) -> None:
    assert load(tmp_path, "", "noise.scale=3", "noise.scale=1e-3").noise.scale == 1e-3
    assert load(tmp_path, "").noise.scale == 1.0


def test_nobody_gets_what_another_has_changed_and_an_edited_file_is_read_anew(tmp_path: Path) -> None:
    file = tmp_path / "scenario.yaml"
    file.write_text("noise: {scale: 2}")
    first = load_config(ScenarioConfig, file)
    first.noise.scale = 7.0
    first.robot.hand.exposed.append("nix")
    again = load_config(ScenarioConfig, file)
    assert again.noise.scale == 2.0
    assert again == load_config(ScenarioConfig, file, ())
    assert "nix" not in again.robot.hand.exposed
    file.write_text("noise: {scale: 3}")
    assert load_config(ScenarioConfig, file).noise.scale == 3.0


@pytest.mark.parametrize("key", ["noise.scale=2", "fault.kind=slip", "camera.yaw_deg=20", "learning.estimator=mlp",
                                 "learning.samples=50", "control.method=inverse"])  # fmt: skip
def test_keys_that_every_scenario_has(tmp_path: Path, key: str) -> None:
    name, value = key.split("=")
    section, item = name.split(".")
    assert str(getattr(getattr(load(tmp_path, "", key), section), item)).startswith(value)


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ("noise.scal=2", "--set noise.scal: there is no key 'scal'; did you mean scale?"),
        ("nois.scale=2", "there is no key 'nois'; did you mean noise?"),
        ("noise.qqqq=2", "there is no key 'qqqq'; known are scale"),
        ("noise.scale.more=2", "there is no key 'more'"),
        ("noise.scale", "write key=value"),
        ("=2", "write key=value"),
        ("noise.scale=[1", "malformed value"),
        ("noise.scale=loud", r"--set noise\.scale=loud: .*'loud'"),
        ("learning.samples=2.5", r"--set learning\.samples=2\.5: .*samples.*2\.5"),
        ("noise=3", "--set noise=3: a section of keys belongs there, not 3"),
    ],
)
def test_a_bad_setting_is_refused_in_one_line(tmp_path: Path, setting: str, message: str) -> None:
    with pytest.raises(InputError, match=message) as caught:
        load(tmp_path, "", setting)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("noise: {scale: [1", "malformed value"),
        ("- 1\n- 2\n", "a scenario is a mapping of sections"),
        ("noize: {scale: 1}", "noize"),
        ("noise: {skale: 1}", "skale"),
        ("noise: {scale: much}", "much"),
    ],
)
def test_a_bad_file_is_refused_with_its_name(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(InputError, match=rf"own\.yaml: .*{message}"):
        load(tmp_path, text)


def test_a_missing_file_is_refused_with_its_name(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"none\.yaml: can't read the scenario"):
        load_config(Own, tmp_path / "none.yaml")


def test_the_shipped_scenario_loads_and_its_plain_form_is_yaml() -> None:
    config = load_config(JoystickGameConfig, CAR_GAME)
    plain = as_plain(config)
    assert yaml.safe_load(yaml.safe_dump(plain)) == plain
    assert plain["play"]["reach"] == yaml.safe_load(CAR_GAME.read_text())["play"]["reach"]
    assert {k.interaction for k in config.learning.links} == {"hand->joystick", "joystick->car"}


def test_learning_candidates() -> None:
    link = LinkConfig("a->b", ["mlp"], ["polynomial(degree=3)"], ["raw"], ["both"], [1, 2], "polynomial(degree=1)")
    made = LearningConfig(samples=70, links=[link]).candidates()["a->b"]
    assert made.forward == (EstimatorSpec("mlp"),)
    assert made.inverse == (EstimatorSpec("polynomial", {"degree": 3}),)
    assert (made.features, made.forward_actions, made.aims, made.samples) == (("raw",), ("both",), (1, 2), 70)
    assert made.screening == EstimatorSpec("polynomial", {"degree": 1})
    # One estimator for everything, where the user asks for one.
    only = LearningConfig(estimator="extra_trees", links=[link]).candidates()["a->b"]
    assert only.forward == only.inverse == (EstimatorSpec("extra_trees"),)


@pytest.mark.parametrize(
    ("config", "message"),
    [
        (LearningConfig(samples=0), "learning.samples is 0; give a whole number from 1"),
        (LearningConfig(action="later"), "learning.action 'later': choose next or current"),
        (
            LearningConfig(links=[LinkConfig("a->b", features=["shape"])]),
            "features 'shape': choose none, raw or body",
        ),
        (
            LearningConfig(links=[LinkConfig("a->b", forward_actions=["soon"])]),
            "actions 'soon': choose next, current or both",
        ),
        (
            LearningConfig(links=[LinkConfig("a->b", aims=[0])]),
            r"aims is \[0\]; give one or more numbers",
        ),
        (LearningConfig(links=[LinkConfig("a->b", aims=[])]), r"aims is \[\]"),
        (LearningConfig(links=[LinkConfig("a->b", forward=["os.system"])]), "estimator 'os.system'"),
        (ControlConfig(horizons=[1]), r"control.horizons is \[1\]; give one or more numbers from 2"),
        (ControlConfig(offset=1.0), "control.offset is 1.0; give a number from 0 below 1"),
        (ControlConfig(efforts=[]), r"control.efforts is \[\]; give one or more numbers above 0"),
    ],
)
def test_bad_candidates_are_refused(config: LearningConfig | ControlConfig, message: str) -> None:
    with pytest.raises(InputError, match=message):
        config.candidates()


def test_path_settings() -> None:
    assert PathConfig(speed=20.0).limits() == PathLimits(20.0, 1.1, 1.0, 40.0, 3.0)
    for bad in (0.0, -1.0, float("nan")):
        with pytest.raises(InputError, match="path.turn_rate is .* give a number above 0"):
            PathConfig(turn_rate=bad).limits()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"physics": "magic"}, "physics 'magic': choose ideal, arm or contact"),
        ({"seed": -1}, "seed -1"),
        ({"overrides": ["fault.kind=slip"]}, "car_game has no fault 'slip'; it has none"),
        ({"overrides": ["camera.yaw_deg=20"]}, "car_game has no camera"),
        ({"overrides": ["noise.scale=-1"]}, "noise.scale is -1.0"),
        ({"overrides": ["noise.scale=.nan"]}, "noise.scale is nan"),
    ],
)
def test_what_a_scenario_does_not_support_is_refused(arguments: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=message):
        CarGame(**arguments)  # type: ignore[arg-type]


@pytest.mark.parametrize("name", ["car_racing", "kettle"])
def test_noise_of_readings_that_no_vehicle_declares_is_refused(name: str) -> None:
    with pytest.raises(InputError, match=f"{name} has no vehicle that declares noise of readings: leave noise.vehicle"):
        load_scenario(name, ["noise.vehicle=1"])
