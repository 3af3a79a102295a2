"""Where a child is while it moves with its parent: the frames' turn, from displacements alone."""

import numpy as np
import pandas as pd
import pytest

from ichain_drake.demonstrations import Demonstration
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning.data import collect
from ichain_drake.learning.effects.alignment import learn_alignment
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
