"""What was learned of objects, under other names."""

from dataclasses import replace
from typing import Any

import numpy as np

from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning.effects.alignment import Alignment, PositionGroup
from ichain_drake.learning.renaming import _input, renamed, seen_by
from ichain_drake.learning.status.customary import Customary
from ichain_drake.learning.status.events import EdgeExamples, Switching
from ichain_drake.learning.status.inputs import DifferenceInput, PlaceInput, RelativeInput, ValueInput
from ichain_drake.learning.status.status import always_active
from ichain_drake.learning.tick import LearnedInteraction
from ichain_drake.state import Role, StateSpace, Variable


def test_a_difference_is_named_by_the_variables_that_it_is_of() -> None:
    spaces = {n: StateSpace(n, (Variable("a"), Variable("b"), Variable("c"))) for n in ("hand", "box")}
    graph = InteractionGraph(spaces, ["hand->box"])
    old = DifferenceInput("arm", "crate", (0, 2), False, "crate.c - arm.a")
    found = _input(old, {"arm": "hand", "crate": "box"}, graph)
    assert isinstance(found, DifferenceInput)
    assert (found.parent, found.child, found.index, found.label) == ("hand", "box", (0, 2), "box.c - hand.a")


PLACE = tuple(Variable(a, role=Role("position", "room", a)) for a in "xy")
SPACES = {
    "hand": StateSpace("hand", PLACE),
    "box": StateSpace("box", PLACE),
    "lamp": StateSpace("lamp", (Variable("p"), Variable("on"))),
}
HERE = InteractionGraph(SPACES, ["hand->box", "hand->lamp", "lamp->box"])
GROUP = PositionGroup("room", ("x", "y"), (0, 1))
NAMES = {"arm": "hand", "crate": "box", "light": "lamp"}


def beside() -> RelativeInput:
    two = Alignment(GROUP, GROUP, (), np.eye(2), np.zeros((2, 0)), np.zeros(2), 20, 0.0)
    return RelativeInput(Interaction("arm", "crate"), two, "old")


def switching(row: int) -> Switching:
    states = {n: np.full((1, 2), float(row)) for n in ("arm", "crate", "cat")}
    return Switching(states, states, ("p",), (row,))


def learned() -> Any:
    inputs = (beside(), PlaceInput("crate", GROUP, np.eye(2), "old"), ValueInput("light", 1, "old", True, 0.5))
    cat, place = ValueInput("cat", 0, "cat.x"), PlaceInput("crate", GROUP, np.eye(2), "old")
    customary = Customary((place, cat, ValueInput("light", 0, "old")), np.arange(4.0), np.arange(4.0) + 0.5)
    states = {n: np.zeros((3, 2)) for n in ("arm", "crate", "cat")}
    return LearnedInteraction(
        replace(always_active(9), inputs=inputs), customary, (), None,
        EdgeExamples(switching(1), switching(2), states, {n: v + 1.0 for n, v in states.items()}),
        np.zeros(2), np.ones(2), np.zeros(2),
    )  # fmt: skip


def test_who_decides_a_status_is_told() -> None:
    assert seen_by(learned()) == {"arm", "crate", "light"}
    assert learned().relative


def test_inputs_look_at_their_counterparts_and_say_so() -> None:
    old, new = learned(), renamed(learned(), NAMES, HERE)
    relative, place, value = new.status.inputs
    assert [i.label for i in new.status.inputs] == ["position of box relative to hand", "position of box", "lamp.on"]
    assert (relative.edge, place.obj, value.obj) == (Interaction("hand", "box"), "box", "lamp")
    assert (value.index, value.angle, value.middle) == (1, True, 0.5)
    rng = np.random.default_rng(0)
    there = {n: rng.normal(size=(4, 2)) for n in NAMES}
    here = {NAMES[n]: v for n, v in there.items()}
    for a, b in zip(old.status.inputs, new.status.inputs, strict=True):
        np.testing.assert_array_equal(a(there), b(here))
    assert seen_by(new) == {"hand", "box", "lamp"}


def test_customary_conditions_on_what_has_no_counterpart_are_left_out_with_their_ranges() -> None:
    found = renamed(learned(), NAMES, HERE).customary
    assert found.labels == ("position of box", "lamp.p")
    assert (found.low.tolist(), found.high.tolist()) == ([0.0, 1.0, 3.0], [0.5, 1.5, 3.5])


def test_examples_are_of_the_counterparts_alone() -> None:
    found = renamed(learned(), NAMES, HERE).examples
    for states in (found.active, found.inactive, found.activations.before, found.deactivations.after):
        assert set(states) == {"hand", "box"}
    assert (found.activations.rows, found.deactivations.rows) == ((1,), (2,))
    assert found.activations.after["box"].tolist() == [[1.0, 1.0]]
    assert found.deactivations.before["hand"].tolist() == [[2.0, 2.0]]
    assert (found.active["box"].sum(), found.inactive["hand"].tolist()) == (0.0, [[1.0, 1.0]] * 3)
