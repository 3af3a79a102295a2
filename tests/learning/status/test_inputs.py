"""What a status may look at: by roles, in the axes that mean something, and once."""

from dataclasses import replace

import numpy as np
import pytest

from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning.data import GraphData, Piece
from ichain_drake.learning.effects.alignment import Alignment, apart
from ichain_drake.learning.status.inputs import (
    BodyInput,
    DifferenceInput,
    PlaceInput,
    RelativeInput,
    ValueInput,
    candidate_inputs,
)
from ichain_drake.state import Role, StateSpace, Variable

EDGE = Interaction("hand", "box")


def place(frame: str, *, yaw: bool = False) -> tuple[Variable, ...]:
    turn = Variable("yaw", "rad", -np.pi, np.pi, "angle", Role("orientation", frame, "z"))
    return (*(Variable(a, "m", role=Role("position", frame, a)) for a in "xy"), *((turn,) if yaw else ()))


def data(hand: tuple[Variable, ...], box: tuple[Variable, ...]) -> GraphData:
    """Two rows of a hand, a box and a lamp that acts on it too."""
    spaces = {
        "hand": StateSpace("hand", (*hand, Variable("heat", "degC", role=Role("level")))),
        "box": StateSpace("box", (*box, Variable("warm", "degC", role=Role("level")))),
        "lamp": StateSpace("lamp", (*place("world"), Variable("light"))),
    }
    graph = InteractionGraph(spaces, ["hand->box", "hand->lamp", "lamp->box"])
    states = {n: np.arange(2.0 * len(s)).reshape(2, -1) / 10 for n, s in spaces.items()}
    piece = Piece("p", states, {e: np.array([True, False]) for e in graph.interactions})
    return GraphData(graph, spaces, (piece,), graph.interactions, {n: tuple(range(len(s))) for n, s in spaces.items()})


def ends(found: GraphData, alignment: Alignment | None = None) -> tuple[list, list]:
    return candidate_inputs(found, EDGE, {e: alignment if e == EDGE else None for e in found.edges})


@pytest.mark.parametrize(("hand", "box", "of_child"), [(True, True, True), (True, False, False), (False, True, True)])
def test_beside_what_can_be_turned_places_are_along_its_axes_the_childs_first(
    hand: bool, box: bool, of_child: bool
) -> None:
    (first, *_), _ = ends(data(place("world", yaw=hand), place("world", yaw=box)))
    assert isinstance(first, BodyInput)
    assert (first.of_child, first.heading) == (of_child, 2)
    assert first.label == "position of box relative to hand"


def test_beside_what_can_not_be_turned_or_goes_along_they_are_along_the_parents() -> None:
    made = data(place("world"), place("world"))
    (first, *_), _ = ends(made)
    assert isinstance(first, RelativeInput) and not isinstance(first, BodyInput)
    turned = data(place("world", yaw=True), place("world", yaw=True))
    still = apart(turned.spaces["hand"], turned.spaces["box"], {})
    assert still is not None
    going = Alignment(still.parent, still.child, (), still.turn, still.sway, still.shift, 40, 0.1)
    (first, *_), _ = ends(turned, going)
    assert isinstance(first, RelativeInput) and not isinstance(first, BodyInput)


def test_both_ends_and_their_likes_are_looked_at_and_of_the_others_all_but_where_the_robot_is() -> None:
    made = data(place("world"), place("camera"))
    own, others = ends(made)
    assert [i.label for i in own] == [
        "position of hand", "hand.heat", "position of box", "box.warm", "box.warm - hand.heat",
    ]  # fmt: skip
    assert [type(i) for i in own] == [PlaceInput, ValueInput, PlaceInput, ValueInput, DifferenceInput]
    assert [i.label for i in others] == ["position of lamp", "lamp.light"]
    np.testing.assert_allclose(own[-1]({n: made.pieces[0].states[n] for n in made.spaces}), [[0.0], [0.0]])


def test_places_of_a_frame_whose_turn_is_known_are_along_the_robots_axes() -> None:
    made = data(place("world"), place("camera"))
    quarter = np.array([[0.0, -1.0], [1.0, 0.0]])
    groups = [apart(s, s, {}) for s in (made.spaces["hand"], made.spaces["box"])]
    assert groups[0] is not None and groups[1] is not None
    camera = Alignment(groups[0].parent, groups[1].child, (), quarter, np.zeros((2, 0)), np.zeros(2), 40, 0.1)
    own, _ = ends(made, camera)
    seen = next(i for i in own if i.label == "position of box")
    states = {"box": np.array([[1.0, 2.0, 0.0]])}
    np.testing.assert_allclose(seen(states), states["box"][:, :2] @ quarter)
    hand = next(i for i in own if i.label == "position of hand")
    np.testing.assert_allclose(hand({"hand": np.array([[1.0, 2.0, 0.0]])}), [[1.0, 2.0]])


def test_angles_are_told_the_short_way_round_from_where_they_usually_are() -> None:
    states = {"box": np.array([[-3.0, 1.0], [3.1, 2.0]]), "hand": np.array([[3.0], [-3.1]])}
    angle = ValueInput("box", 0, "box.yaw", True, 3.0)
    np.testing.assert_allclose(angle(states), [[2 * np.pi - 6.0], [0.1]])
    np.testing.assert_allclose(ValueInput("box", 1, "box.x", False, 3.0)(states), [[1.0], [2.0]])
    apart_ = DifferenceInput("hand", "box", (0, 0), True, "box.yaw - hand.yaw")
    np.testing.assert_allclose(apart_(states), [[2 * np.pi - 6.0], [6.2 - 2 * np.pi]])
    np.testing.assert_allclose(DifferenceInput("hand", "box", (0, 1), False, "")(states), [[-2.0], [5.1]])


@pytest.mark.parametrize("of_child", [False, True])
def test_a_place_beside_what_is_turned_turns_with_it(*, of_child: bool) -> None:
    """A camera sees the box a quarter turned; who is turned himself by a quarter has what was beside him before him."""
    hand, box = StateSpace("hand", place("world", yaw=True)), StateSpace("box", place("camera", yaw=True))
    quarter = np.array([[0.0, -1.0], [1.0, 0.0]])
    beside = apart(hand, box, {"world": np.eye(2), "camera": quarter})
    assert beside is not None
    item = BodyInput(EDGE, beside, "", 2, of_child)
    states = {"hand": np.array([[1.0, 2.0, 0.0]]), "box": np.array([[-1.0, 5.0, 0.0]])}
    off = states["box"][:, :2] - states["hand"][:, :2] @ beside.turn.T
    plain = off if of_child else off @ beside.turn
    np.testing.assert_allclose(item(states), plain)
    turned = {n: v + [0.0, 0.0, np.pi / 2] for n, v in states.items()}
    x, y = plain[0]
    np.testing.assert_allclose(item(turned), [[y, -x]], atol=1e-12)
    third = {n: v + [0.0, 0.0, 0.3] for n, v in states.items()}
    c, s = np.cos(0.3), np.sin(0.3)
    np.testing.assert_allclose(item(third), [[c * x + s * y, c * y - s * x]])


def test_what_stands_beside_a_body_is_so_wherever_and_however_that_stands() -> None:
    """Two that stood still together, the child off by (1, 2): moved and turned together they are as they were."""
    made = data(place("world", yaw=True), place("world"))
    spaces = made.spaces
    beside = apart(spaces["hand"], spaces["box"], {"world": np.eye(2)})
    assert beside is not None
    (first, *_), _ = ends(made, replace(beside, shift=np.array([1.0, 2.0])))
    assert isinstance(first, BodyInput)
    here = {"hand": np.array([[0.5, 0.4, 0.2, 0.0]]), "box": np.array([[1.5, 2.4, 0.0]])}
    c, s = np.cos(0.9), np.sin(0.9)
    off = np.array([[c, -s], [s, c]]) @ (here["box"][0, :2] - here["hand"][0, :2])
    there = {"hand": np.array([[-3.0, 2.0, 1.1, 0.0]]), "box": np.array([[-3.0 + off[0], 2.0 + off[1], 0.0]])}
    np.testing.assert_allclose(first(there), first(here))


def test_an_angle_is_told_from_the_middle_of_what_was_shown_and_likes_are_compared_by_what_they_are() -> None:
    made = data(place("world", yaw=True), place("camera", yaw=True))
    for piece in made.pieces:
        piece.states["hand"][:, 2] = [3.0, -3.1]
    own, _ = ends(made)
    (yaw,) = [i for i in own if i.label == "hand.yaw"]
    assert isinstance(yaw, ValueInput)
    assert yaw.middle == pytest.approx((3.0 + 2 * np.pi - 3.1) / 2)
    likes = [(i.index, i.angle) for i in own if isinstance(i, DifferenceInput)]
    assert likes == [((2, 2), True), ((3, 3), False)], "a heading with a heading, a level with a level"
    tilted = (*place("world"), Variable("tilt", "rad", -np.pi, np.pi, "angle", Role("orientation", "world", "x")))
    own, _ = ends(data(tilted, place("camera", yaw=True)))
    assert [i.index for i in own if isinstance(i, DifferenceInput)] == [(3, 3)], "a tilt is no heading"


@pytest.mark.parametrize(("axes", "along_body"), [("xyz", True), ("xz", False)])
def test_only_what_has_both_axes_of_the_plane_is_along_what_is_turned_in_it(axes: str, *, along_body: bool) -> None:
    turn = Variable("yaw", "rad", -np.pi, np.pi, "angle", Role("orientation", "world", "z"))
    pose = (*(Variable(a, "m", role=Role("position", "world", a)) for a in axes), turn)
    (first, *_), _ = ends(data(pose, pose))
    assert isinstance(first, RelativeInput)
    assert isinstance(first, BodyInput) is along_body


def test_where_the_robot_is_matters_to_what_it_acts_on_alone_whatever_it_is_called() -> None:
    made = data(place("world"), place("camera"))
    lamp = Interaction("lamp", "box")
    found = candidate_inputs(made, lamp, dict.fromkeys(made.edges))[1]
    assert [i.label for i in found] == ["hand.heat"], "its place is left out"
    hand = candidate_inputs(made, EDGE, dict.fromkeys(made.edges))[1]
    assert [i.label for i in hand] == ["position of lamp", "lamp.light"]
