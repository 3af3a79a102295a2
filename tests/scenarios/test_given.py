"""The report says what was declared rather than learned: units, roles, layout, goal."""

import json

from ichain_drake.systems.car_game.scenario import CarGame
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
    assert {"goal", "layout", "start", "mishap", "camera", "camera_shift", "robot"} <= set(given)


def test_what_a_chain_declares_is_given_too():
    given = CarGame((), "ideal").given()
    json.dumps(given, allow_nan=False)
    assert given["graph"]["interactions"] == ["hand->joystick", "joystick->car"]
