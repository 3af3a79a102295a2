"""The report says what was declared rather than learned: units, roles, layout, goal; no border of an interaction."""

import dataclasses
import json
from collections.abc import Iterator
from typing import Any

import pytest

from ichain_drake.objects.region import GATE, Region
from ichain_drake.scenarios.given import geometry
from ichain_drake.systems import load_scenario
from ichain_drake.systems.car_game.scenario import CarGame
from ichain_drake.systems.kettle.layout import VesselShape
from ichain_drake.systems.water_dispenser.scenario import WaterDispenser


def test_units_kinds_bounds_and_roles_are_given():
    given = WaterDispenser((), "ideal").given()
    json.dumps(given, allow_nan=False)
    objects = given["graph"]["objects"]
    assert given["graph"]["interactions"][0] == "hand->cup"
    assert objects["cup"]["x"] == {"unit": "m", "kind": "real", "bounds": [None, None], "role": "position x in camera"}
    assert objects["cup"]["temperature"]["role"] == "intensive of water"
    assert objects["power"]["level"] == {"unit": "1", "kind": "integer", "bounds": [0.0, 6], "role": "level"}
    assert objects["hand"]["grip"]["role"] == ""
    assert "spilled" not in objects["cup"]  # hidden: nobody sees it
    assert {"goal", "layout", "start", "fault", "camera", "camera_shift", "robot"} <= set(given)


def test_what_a_chain_declares_is_given_too():
    given = CarGame((), "ideal").given()
    json.dumps(given, allow_nan=False)
    assert given["graph"]["interactions"] == ["hand->joystick", "joystick->car"]


def keys(value: Any) -> Iterator[str]:
    if isinstance(value, dict):
        for key, inner in value.items():
            yield key
            yield from keys(inner)


@pytest.mark.parametrize("name", ["water_dispenser", "microwave", "kettle"])
def test_no_half_width_of_an_interaction_is_given(name: str) -> None:
    given = load_scenario(name, physics="ideal").given()["layout"]
    assert not {"reach", "room", "half", "margin"} & set(keys(given))
    json.dumps(given)


def test_a_layout_is_given_without_what_is_marked_as_a_gate() -> None:
    shape = VesselShape(0.18, 0.03, (0.0, 0.0), (0.0, 0.1), (0.015, 0.015, 0.03))
    assert [f.name for f in dataclasses.fields(shape) if f.metadata.get(GATE)] == ["room"]
    assert geometry(shape) == {"height": 0.18, "radius": 0.03, "mouth": (0.0, 0.0), "hand": (0.0, 0.1)}
    assert geometry({"a": 1}) == {"a": 1}
    assert isinstance(shape.grasp(), Region)
