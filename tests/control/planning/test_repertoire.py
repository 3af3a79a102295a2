"""Of all that can be done: what concerns some objects, and what may be carried."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

from ichain_drake.control.planning.borders import Border
from ichain_drake.control.planning.plan import Condition, Goal
from ichain_drake.control.planning.repertoire import Repertoire
from ichain_drake.graph import Interaction

KNOB, CUP, WIND = Interaction("hand", "knob"), Interaction("hand", "cup"), Interaction("knob", "shade")


def drive(*chain: Interaction, motion: object = None, variable: int = 0) -> Any:
    return SimpleNamespace(chain=chain, motion=motion, variable=variable, carry=None)


CARRIES: Any = tuple(SimpleNamespace(edge=e) for e in (KNOB, CUP))
DRIVES = (drive(KNOB, WIND, motion="round"), drive(KNOB, motion="on and on", variable=1), drive(CUP))
BORDERS = (Border("cup", 0, 0.5, CUP), Border("shade", 0, 0.5, WIND))
ALL = Repertoire(CARRIES, DRIVES, BORDERS, {}, {"knob": ("x", "angle"), "shade": ("height",), "cup": ("water",)})


def goal(obj: str, variable: str) -> Goal:
    return Goal((Condition(obj, variable, 0.0, 1.0),), ())


def test_only_what_acts_on_some_objects_is_left() -> None:
    cup = ALL.about(["cup"], goal("cup", "water"))
    assert (cup.carries, cup.drives, cup.borders) == (CARRIES[1:], DRIVES[2:], BORDERS[:1])
    assert cup.names is ALL.names


def test_an_object_is_turned_on_and_on_only_where_the_goal_is_about_that() -> None:
    both = ["knob", "shade"]
    assert ALL.about(both, goal("knob", "angle")).drives == DRIVES[:2]
    assert ALL.about(both, goal("knob", "x")).drives == DRIVES[:1]
    assert ALL.about(both, goal("shade", "height")).drives == DRIVES[:1]


def test_what_drives_something_by_its_motion_is_carried_only_for_its_own_sake() -> None:
    assert ALL.movable(["shade"]) == CARRIES[1:]
    assert ALL.movable(["knob", "shade"]) == CARRIES
    assert ALL.about(["knob"], goal("knob", "angle")).movable([]) == CARRIES[:1], "nothing else is driven here"


def test_what_is_driven_by_what_is_not_among_the_objects_is_left_out_too() -> None:
    """A thing in hand is put down, whatever else could be done to it by another that is carried."""
    carried = drive(CUP, Interaction("cup", "pot"))
    carried.carry = CARRIES[1]
    tools = replace(ALL, drives=(*DRIVES, carried), names={**ALL.names, "pot": ("water",)})
    assert tools.about(["cup", "pot"], goal("pot", "water")).drives == (DRIVES[2], carried)
    assert tools.about(["pot"], goal("pot", "water")).drives == ()
