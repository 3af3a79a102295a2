"""Probes of the oven's interactions: on both sides of each border, near it, and where things can be."""

from functools import cache

import numpy as np
import pytest
from oven_pieces import oven, oven_pieces

from ichain_drake.graph import Interaction
from ichain_drake.scenarios.probes import Probes
from ichain_drake.systems.microwave.layout import LAYOUT
from ichain_drake.systems.microwave.scenario import BUTTON, DOOR, FOOD, HAND, KNOB, Microwave

COUNT = 30
SCENARIO = oven()
PARTS = {DOOR: LAYOUT.door, BUTTON: LAYOUT.button, KNOB: LAYOUT.knob}


@cache
def probes(parent: str, child: str) -> Probes:
    made = SCENARIO.probes(Interaction(parent, child), oven_pieces(), COUNT)
    assert made is not None
    return made


def check_sides(away: np.ndarray, active: np.ndarray) -> None:
    """Distances from a region's middle in half-widths: at most 1 inside, up to 1.5 outside."""
    assert (away[active] <= 1 + 1e-9).all()
    assert ((away[~active] > 1) & (away[~active] <= 1.5 + 1e-9)).all()


def within(p: Probes, start: float, end: float, name: str, variable: int, border: str) -> None:
    """Probes of a border along one coordinate."""
    chosen = np.array(p.border) == border
    values = p.true[name][chosen, variable]
    check_sides(np.abs(values - (start + end) / 2) / ((end - start) / 2), p.active[chosen])


@pytest.mark.parametrize("part", list(PARTS))
def test_a_hand_beside_a_part(part: str) -> None:
    p = probes(HAND, part)
    assert p.active.sum() == (~p.active).sum() == COUNT
    assert set(p.border) == {HAND}
    points = np.array([PARTS[part].point] * len(p.active))
    if part != KNOB:
        axis = "xyz".index(PARTS[part].axis)
        points[:, axis] += p.true[part][:, axis]
    check_sides(np.abs((p.true[HAND][:, :3] - points) / PARTS[part].reach).max(axis=1), p.active)
    assert (p.true[HAND][:, -1] == 1.0).all()
    assert 0 < np.abs(p.read[HAND][:, :3] - p.true[HAND][:, :3]).max() < 0.005
    assert 0.8 < np.mean(p.gate == p.active) <= 1.0


def test_a_hand_beside_food_and_behind_the_door() -> None:
    p = probes(HAND, FOOD)
    assert p.active.sum() == (~p.active).sum() == 2 * COUNT
    food = SCENARIO.food_settings()
    by_hand = np.array(p.border) == HAND
    places = SCENARIO.camera().to_robot(p.true[FOOD][:, :3])
    away = np.abs((p.true[HAND][:, :3] - places) / food.grasp.half).max(axis=1)
    check_sides(away[by_hand], p.active[by_hand])
    assert (away[~by_hand] <= 1 + 1e-9).all()  # the door alone is in the way
    within(p, food.oven.open_from, LAYOUT.door.travel, DOOR, 1, DOOR)


@pytest.mark.parametrize("parent", [KNOB, BUTTON])
def test_heating_has_the_borders_of_door_and_button(parent: str) -> None:
    p, oven = probes(parent, FOOD), SCENARIO.food_settings().oven
    assert set(p.border) == {DOOR, BUTTON}
    assert p.active.sum() == (~p.active).sum() == 2 * COUNT
    within(p, 0.0, oven.shut_until, DOOR, 1, DOOR)
    within(p, oven.on_from, LAYOUT.button.travel, BUTTON, 0, BUTTON)


def test_food_over_the_doorstep_is_in_no_wall_and_the_door_is_open() -> None:
    p, food = probes(DOOR, FOOD), SCENARIO.food_settings()
    x = SCENARIO.camera().to_robot(p.true[FOOD][:, :3])[:, 0]
    check_sides(np.abs(x - food.oven.cavity.center[0]) / food.oven.cavity.half[0], p.active)
    assert (x[~p.active] < food.oven.cavity.center[0]).all()
    assert (p.true[DOOR][:, 1] >= food.oven.open_from).all()


def test_by_contact_a_hand_has_no_near_misses_and_unseen_interactions_have_none() -> None:
    contact = Microwave((), "contact")
    made = {e.name: contact.probes(e, oven_pieces(), 5) is not None for e in contact.graph.interactions}
    assert made == {e.name: e.parent != HAND for e in contact.graph.interactions}
    assert SCENARIO.probes(Interaction(HAND, FOOD), [], 5) is None
