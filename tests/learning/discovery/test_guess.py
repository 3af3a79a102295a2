"""State spaces guessed from columns alone: every kind, its bounds and its role, and what can't be guessed."""

import math

import numpy as np
import pandas as pd
import pytest

from ichain_drake.demonstrations import Demonstration
from ichain_drake.errors import InputError
from ichain_drake.learning.discovery.guess import Guess, guess_spaces
from ichain_drake.state import Role, Variable

ROWS = 6


def piece(units: dict[str, str] | None = None, **columns: object) -> Demonstration:
    table = {"time": np.arange(ROWS) / 3.0, **{k.replace("__", "."): v for k, v in columns.items()}}
    return Demonstration(pd.DataFrame(table), units or {})


def guessed(unit: str, values: object, name: str = "v", **more: object) -> Variable:
    units = {f"it.{name}": unit, **{f"it.{k}": "l" for k in more}}
    columns = {f"it__{name}": values, **{f"it__{k}": v for k, v in more.items()}}
    found = guess_spaces([piece(units, hand__q=np.linspace(0, 1, ROWS), command__q=np.zeros(ROWS), **columns)])
    return found.spaces["it"].variables[0]


SMOOTH = np.linspace(0.1, 0.9, ROWS)


@pytest.mark.parametrize(
    ("unit", "values", "name", "expected"),
    [
        ("m", SMOOTH, "x", Variable("x", "m", role=Role("position", "world", "x"))),
        ("mm", SMOOTH, "z", Variable("z", "mm", role=Role("position", "world", "z"))),
        ("s", SMOOTH, "x", Variable("x", "s")),
        ("m", SMOOTH, "width", Variable("width", "m")),
        ("rad", SMOOTH, "v", Variable("v", "rad", -math.pi, math.pi, "angle", Role("orientation", "world"))),
        ("l", SMOOTH, "v", Variable("v", "l", 0.0, math.inf, role=Role("amount"))),
        ("", SMOOTH, "v", Variable("v", "1")),
        ("", [0, 1, 1, 0, 0, 1], "v", Variable("v", "1", 0.0, 1.0, "binary")),
        ("", [2, 4, 3, 2, 2, 5], "v", Variable("v", "1", 2.0, 5.0, "integer", Role("level"))),
        ("degC", SMOOTH, "v", Variable("v", "degC")),
    ],
)
def test_a_variable_is_what_its_name_unit_and_readings_say(
    unit: str, values: object, name: str, expected: Variable
) -> None:
    assert guessed(unit, values, name) == expected


def test_a_temperature_is_that_of_the_one_amount_beside_it() -> None:
    assert guessed("degC", SMOOTH, water=SMOOTH).role == Role("intensive", of="water")
    assert guessed("degC", SMOOTH, water=SMOOTH, milk=SMOOTH).role is None


def test_readings_that_are_missing_say_nothing() -> None:
    assert guessed("", [0, 1, np.nan, 0, 0, 1]).kind == "binary"
    assert guessed("", [np.nan] * ROWS).kind == "real"


def commanded() -> Guess:
    return guess_spaces(
        [piece({"arm.x": "m"}, arm__x=SMOOTH, cup__v=SMOOTH, command__x=SMOOTH, **{"arm->cup": np.zeros(ROWS)})]
    )


def test_the_robot_is_what_is_commanded_and_its_frame_its_own() -> None:
    found = commanded()
    assert found.robot == "arm"
    assert found.spaces["arm"].variables[0].role == Role("position", "robot", "x")
    assert set(found.spaces) == {"arm", "cup"}, "neither commands nor flags are objects"
    assert found.notes == (
        "arm.x: in m; real, position",
        "cup.v: no unit given, taken as a plain number; real, no role",
    )


@pytest.mark.parametrize(
    ("columns", "robot", "said"),
    [
        ({"cup__x": SMOOTH}, "", "at least two objects"),
        ({"cup__x": SMOOTH, "arm__x": SMOOTH}, "", "which object is the robot isn't known; name it with --robot"),
        ({"cup__x": SMOOTH, "arm__x": SMOOTH, "command__x": SMOOTH}, "", "isn't known"),
        ({"cup__x": SMOOTH, "arm__x": SMOOTH}, "leg", "no object 'leg' to be the robot; objects are cup, arm"),
    ],
)
def test_what_can_not_be_guessed_is_said(columns: dict[str, object], robot: str, said: str) -> None:
    with pytest.raises(InputError, match=said):
        guess_spaces([piece(**columns)], robot)


def test_times_are_needed() -> None:
    table = piece(cup__x=SMOOTH, arm__x=SMOOTH).table.drop(columns="time")
    with pytest.raises(InputError, match="column time is missing"):
        guess_spaces([Demonstration(table)])
