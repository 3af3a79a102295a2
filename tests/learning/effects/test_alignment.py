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
