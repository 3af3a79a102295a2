"""Probes of bottle and kettle: on both sides of each border, near it, and where things can be."""

import numpy as np
from kettle_pieces import kettle, kettle_pieces

from ichain_drake.graph import Interaction
from ichain_drake.objects import Region
from ichain_drake.systems.kettle.layout import LAYOUT
from ichain_drake.systems.kettle.scenario import BOTTLE, HAND, KETTLE, SWITCH, KettleScenario

COUNT = 20
SCENARIO = kettle()


def away(points: np.ndarray, region: Region) -> np.ndarray:
    """Distances from a region's middle in half-widths."""
    share = np.abs((points - region.center) / region.half)
    return np.maximum(np.hypot(share[:, 0], share[:, 1]) if region.round else share[:, :2].max(axis=1), share[:, 2])


def test_every_interaction_has_states_on_both_sides_of_its_borders() -> None:
    camera = SCENARIO.camera()
    regions = {
        (HAND, BOTTLE): LAYOUT.bottle.grasp(), (HAND, KETTLE): LAYOUT.kettle.grasp(),
        (BOTTLE, KETTLE): LAYOUT.pour_region(), (KETTLE, BOTTLE): LAYOUT.return_region(),
    }  # fmt: skip
    for (parent, child), region in regions.items():
        p = SCENARIO.probes(Interaction(parent, child), kettle_pieces(), COUNT)
        assert p is not None
        assert p.active.sum() == (~p.active).sum() == COUNT
        place = p.true[parent][:, :3] if parent == HAND else camera.to_robot(p.true[parent][:, :3])
        apart = away(place - camera.to_robot(p.true[child][:, :3]), region)
        assert (apart[p.active] <= 1 + 1e-9).all(), (parent, child)
        assert ((apart[~p.active] > 1) & (apart[~p.active] <= 1.5 + 1e-9)).all(), (parent, child)
        assert 0 < np.abs(p.read[child][:, :3] - p.true[child][:, :3]).max() < 0.01
        assert 0.8 < np.mean(p.gate == p.active) <= 1.0


def test_the_switch_has_the_borders_of_its_level_and_of_the_plate() -> None:
    p = SCENARIO.probes(Interaction(SWITCH, KETTLE), kettle_pieces(), COUNT)
    assert p is not None
    by_level = np.array(p.border) == SWITCH
    assert set(p.border) == {SWITCH, KETTLE}
    assert set(p.true[SWITCH][by_level & ~p.active, 0]) == {3.0}
    assert (p.true[SWITCH][p.active, 0] > 3).all()
    tips = SCENARIO.camera().to_robot(p.true[KETTLE][:, :3])
    apart = away(tips, LAYOUT.plate_region())
    assert (apart[p.active] <= 1 + 1e-9).all()
    assert (apart[~by_level & ~p.active] > 1).all()
    assert (tips[~by_level, 2] >= LAYOUT.plate.height + LAYOUT.kettle.height - 1e-9).all()  # not in the plate
    pressed = SCENARIO.probes(Interaction(HAND, SWITCH), kettle_pieces(), COUNT)
    assert pressed is not None
    assert (pressed.true[SWITCH][~pressed.active] == 0).all()


def test_by_contact_a_hand_has_no_near_misses() -> None:
    contact = KettleScenario((), "contact")
    made = {e.name: contact.probes(e, kettle_pieces(), 5) is not None for e in contact.graph.interactions}
    assert made == {e.name: e.parent != HAND for e in contact.graph.interactions}
