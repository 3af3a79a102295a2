"""What nobody said the looks of: a block at its place, turned as it is, lit while it is on."""

from typing import Any

import numpy as np
import pytest
from pydrake.math import RigidTransform

from ichain_drake.state import Role, StateSpace, Variable
from ichain_drake.visualization.plain_drawing import PlainDrawing, places

X, Y = (Variable(a, "m", role=Role("position", "room", a)) for a in "xy")
TURN = Variable("theta", "rad", -np.pi, np.pi, "angle", Role("orientation", "room"))
ON = Variable("pressed", kind="binary", lower=0, upper=1)


class Noted:
    """Takes the place of a scene, and notes what it is told."""

    def __init__(self) -> None:
        self.shapes: list[str] = []
        self.poses: dict[str, RigidTransform] = {}
        self.colors: dict[str, Any] = {}

    def shape(self, path: str, *more: object) -> None:
        self.shapes.append(path)

    def pose(self, path: str, pose: RigidTransform, time: float) -> None:
        self.poses[path] = pose

    def color(self, path: str, rgb: Any, time: float) -> None:
        self.colors[path] = tuple(rgb)


def drawn(space: StateSpace, *states: list[float]) -> Noted:
    scene, drawing = Noted(), PlainDrawing("it", space, 0.2)
    drawing.setup(scene)  # type: ignore[arg-type]
    for state in states:
        drawing.update(scene, 0.0, np.array(state))  # type: ignore[arg-type]
    return scene


def test_it_is_where_it_is_and_turned_as_it_is() -> None:
    scene = drawn(StateSpace("it", (ON, TURN, Y, X)), [0.0, 0.5, 2.0, 1.0])
    assert scene.shapes == ["it/block", "it/nose"]
    np.testing.assert_allclose(scene.poses["it"].translation(), [1.0, 2.0, 0.05])  # on the floor
    np.testing.assert_allclose(scene.poses["it"].rotation().matrix()[:2, 0], [np.cos(0.5), np.sin(0.5)])


def test_it_is_lit_while_it_is_on() -> None:
    space = StateSpace("it", (X, Y, ON))
    off, on = (drawn(space, [0.0, 0.0, value]).colors["it/block"] for value in (0.0, 1.0))
    assert off != on
    assert drawn(space, [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]).colors["it/block"] == off
    assert drawn(StateSpace("it", (X, Y)), [0.0, 0.0]).colors == {}


def test_a_place_is_by_role_or_by_name() -> None:
    assert places(StateSpace("it", (Y, X))) == {1: 0, 0: 1}
    assert places(StateSpace("it", (Variable("x"), Variable("z"), Variable("speed")))) == {0: 0, 2: 1}
    assert places(StateSpace("it", (Variable("x", role=Role("level")),))) == {}
    with pytest.raises(ValueError, match="it has no position to be drawn at"):
        PlainDrawing("it", StateSpace("it", (Variable("speed"),)), 0.1)
