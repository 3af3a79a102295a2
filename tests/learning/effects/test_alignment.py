"""Where a child is while it moves with its parent: the frames' turn, from displacements alone."""

import numpy as np
import pandas as pd
import pytest

from ichain_drake.demonstrations import Demonstration
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning.data import collect
from ichain_drake.learning.effects.alignment import (
    Alignment,
    PositionGroup,
    apart,
    frame_turns,
    heading_of,
    learn_alignment,
    position_groups,
)
from ichain_drake.learning.settings import LEARNING
from ichain_drake.state import Role, StateSpace, Variable
from ichain_drake.timing import TICK

POSE = {frame: tuple(Variable(a, "m", role=Role("position", frame, a)) for a in "xyz") for frame in ("robot", "camera")}
GRAPH = InteractionGraph(
    {"hand": StateSpace("hand", POSE["robot"]), "box": StateSpace("box", POSE["camera"])}, ["hand->box"]
)
EDGE = Interaction.parse("hand->box")
NOISE = 5e-4


def carried(seed: int, yaw: float, *, plane: bool) -> list[Demonstration]:
    """A box that is carried about, in a plane or in space, seen by a camera that is turned about the vertical."""
    rng, out = np.random.default_rng(seed), []
    turn = np.array([[np.cos(yaw), -np.sin(yaw), 0.0], [np.sin(yaw), np.cos(yaw), 0.0], [0.0, 0.0, 1.0]])
    for k in range(3):
        hand = np.cumsum(rng.uniform(-0.05, 0.05, (60, 3)) * [1.0, 1.0, not plane], axis=0)
        on = (np.arange(60) > 5) & (np.arange(60) < 50)
        steps = np.diff(hand, axis=0, prepend=hand[:1]) * on[:, None]
        box = np.cumsum(steps, axis=0) @ turn.T + [0.3, -0.2, 0.1]
        table = pd.DataFrame({"time": TICK * np.arange(60), "hand->box": on.astype(float)})
        for name, values in (("hand", hand), ("box", box)):
            table[[f"{name}.{a}" for a in "xyz"]] = values + NOISE * rng.standard_normal((60, 3))
        out.append(Demonstration(table, {}, f"piece_{k}"))
    return out


@pytest.mark.parametrize("plane", [False, True])
@pytest.mark.parametrize("yaw", [0.0, 0.7, -2.0])
def test_the_turn_of_a_camera_is_a_rotation_even_where_motion_in_a_plane_leaves_a_reflection_open(
    yaw: float, plane: bool
) -> None:
    """In a plane noise alone would say which way the third axis points."""
    for seed in range(6):
        data = collect(carried(seed, yaw, plane=plane), GRAPH)
        noise = {n: np.full(3, NOISE) for n in GRAPH.objects}
        found = learn_alignment(data, EDGE, noise)
        assert found is not None
        np.testing.assert_allclose(found.turn @ found.turn.T, np.eye(3), atol=1e-9)
        assert np.linalg.det(found.turn) == pytest.approx(1.0), seed
        c, s = np.cos(yaw), np.sin(yaw)
        np.testing.assert_allclose(found.turn[:2, :2], [[c, -s], [s, c]], atol=0.03)


def test_a_thing_held_off_its_own_origin_goes_around_a_hand_that_turns() -> None:
    """It is held 0.1 m in front of the hand, and moves though that stays; two short pieces show it to a tenth."""
    angle = Variable("yaw", "rad", -np.pi, np.pi, kind="angle", role=Role("orientation", "robot", "z"))
    spaces = {"hand": StateSpace("hand", (*POSE["robot"], angle)), "box": StateSpace("box", POSE["robot"])}
    graph, rng, pieces = InteractionGraph(spaces, ["hand->box"]), np.random.default_rng(0), []
    for k in range(2):
        hand = np.cumsum(rng.uniform(-0.05, 0.05, (60, 3)), axis=0)
        yaw = 0.9 * np.sin(0.15 * np.arange(60) + k)
        box = hand + 0.1 * np.stack([np.cos(yaw), np.sin(yaw), np.zeros(60)], axis=1)
        on = (np.arange(60) > 2).astype(float)
        table = pd.DataFrame({"time": TICK * np.arange(60), "hand->box": on, "hand.yaw": yaw})
        for name, values in (("hand", hand), ("box", np.where(on[:, None] > 0, box, box[3]))):
            table[[f"{name}.{a}" for a in "xyz"]] = values + NOISE * rng.standard_normal((60, 3))
        pieces.append(Demonstration(table, {}, f"piece_{k}"))
    found = learn_alignment(collect(pieces, graph), EDGE, {"hand": np.full(4, NOISE), "box": np.full(3, NOISE)})
    assert found is not None
    turns = np.array([[0.3, 0.2, 0.1, yaw] for yaw in (-0.8, 0.0, 0.8)])
    there = found.place(turns)
    np.testing.assert_allclose(there[2] - there[0], [0.0, 0.2 * np.sin(0.8), 0.0], atol=0.02)
    np.testing.assert_allclose(there[1] - there[0], 0.1 * np.array([1 - np.cos(0.8), np.sin(0.8), 0.0]), atol=0.012)
    np.testing.assert_allclose(there[1], [0.4, 0.2, 0.1], atol=0.012)


def rotation(yaw: float) -> np.ndarray:
    return np.array([[np.cos(yaw), -np.sin(yaw), 0.0], [np.sin(yaw), np.cos(yaw), 0.0], [0.0, 0.0, 1.0]])


def of_frames(parent: str, child: str, turn: np.ndarray, rows: int = 20) -> Alignment:
    p, c = (PositionGroup(frame, ("x", "y", "z"), (0, 1, 2)) for frame in (parent, child))
    return Alignment(p, c, (), turn, np.zeros((3, 0)), np.array([1.0, 2.0, 3.0]), rows, 0.0)


def test_positions_are_grouped_by_frame_with_their_axes_in_order() -> None:
    space = StateSpace(
        "box",
        (
            Variable("height", role=Role("position", "table", "z")),
            Variable("column", role=Role("position", "image", "x")),
            Variable("left", role=Role("position", "table", "x")),
            Variable("heading", "rad", kind="angle", role=Role("orientation", "table", "z")),
            Variable("tilt", "rad", kind="angle", role=Role("orientation", "table", "y")),
            Variable("heat"),
        ),
    )
    assert position_groups(space) == [
        PositionGroup("table", ("x", "z"), (2, 0)), PositionGroup("image", ("x",), (1,)),
    ]  # fmt: skip
    assert heading_of(space, "table") == 3
    assert heading_of(space, "image") is None


def test_where_a_child_is_besides_where_its_parent_would_have_it_is_told_along_the_parents_axes() -> None:
    p, c = PositionGroup("robot", ("x", "y"), (0, 1)), PositionGroup("camera", ("x", "y"), (1, 2))
    turn, sway = np.array([[0.0, -1.0], [1.0, 0.0]]), np.array([[0.5, 0.0], [0.0, 0.5]])
    found = Alignment(p, c, (2,), turn, sway, np.array([10.0, 20.0]), 20, 0.0)
    parent = np.array([3.0, 4.0, np.pi / 2])
    np.testing.assert_allclose(found.place(parent), [-4.0 + 10.0, 3.0 + 0.5 + 20.0], atol=1e-12)
    child = np.array([99.0, 6.0 + 0.1, 23.5 + 0.2])
    np.testing.assert_allclose(found.relative(parent, child), [0.2, -0.1], atol=1e-12)


def test_frames_are_turned_into_the_roots_along_what_is_known_of_most() -> None:
    spaces = {n: StateSpace(n, tuple(Variable(a, role=Role("position", n, a)) for a in "xyz")) for n in "abcd"}
    edges = {
        Interaction("b", "c"): of_frames("b", "c", rotation(0.4)),
        Interaction("a", "b"): of_frames("a", "b", rotation(0.3)),
        Interaction("a", "c"): of_frames("a", "c", rotation(9.0), rows=5),
        Interaction("a", "d"): None,
    }
    turns = frame_turns(spaces, "a", edges)
    assert sorted(turns) == ["a", "b", "c"]
    np.testing.assert_array_equal(turns["a"], np.eye(3))
    there = np.array([1.0, 0.0, 0.0])
    np.testing.assert_allclose(turns["b"], rotation(0.3))
    np.testing.assert_allclose((rotation(0.4) @ rotation(0.3) @ there) @ turns["c"], there, atol=1e-12)
    between = apart(spaces["b"], spaces["c"], turns)
    assert between is not None
    np.testing.assert_allclose(between.turn, rotation(0.4), atol=1e-12)
    assert (between.rows, between.unexplained, between.angles) == (0, 1.0, ())
    np.testing.assert_array_equal(between.shift, np.zeros(3))
    assert apart(spaces["b"], spaces["d"], turns) is None, "nobody knows how it is turned"
    assert apart(spaces["d"], spaces["b"], turns) is None
    itself = apart(spaces["d"], spaces["d"], turns)
    assert itself is not None
    np.testing.assert_array_equal(itself.turn, np.eye(3))
    flat = StateSpace("flat", spaces["b"].variables[:2])
    assert apart(spaces["b"], flat, turns) is None, "of other axes"
    assert apart(spaces["b"], StateSpace("lamp", (Variable("on"),)), turns) is None, "it is nowhere"


def learned(hand: np.ndarray, box: np.ndarray, on: np.ndarray, camera: str = "robot") -> Alignment | None:
    """Of one piece, with the box seen in this frame."""
    spaces = {"hand": StateSpace("hand", POSE["robot"]), "box": StateSpace("box", POSE[camera])}
    table = pd.DataFrame({"time": TICK * np.arange(len(on)), "hand->box": on.astype(float)})
    for name, values in (("hand", hand), ("box", box)):
        table[[f"{name}.{a}" for a in "xyz"]] = values
    graph = InteractionGraph(spaces, ["hand->box"])
    data = collect([Demonstration(table, {}, "piece")], graph, known=[EDGE])
    return learn_alignment(data, EDGE, {n: np.full(3, NOISE) for n in spaces})


def ways(seed: int = 0, n: int = 60) -> tuple[np.ndarray, np.ndarray]:
    hand = np.cumsum(np.random.default_rng(seed).uniform(-0.05, 0.05, (n, 3)), axis=0)
    return hand, (np.arange(n) > 1) & (np.arange(n) < n - 2)


def test_what_does_not_go_along_is_not_aligned() -> None:
    hand, on = ways()
    shift = np.array([0.3, -0.2, 0.1])
    found = learned(hand, hand + shift, on)
    assert found is not None
    np.testing.assert_array_equal(found.turn, np.eye(3))
    np.testing.assert_allclose(found.shift, shift, atol=1e-9)
    assert found.rows == on.sum() - LEARNING.ticks, "displacements from tick to tick, all within the interaction"
    assert found.unexplained < 1e-6
    assert learned(hand, ways(1)[0], on) is None, "it goes its own way"
    assert learned(hand, hand + shift, np.zeros(60, dtype=bool)) is None, "it never acts"
    assert learned(hand, hand + shift, np.arange(60) < LEARNING.ticks) is None, "for too short"


@pytest.mark.parametrize(("share", "together"), [(0.9, True), (1.1, False)])
def test_some_of_the_motion_may_be_left(share: float, together: bool) -> None:
    """The other way at random: so large a share of the squared motion is nothing of the parent's."""
    hand, on = ways(n=400)
    left = share * LEARNING.together
    rng = np.random.default_rng(5)
    own = np.cumsum(rng.uniform(-0.05, 0.05, hand.shape), axis=0) * np.sqrt(left / (1.0 - left))
    found = learned(hand, hand + own, on)
    assert (found is not None) is together
    if found is not None:
        assert found.unexplained == pytest.approx(left, rel=0.1)


def test_two_that_stand_still_together_are_aligned_if_they_are_seen_in_one_frame() -> None:
    on = np.ones(60, dtype=bool)
    place = np.array([0.3, -0.2, 0.1])
    box = np.where(np.arange(60)[:, None] == 3, 9.0, place)  # one odd reading
    found = learned(np.ones((60, 3)), box, on)
    assert found is not None
    assert (found.rows, found.unexplained) == (0, 0.0)
    np.testing.assert_allclose(found.place(np.ones(3)), place)
    assert learned(np.ones((60, 3)), box, on, "camera") is None, "how the camera is turned, nobody knows"


def test_a_few_odd_rows_change_neither_the_turn_nor_that_they_are_together() -> None:
    hand, on = ways()
    box = hand @ rotation(0.7).T
    box[[10, 30]] += 0.5  # read somewhere else for a tick
    found = learned(hand, box, on, "camera")
    assert found is not None
    np.testing.assert_allclose(found.turn, rotation(0.7), atol=1e-3)
    assert found.unexplained < 0.01


def test_of_other_axes_the_turn_is_any_linear_map() -> None:
    """A slide that is moved along one axis goes by half as much as the hand."""
    slide = StateSpace("slide", (Variable("x", role=Role("position", "rail", "x")),))
    graph = InteractionGraph({"hand": StateSpace("hand", POSE["robot"]), "box": slide}, ["hand->box"])
    hand, on = ways()
    table = pd.DataFrame({"time": TICK * np.arange(60), "hand->box": on.astype(float), "box.x": 2.0 + 0.5 * hand[:, 1]})
    table[[f"hand.{a}" for a in "xyz"]] = hand
    data = collect([Demonstration(table, {}, "piece")], graph)
    found = learn_alignment(data, EDGE, {"hand": np.full(3, NOISE), "box": np.full(1, NOISE)})
    assert found is not None
    np.testing.assert_allclose(found.turn, [[0.0, 0.5, 0.0]], atol=1e-9)
    np.testing.assert_allclose(found.shift, [2.0], atol=1e-9)
    spaces = {n: StateSpace(n, (Variable("x"),)) for n in ("hand", "box")}
    table = table.drop(columns=["hand.y", "hand.z"])
    nowhere = collect([Demonstration(table, {}, "piece")], InteractionGraph(spaces, ["hand->box"]))
    assert learn_alignment(nowhere, EDGE, {n: np.full(1, NOISE) for n in spaces}) is None, "neither has a place"
