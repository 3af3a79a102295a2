"""Which inputs a gate may look at, and which it must not use."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ichain_drake.learning.discovery.inputs import GateInput, caused, gate_inputs
from ichain_drake.learning.discovery.log import Log, RawPiece, make_log
from ichain_drake.learning.discovery.settings import DISCOVERY
from ichain_drake.learning.effects.alignment import Alignment, PositionGroup
from ichain_drake.state import FloatArray, Role, StateSpace, Variable

TURN = np.array([[0.0, 1.0], [-1.0, 0.0]])
ROWS = 12


def place(frame: str, axes: str = "xy") -> tuple[Variable, ...]:
    return tuple(Variable(a, "m", role=Role("position", frame, a)) for a in axes)


def cup() -> StateSpace:
    rest = (
        Variable("water", role=Role("amount")),
        Variable("flow", role=Role("change", of="water")),
        Variable("heat", role=Role("intensive", of="water")),
        Variable("tilt", "rad", kind="angle", role=Role("orientation", "camera", "x")),
        Variable("lid", kind="binary", lower=0.0, upper=1.0),
        Variable("fill", role=Role("level")),
    )
    return StateSpace("cup", (*place("camera"), *rest))


def log(frame: str = "camera", axes: str = "xy") -> Log:
    """A hand, a cup seen by a camera that may be turned, and a lamp."""
    spaces = {
        "hand": StateSpace("hand", place("robot", axes)),
        "cup": StateSpace("cup", tuple(v if v.name not in "xy" else place(frame, v.name)[0] for v in cup().variables)),
        "lamp": StateSpace("lamp", (Variable("on"),)),
    }
    rng = np.random.default_rng(0)
    states = {n: rng.normal(size=(ROWS, len(s))) for n, s in spaces.items()}
    return make_log([RawPiece("p", states)], spaces, "hand", {"camera": TURN})


def by_label(made: Log, *args: Any, **more: Any) -> dict[str, tuple[GateInput, FloatArray]]:
    inputs = gate_inputs(made, *args, **more)
    assert inputs.values.shape[1] == len(inputs.items)
    return {item.label: (item, inputs.values[:, k]) for k, item in enumerate(inputs.items)}


def test_a_gate_looks_at_where_the_parent_is_at_the_end_and_the_child_was_before_the_tick() -> None:
    made = log()
    found = by_label(made, "hand", "cup", None, ["lamp", "cup", "hand"])
    later, earlier = made.t + 1, made.back
    hand, at = made.states["hand"], made.states["cup"][:, :2] @ TURN
    np.testing.assert_array_equal(found["hand at robot x"][1], hand[later, 0])
    np.testing.assert_array_equal(found["cup at camera y"][1], at[earlier, 1])
    np.testing.assert_array_equal(found["lamp.on"][1], made.states["lamp"][later, 0])
    np.testing.assert_array_equal(found["cup.fill"][1], made.states["cup"][earlier, 7])
    np.testing.assert_allclose(found["cup relative to hand, y"][1], (at - hand)[earlier, 1])
    assert set(found) == {
        "hand at robot x", "hand at robot y", "cup relative to hand, x", "cup relative to hand, y", "cup at camera x",
        "cup at camera y", "cup.water", "cup.heat", "cup.tilt", "cup.lid", "cup.fill", "lamp.on",
    }  # fmt: skip


def test_inputs_say_what_they_are_and_what_a_face_costs() -> None:
    found = {k: v[0] for k, v in by_label(log(), "hand", "cup", None).items()}
    assert found["cup relative to hand, x"] == GateInput(
        "hand", "cup relative to hand, x", True, True, (), False, DISCOVERY.face
    )
    assert found["cup at camera x"] == GateInput("cup", "cup at camera x", True, False, (0, 1), False, DISCOVERY.face)
    prices = {k: v.price for k, v in found.items() if k.startswith("cup.")}
    unlikely, face = DISCOVERY.unlikely_face, DISCOVERY.face
    assert prices == {
        "cup.water": unlikely, "cup.heat": unlikely, "cup.tilt": unlikely, "cup.lid": face, "cup.fill": face,
    }  # fmt: skip
    assert {k for k, v in found.items() if v.binary} == {"cup.lid"}
    assert {k: v.variables for k, v in found.items() if k in ("cup.lid", "cup.heat")} == {
        "cup.lid": (6,), "cup.heat": (4,),
    }  # fmt: skip


def test_alone_an_object_looks_at_itself_before_the_tick() -> None:
    made = log()
    found = by_label(made, "cup", "cup", None)
    assert all(k.startswith("cup") and "relative" not in k for k in found)
    np.testing.assert_array_equal(found["cup.heat"][1], made.states["cup"][made.back, 4])


def test_other_rows_may_be_asked_for() -> None:
    made = log()
    rows = np.array([3, 4]), np.array([7, 9])
    found = by_label(made, "hand", "cup", None, ["lamp"], rows=rows)
    np.testing.assert_array_equal(found["hand at robot x"][1], made.states["hand"][[3, 4], 0])
    np.testing.assert_array_equal(found["lamp.on"][1], made.states["lamp"][[3, 4], 0])
    np.testing.assert_array_equal(found["cup.heat"][1], made.states["cup"][[7, 9], 4])


@pytest.mark.parametrize(
    ("frame", "axes", "related"), [("unseen", "xy", False), ("robot", "xy", True), ("camera", "x", False)]
)
def test_places_are_relative_where_both_frames_are_known_with_the_same_axes(
    frame: str, axes: str, related: bool
) -> None:
    found = by_label(log(frame, axes), "hand", "cup", None)
    assert any("relative" in k for k in found) is related
    assert f"cup at {frame} x" in found, "as it is seen, where nothing tells how that is turned"


def test_what_moves_together_is_relative_to_where_it_is_held() -> None:
    made = log()
    p, c = (PositionGroup(f, ("x", "y"), (0, 1)) for f in ("robot", "camera"))
    alignment = Alignment(p, c, (), TURN, np.zeros((2, 0)), np.array([0.1, 0.2]), 20, 0.0)
    found = by_label(made, "hand", "cup", alignment)
    place = alignment.relative(made.states["hand"][made.back], made.states["cup"][made.back])
    np.testing.assert_array_equal(found["cup relative to hand, 0"][1], place[:, 0])
    np.testing.assert_array_equal(found["cup relative to hand, 1"][1], place[:, 1])


def test_inputs_are_found_again_by_their_labels() -> None:
    inputs = gate_inputs(log(), "hand", "cup", None)
    np.testing.assert_array_equal(inputs.at([inputs.items[4], inputs.items[1]]), inputs.values[:, [4, 1]])


@pytest.mark.parametrize(
    ("changed", "barred"), [([0], [True, True, False]), ([1], [True, True, False]), ([2], [False, False, True])]
)
def test_an_amount_and_what_is_dissolved_in_it_change_together(changed: list[int], barred: list[bool]) -> None:
    """An effect on either of them is seen in both, so that neither can tell when it acts."""
    water, heat = Variable("water", role=Role("amount")), Variable("heat", role=Role("intensive", of="water"))
    space = StateSpace("cup", (water, heat, Variable("c")))
    items = [SimpleNamespace(relative=False, place=False, owner="cup", variables=(i,)) for i in range(3)]
    inputs: Any = SimpleNamespace(items=items)
    assert caused(inputs, space, "cup", "hand", changed).tolist() == barred
    assert not caused(inputs, space, "cup", "cup", changed).any(), "what it does alone may depend on itself"


@pytest.mark.parametrize(("axes", "related"), [("xy", True), ("x", False)])
def test_places_say_nothing_where_a_relative_one_says_it_better_and_a_moved_one_never(axes: str, related: bool) -> None:
    made = log(axes=axes)
    inputs = gate_inputs(made, "hand", "cup", None, ["lamp"])

    def barred(*changed: int) -> set[str]:
        mask = caused(inputs, made.spaces["cup"], "cup", "hand", changed)
        return {item.label for item, out in zip(inputs.items, mask, strict=True) if out}

    places = {"hand at robot x", "hand at robot y", "cup at camera x", "cup at camera y"} if related else set()
    assert barred() == places
    assert barred(0) == places | {"cup at camera x", "cup at camera y"}, "what moves along one axis moves"
    assert barred(6) == places | {"cup.lid"}
