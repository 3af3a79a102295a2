"""What was beside something is beside it again, wherever it stands and however it is turned."""

from types import SimpleNamespace

import numpy as np
import pytest

from ichain_drake.control.planning import options
from ichain_drake.control.planning.frames import Frames
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning.effects.alignment import Alignment, position_groups
from ichain_drake.state import Role, StateSpace, Variable

TURN = np.array([[0.0, 1.0], [-1.0, 0.0]])  # p_jug = TURN @ p_robot: a quarter turn


def place(frame, *more):
    return tuple(Variable(a, "m", role=Role("position", frame, a)) for a in "xy") + more


def model(*, relative=True):
    heading = Variable("turn", "rad", -np.pi, np.pi, "angle", Role("orientation", "camera", "z"))
    spaces = {
        "robot": StateSpace("robot", (*(Variable(a, "m", -1, 1, role=Role("position", "base", a)) for a in "xy"),)),
        "jug": StateSpace("jug", place("camera", Variable("water"))),
        "stove": StateSpace("stove", place("camera", heading)),
        "lamp": StateSpace("lamp", (Variable("light"),)),
    }
    graph = InteractionGraph(spaces, ["robot->jug", "jug->stove", "robot->lamp"])
    groups = {n: next(iter(position_groups(s)), None) for n, s in spaces.items()}
    held = Alignment(groups["robot"], groups["jug"], (), TURN, np.zeros((2, 0)), np.array([0.1, 0.0]), 20, 0.0)
    edges = {
        Interaction("robot", "jug"): SimpleNamespace(alignment=held, relative=True),
        Interaction("jug", "stove"): SimpleNamespace(alignment=None, relative=relative),
        Interaction("robot", "lamp"): SimpleNamespace(alignment=None, relative=False),
    }
    return SimpleNamespace(graph=graph, edges=edges)


def test_an_object_goes_and_turns_with_what_it_is_relative_to():
    frames = Frames(model())
    jug, stove = np.array([1.0, 0.0, 0.7]), np.array([0.5, 0.0, 0.0])
    moved = frames.along("jug", jug, "stove", stove, np.array([0.0, 2.0, np.pi / 2]))
    np.testing.assert_allclose(moved, [0.0, 2.5, 0.7], atol=1e-12)
    back = frames.along("jug", moved, "stove", np.array([0.0, 2.0, np.pi / 2]), stove)
    np.testing.assert_allclose(back, jug, atol=1e-12)


def test_what_stands_beside_something_stays_as_high_as_it_stands():
    high = tuple(Variable(a, "m", role=Role("position", "room", a)) for a in "xyz") + (Variable("water"),)
    spaces = {n: StateSpace(n, high) for n in ("robot", "jug", "stove")}
    graph = InteractionGraph(spaces, ["robot->jug", "jug->stove"])
    edges = {e: SimpleNamespace(alignment=None, relative=True) for e in graph.interactions}
    frames = Frames(SimpleNamespace(graph=graph, edges=edges))
    jug, then, now = np.array([[1.0, 2.0, 3.0, 0.7]] * 2), np.zeros(4), np.array([10.0, 20.0, 30.0, 5.0])
    np.testing.assert_allclose(frames.along("jug", jug, "stove", then, now), [[11.0, 22.0, 33.0, 0.7]] * 2)
    np.testing.assert_allclose(frames.beside("jug", jug, "stove", then, now), [[11.0, 22.0, 3.0, 0.7]] * 2)


def test_the_robot_goes_with_what_it_holds_along_its_own_axes():
    frames = Frames(model())
    was, now = np.zeros(3), np.array([0.3, 0.0, 0.0])
    np.testing.assert_allclose(frames.along("robot", np.zeros((4, 2)), "jug", was, now), np.tile([0.0, 0.3], (4, 1)))
    assert frames.is_carried("jug")
    assert not frames.is_carried("lamp")


def test_what_has_no_position_leaves_things_as_they_are():
    frames, robot = Frames(model()), np.array([0.4, 0.2])
    np.testing.assert_array_equal(frames.along("robot", robot, "lamp", np.zeros(1), np.ones(1)), robot)
    assert not frames.goes_with(Interaction("robot", "lamp"))


@pytest.mark.parametrize(("relative", "anchors"), [(True, ("stove",)), (False, ())])
def test_places_are_relative_to_what_a_status_looks_at(relative, anchors):
    assert Frames(model(relative=relative)).anchors("jug") == anchors


def test_how_far_an_object_can_be_taken_follows_from_the_robots_bounds():
    low, high = Frames(model()).reach("jug")
    np.testing.assert_allclose(low[:2], [-0.9, -1.0])
    np.testing.assert_allclose(high[:2], [1.1, 1.0])
    assert np.isnan(low[2])
    assert Frames(model()).reach("lamp") is None


def test_a_place_is_in_reach_within_bounds_and_shown_within_what_was_shown():
    learned = model()
    learned.low, learned.high = {"jug": np.array([0.0, 0.0, 0.1])}, {"jug": np.array([1.0, 2.0, 0.2])}
    frames = Frames(learned)
    robots = np.array([[0.0, 0.0], [1.0, -1.0], [1.01, 0.0]])
    np.testing.assert_array_equal(frames.in_reach("robot", robots), [True, True, False])
    learned.low["robot"], learned.high["robot"] = np.array([0.0, -1.0]), np.array([0.3, 1.0])
    np.testing.assert_array_equal(frames.in_reach("robot", robots, nearly=True), True)
    np.testing.assert_array_equal(frames.in_reach("robot", np.array([[1.02, 0.0]]), nearly=True), False)
    jugs = np.array([[-0.9, 1.0, 9.0], [1.14, 1.09, 0.0], [1.16, 0.0, 0.0], [0.0, 1.11, 0.0]])
    np.testing.assert_array_equal(frames.in_reach("jug", jugs), [True, True, False, False])
    assert frames.in_reach("lamp", np.ones((2, 1))).all()
    jugs = np.array([[0.5, 0.5, 9.0], [1.01, 0.0, 0.1], [1.03, 0.0, 0.1], [0.5, -0.1, 0.1]])
    np.testing.assert_array_equal(frames.is_shown("jug", jugs), [True, True, False, False])


@pytest.mark.parametrize(("followed", "anchor"), [((0, 1), "stove"), ((0, 1, 2), "stove"), ((2,), None)])
def test_only_what_can_be_brought_somewhere_is_held_beside_it(followed, anchor):
    """A knob that turns in the hand but stays at its place goes to no food: drives by it hold where they were shown."""
    learned = model()
    carry = SimpleNamespace(follow=np.array(followed))
    chain = (Interaction("robot", "jug"), Interaction("jug", "stove"))
    assert options._anchor(Frames(learned), chain, carry) == anchor


def room(*, heading=True, rows=0, frame="room"):
    """A hand, a jug and a stove that are all seen in one frame, or the jug in another; all may turn."""
    turn = (Variable("turn", "rad", -np.pi, np.pi, "angle", Role("orientation", frame, "z")),) if heading else ()
    spaces = {
        "hand": StateSpace("hand", place("room")),
        "jug": StateSpace("jug", place(frame, *turn)),
        "stove": StateSpace(
            "stove", place("room", Variable("turn", "rad", kind="angle", role=Role("orientation", "room", "z")))
        ),
    }
    graph = InteractionGraph(spaces, ["hand->jug", "jug->stove"])
    p, c = (next(iter(position_groups(spaces[n]))) for n in ("jug", "stove"))
    two = Alignment(p, c, (), np.eye(2), np.zeros((2, 0)), np.zeros(2), rows, 0.0) if rows or frame != "room" else None
    edges = {
        Interaction("hand", "jug"): SimpleNamespace(alignment=None, relative=True),
        Interaction("jug", "stove"): SimpleNamespace(alignment=two, relative=True),
    }
    return Frames(SimpleNamespace(graph=graph, edges=edges))


JUG, STOVE, TURNED = np.array([2.0, 1.0, 0.3]), np.array([1.0, 1.0, 0.2]), np.array([5.0, 5.0, 0.2 + 0.5])


def test_what_stands_beside_a_thing_that_turned_turns_with_it():
    c, s = np.cos(0.5), np.sin(0.5)
    found = room().along("jug", JUG, "stove", STOVE, TURNED)
    np.testing.assert_allclose(found, [5.0 + c, 5.0 + s, 0.8])
    over = room().along("jug", JUG, "stove", STOVE, np.array([5.0, 5.0, 0.2 + 3.0]))
    np.testing.assert_allclose(over[2], 3.3 - 2 * np.pi)
    plain = room(heading=False).along("jug", JUG[:2], "stove", STOVE, TURNED)
    np.testing.assert_allclose(plain, [5.0 + c, 5.0 + s])
    many = room().along("jug", np.tile(JUG, (3, 1)), "stove", STOVE, np.array([TURNED, STOVE, TURNED]))
    np.testing.assert_allclose(many, [found, JUG, found])
    np.testing.assert_array_equal(JUG, [2.0, 1.0, 0.3], "what is handed in stays")


@pytest.mark.parametrize("how", [{"rows": 20}, {"frame": "other"}])
def test_what_goes_along_as_it_is_held_or_is_seen_elsewhere_is_shifted_alone(how):
    found = room(**how).along("jug", JUG, "stove", STOVE, TURNED)
    np.testing.assert_allclose(found, [6.0, 5.0, 0.3])


def test_what_sways_as_the_robot_turns_reaches_a_little_further():
    learned = model()
    edge = Interaction("robot", "jug")
    held = learned.edges[edge].alignment
    sway = np.array([[0.3, -0.1], [0.0, 0.2]])
    learned.edges[edge].alignment = Alignment(held.parent, held.child, (0,), held.turn, sway, held.shift, 20, 0.0)
    low, high = Frames(learned).reach("jug")
    np.testing.assert_allclose(low[:2], [-0.9 - 0.4, -1.0 - 0.2])
    np.testing.assert_allclose(high[:2], [1.1 + 0.4, 1.0 + 0.2])
    bounds = learned.graph.objects["robot"].variables
    open_ = StateSpace("robot", (Variable("x", "m", role=bounds[0].role), bounds[1]))
    graph = InteractionGraph({**learned.graph.objects, "robot": open_}, [e.name for e in learned.graph.interactions])
    assert Frames(SimpleNamespace(graph=graph, edges=learned.edges)).reach("jug") is None, "without an end"


def test_what_says_where_an_object_is_and_what_its_places_are_relative_to():
    frames = Frames(model())
    assert frames.has_place("jug", [0, 2])
    assert not frames.has_place("jug", [2])
    assert not frames.has_place("jug", [])
    assert frames.anchors("stove") == ("jug",), "the robot is none"
    assert frames.goes_with(Interaction("jug", "stove"))
    assert not Frames(model(relative=False)).goes_with(Interaction("jug", "stove"))
    assert not Frames(model(relative=False)).is_relative(Interaction("jug", "stove"))
