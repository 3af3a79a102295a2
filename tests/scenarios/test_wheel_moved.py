"""The wheel elsewhere: what is declared follows, and what was learned at its usual place holds without a new sample."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from ichain_drake.cli.main import main
from ichain_drake.errors import InputError
from ichain_drake.robot import RingPath
from ichain_drake.scenarios.wheel_drive import WheelDrive
from ichain_drake.systems import load_scenario

ELSEWHERE = "wheel.center=[0.49, 0.04, 0.13]"


def scenario(name: str, *settings: str) -> WheelDrive:
    made = load_scenario(name, settings, "ideal", 0)
    assert isinstance(made, WheelDrive)
    return made


@pytest.mark.parametrize("name", ["driving", "ship"])
def test_the_hand_s_usual_numbers_follow_from_the_wheel_s(name: str) -> None:
    robot = scenario(name).config.robot
    assert robot.hand.ring == RingPath([0.47, 0.0], 0.11)
    assert robot.hand.bounds == {"x": [0.33, 0.61], "y": [-0.14, 0.14], "z": [0.135, 0.195]}
    assert robot.home == {"x": 0.36, "y": 0.0, "z": 0.165}


def test_one_key_moves_all_that_is_about_the_wheel() -> None:
    made = scenario("driving", ELSEWHERE)
    robot = made.config.robot
    assert robot.hand.ring == RingPath([0.49, 0.04], 0.11)
    assert robot.hand.bounds == {"x": [0.35, 0.63], "y": [-0.1, 0.18], "z": [0.145, 0.205]}
    assert robot.home == {"x": 0.38, "y": 0.04, "z": 0.175}
    assert made.given()["graph"]["origins"] == {"wheel": {"frame": "robot", "position": [0.49, 0.04, 0.13]}}
    np.testing.assert_allclose(robot.hand.reduce(robot.home_hand()), made.hand_for_setting(np.zeros(2)), atol=1e-9)


def test_what_is_set_about_the_hand_stays() -> None:
    settings = ("robot.hand.ring={center: [0.47, 0.01], radius: 0.1}", "robot.hand.bounds={z: [0.1, 0.2]}")
    robot = scenario("driving", *settings, "robot.home={x: 0.4}").config.robot
    assert robot.hand.ring == RingPath([0.47, 0.01], 0.1)
    assert robot.hand.bounds == {"x": [0.33, 0.61], "y": [-0.14, 0.14], "z": [0.1, 0.2]}
    assert robot.home == {"x": 0.4, "y": 0.0, "z": 0.165}


@pytest.mark.parametrize("place", ["[0.47, 0]", "[0.47, 0, .inf]"])
def test_places_that_are_none_are_refused(place: str) -> None:
    with pytest.raises(InputError, match="wheel.center is .*; give 3 numbers from -2 to 2, in m"):
        scenario("driving", f"wheel.center={place}")


def test_a_library_of_the_usual_place_drives_elsewhere(tmp_path: Path) -> None:
    demos, library = str(tmp_path / "demos"), str(tmp_path / "library")
    small = ["--set", "learning.samples=200", "--set", "control.horizons=[5]", "--set", "control.efforts=[0.05]"]
    assert main(["teach", "driving", "--physics", "ideal", *small[:2], "-o", demos]) == 0
    assert main(["learn", "driving", *small[:2], "--demos", demos, "-o", library]) == 0

    def errors(*settings: str) -> np.ndarray:
        report = tmp_path / "report.json"
        more = ["--library", library, "-o", str(tmp_path / "out"), "--report", str(report)]
        chosen = [part for setting in settings for part in ("--set", setting)]
        assert main(["run", "driving", "--physics", "ideal", *small, *chosen, *more]) == 0
        found = json.loads(report.read_text())
        assert all(model["source"] != "demonstrations" for model in found["models"].values())
        return np.array([path["mean_error_px"] for path in found["metrics"]["paths"].values()])

    np.testing.assert_allclose(errors(ELSEWHERE), errors(), rtol=0.1)
