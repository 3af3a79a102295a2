"""What objects ask of their parents: found by roles, and refused with the parent and what it lacks."""

import pytest
from dispenser_scene import HAND

from ichain_drake.errors import InputError
from ichain_drake.objects import Tank, TankSettings
from ichain_drake.objects.parents import hand_among, level_index, only_hand, position_indices
from ichain_drake.objects.touch import TouchRule
from ichain_drake.state import Role, StateSpace, Variable

BUTTON = StateSpace("button", (Variable("travel"), Variable("level", role=Role("level"))))
FLAT = StateSpace(
    "stick", (Variable("y", role=Role("position", "robot", "y")), Variable("x", role=Role("position", "robot", "x")))
)


def test_the_only_parent_is_the_hand() -> None:
    assert only_hand({"hand": HAND}, "it", "a part") == ("hand", HAND)
    for parents in ({}, {"hand": HAND, "other": HAND}):
        with pytest.raises(InputError, match=f"it: a part has one parent, the hand; {len(parents)} given"):
            only_hand(parents, "it", "a part")


def test_a_hand_among_others() -> None:
    assert hand_among(["door", "hand", "dial"], ("dial", "door"), "it", "food") == "hand"
    for names, count in ((["door"], 0), (["door", "hand", "arm"], 2)):
        with pytest.raises(InputError, match=f"it: food has one hand among its parents; {count} given"):
            hand_among(names, ["door"], "it", "food")


def test_positions_are_found_by_their_roles() -> None:
    assert position_indices(FLAT, ("x", "y"), "it") == [1, 0]
    with pytest.raises(InputError, match="it: its parent stick has no position along z"):
        position_indices(FLAT, "xyz", "it")
    with pytest.raises(InputError, match="it: its parent left has no position along z"):
        position_indices(FLAT, "xyz", "it", "left")


def test_levels_are_found_by_their_roles() -> None:
    assert level_index({"power": BUTTON}, "power", "it", "the switch") == 1
    for parents in ({}, {"power": FLAT}):
        with pytest.raises(InputError, match="it: 'power' is to be the switch, but is no parent with a level"):
            level_index(parents, "power", "it", "the switch")


def test_a_tank_names_the_parent_that_has_no_place() -> None:
    giver = StateSpace(
        "jug",
        (Variable("water", role=Role("amount")), Variable("flow", hidden=True), Variable("from_tank", hidden=True)),
    )
    with pytest.raises(InputError, match="tank: its parent jug has no position along x"):
        Tank("tank", {"jug": giver}, tank=TankSettings(drain="", heater=""))


@pytest.mark.parametrize(
    ("force", "before", "holds"), [(0.5, False, False), (0.5, True, True), (1.5, False, True), (0.1, True, False)]
)
def test_a_touch_that_began_needs_less_force_to_last(force: float, before: bool, holds: bool) -> None:
    assert TouchRule(on=1.0, off=0.2).holds(force, before) is holds
