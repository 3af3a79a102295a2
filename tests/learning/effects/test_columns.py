"""Inputs that an effect may use, built from kinds and roles."""

from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ichain_drake.graph import Interaction
from ichain_drake.learning.effects.alignment import Alignment, PositionGroup
from ichain_drake.learning.effects.columns import Column, candidate_columns
from ichain_drake.learning.settings import LEARNING
from ichain_drake.state import FloatArray, Role, StateSpace, Variable

PARENT, NEXT, CHILD = (np.array([v]) for v in ([5.0, 2.0], [4.0, 3.0], [2.0, 1.0]))
"""An amount and what is dissolved in it: one unit left the parent."""


def offered(spaces: dict[str, StateSpace], values: FloatArray, alignment: Alignment | None = None) -> list[Column]:
    parent, child = spaces
    data: Any = SimpleNamespace(
        spaces=spaces,
        variables={n: tuple(range(len(s))) for n, s in spaces.items()},
        stacked=lambda obj: values[:, : len(spaces[obj])],
    )
    return candidate_columns(
        data, Interaction(parent, child), alignment, {n: np.full(len(s), 0.01) for n, s in spaces.items()}
    )


def shift_along(axes: Sequence[int], onto: Sequence[int], turn: FloatArray) -> Alignment:
    p, c = (PositionGroup("table", tuple("xyz"[: len(i)]), tuple(i)) for i in (axes, onto))
    return Alignment(p, c, (), turn, np.zeros((len(onto), 0)), np.full(len(onto), 7.0), 20, 0.0)


def test_a_turn_of_the_parent_may_turn_the_child_and_nothing_else_does() -> None:
    pose = (Variable("x", "m"), Variable("yaw", "rad", kind="angle", role=Role("orientation", "table", "z")))
    spaces = {n: StateSpace(n, (*pose, Variable("heat"))) for n in ("hand", "box")}
    columns = offered(spaces, np.random.default_rng(0).normal(size=(9, 3)))
    changes = {c.index: c for c in columns if c.source == "parent_change"}
    assert {i: c.turns for i, c in changes.items()} == {0: (), 1: (1,), 2: ()}
    assert {i: c.wrap for i, c in changes.items()} == {0: False, 1: True, 2: False}
    assert [v for v in range(3) if changes[1].declares(v)] == [1]
    assert not any(changes[i].declares(v) for i in (0, 2) for v in range(3))
    assert not any(c.declares(v) for c in columns if c.source in ("parent", "child") for v in range(3))


def test_states_and_changes_are_read_at_their_tick() -> None:
    assert Column("parent", "", 1)(PARENT, NEXT, CHILD) == pytest.approx([3.0])
    assert Column("child", "", 1)(PARENT, NEXT, CHILD) == pytest.approx([1.0])
    assert Column("parent_change", "", 1)(PARENT, NEXT, CHILD) == pytest.approx([1.0])
    assert Column("parent", "", 0, "cos")(PARENT, NEXT, CHILD) == pytest.approx([np.cos(4.0)])
    assert Column("child", "", 0, "sin")(PARENT, NEXT, CHILD) == pytest.approx([np.sin(2.0)])


@pytest.mark.parametrize(
    ("now", "then", "change"), [(3.1, -3.1, 2 * np.pi - 6.2), (-3.1, 3.1, 6.2 - 2 * np.pi), (0.2, 0.5, 0.3)]
)
def test_a_change_of_an_angle_goes_the_short_way_round(now: float, then: float, change: float) -> None:
    before, after = np.array([[now]]), np.array([[then]])
    assert Column("parent_change", "", 0, wrap=True)(before, after, CHILD) == pytest.approx([change])
    assert Column("parent_change", "", 0)(before, after, CHILD) == pytest.approx([then - now])


def test_motion_with_the_parent_is_told_along_the_axes_of_the_child() -> None:
    turned = shift_along((0, 1), (1, 0), np.array([[0.0, -1.0], [1.0, 0.0]]))
    columns = [Column("aligned_change", "", k, alignment=turned) for k in (0, 1)]
    assert [float(c(PARENT, NEXT, CHILD)[0]) for c in columns] == pytest.approx([-1.0, -1.0])
    assert [float(c(PARENT, NEXT + [[0.5, 0.0]], CHILD)[0]) for c in columns] == pytest.approx([-1.0, -0.5])
    assert [[c.declares(v) for v in (0, 1)] for c in columns] == [[False, True], [True, False]]


def test_what_leaves_the_parent_is_received_and_what_comes_back_is_not_but_for_noise() -> None:
    column = Column("received", "", 0, mixes=(-1, 1, -1), floor=0.1)
    assert column(PARENT, NEXT, CHILD) == pytest.approx([1.0])
    least = LEARNING.clear * 0.1
    for back, received in ((0.9 * least, -0.9 * least), (1.1 * least, 0.0)):
        assert column(PARENT, PARENT + [[back, 0.0]], CHILD) == pytest.approx([received])
    assert [column.declares(v) for v in (0, 1, -1)] == [False, True, False]


def test_what_is_received_mixes_by_volume() -> None:
    """One unit at 3 comes to two at 1: the mixture is at 5/3."""
    column = Column("mixing", "", 0, mixes=(1, 0, 1), floor=1e-6)
    assert column(PARENT, NEXT, CHILD) == pytest.approx([2.0 / 3.0])
    assert column(PARENT, NEXT, np.array([[0.0, 1.0]])) == pytest.approx([2.0]), "into an empty one it goes as it is"
    assert column(PARENT, NEXT, np.array([[-0.5, 1.0]])) == pytest.approx([2.0]), "less than nothing is noise"
    assert column(PARENT, PARENT + [[1.0, 0.0]], CHILD) == pytest.approx([0.0]), "what comes back mixes nothing"
    assert [column.declares(v) for v in (0, 1)] == [False, True]
    faint = LEARNING.faint * 0.5  # as much noise as there is in the child: the share fades to a half
    column = Column("mixing", "", 0, mixes=(1, 0, 1), floor=0.5)
    parent, child = np.array([[faint, 3.0]]), np.array([[0.0, 1.0]])
    assert column(parent, parent * [[0.0, 1.0]], child) == pytest.approx([1.0])


def test_readings_leave_open_what_is_mixed_with_little() -> None:
    column = Column("mixing", "", 0, mixes=(1, 0, 1), floor=0.1)
    for amount, total in ((2.0, 2.0), (0.2, 0.2), (0.01, 0.1), (-3.0, 0.1)):
        variance = column.variance(PARENT, NEXT, np.array([[amount, 1.0]]))
        assert variance == pytest.approx([(0.1 / total * 2.0) ** 2])
    assert Column("received", "", 0, mixes=(-1, 1, -1), floor=0.1).variance(PARENT, NEXT, CHILD).tolist() == [0.0]


def vessel(name: str, *, unit: str = "K") -> StateSpace:
    return StateSpace(
        name,
        (
            Variable("amount", "l", role=Role("amount")),
            Variable("heat", unit, role=Role("intensive", of="amount")),
            Variable("flow", "l/s", role=Role("change", of="amount")),
            Variable("lid"),
        ),
    )


def test_an_amount_is_offered_as_received_and_its_properties_as_mixing() -> None:
    values = np.random.default_rng(0).normal(size=(9, 4))
    columns = offered({"jug": vessel("jug"), "cup": vessel("cup")}, values)
    assert [(c.source, c.index) for c in columns] == [
        ("received", 0),
        ("mixing", 0),
        *(("parent", 0), ("parent", 1), ("parent_change", 1), ("parent", 3), ("parent_change", 3)),
        *(("child", 0), ("child", 1), ("child", 3)),
    ], "a change of the amount is what is received; what is declared as a change is none of its own"
    assert [c.mixes for c in columns[:2]] == [(-1, 0, -1), (1, 0, 1)]
    assert [c.floor for c in columns[:2]] == pytest.approx([0.01 * np.sqrt(2.0)] * 2)
    assert [c.label for c in columns[:4]] == [
        "received from parent amount", "mixing of parent heat with child heat", "parent amount", "parent heat",
    ]  # fmt: skip
    other = offered({"jug": vessel("jug", unit="g/l"), "cup": vessel("cup")}, values)
    assert [c.source for c in other].count("mixing") == 0, "of different units nothing is mixed"


def test_along_an_alignment_a_change_of_position_is_not_offered_twice() -> None:
    spaces = {n: StateSpace(n, tuple(Variable(a, "m") for a in ("x", "y", "z"))) for n in ("hand", "box")}
    columns = offered(spaces, np.zeros((9, 3)), shift_along((0, 2), (1, 2), np.eye(2)))
    assert [(c.source, c.index) for c in columns] == [
        ("aligned_change", 0), ("aligned_change", 1), ("parent", 0), ("parent", 1), ("parent_change", 1), ("parent", 2),
        ("child", 0), ("child", 1), ("child", 2),
    ]  # fmt: skip
    assert columns[1].label == "motion with parent along child's z"


@pytest.mark.parametrize(("span", "views"), [(3.0, ["plain"]), (3.3, ["plain", "cos", "sin"])])
def test_an_angle_is_seen_as_a_number_unless_it_goes_further_than_a_half_turn(span: float, views: list[str]) -> None:
    """Also where it goes on beyond where it wraps."""
    values = (np.linspace(3.0, 3.0 + span, 30)[:, None] + np.pi) % (2 * np.pi) - np.pi
    spaces = {n: StateSpace(n, (Variable("yaw", "rad", kind="angle"),)) for n in ("hand", "box")}
    columns = offered(spaces, values)
    assert [c.view for c in columns if c.source == "parent"] == views
    assert [c.view for c in columns if c.source == "child"] == views
    assert [c.label for c in columns if c.source == "child"] == [
        {"plain": "child yaw"}.get(v, f"{v}(child yaw)") for v in views
    ]
    assert all(c.wrap for c in columns if c.source == "parent")
