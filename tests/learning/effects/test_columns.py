"""Inputs that an effect may use, built from kinds and roles."""

from types import SimpleNamespace
from typing import Any

import numpy as np

from ichain_drake.graph import Interaction
from ichain_drake.learning.effects.columns import candidate_columns
from ichain_drake.state import Role, StateSpace, Variable


def test_a_turn_of_the_parent_may_turn_the_child_and_nothing_else_does() -> None:
    pose = (Variable("x", "m"), Variable("yaw", "rad", kind="angle", role=Role("orientation", "table", "z")))
    spaces = {n: StateSpace(n, (*pose, Variable("heat"))) for n in ("hand", "box")}
    values = np.random.default_rng(0).normal(size=(9, 3))
    data: Any = SimpleNamespace(
        spaces=spaces, variables=dict.fromkeys(spaces, (0, 1, 2)), stacked=lambda obj: values
    )  # fmt: skip
    columns = candidate_columns(data, Interaction("hand", "box"), None, {n: np.zeros(3) for n in spaces})
    changes = {c.index: c for c in columns if c.source == "parent_change"}
    assert {i: c.turns for i, c in changes.items()} == {0: (), 1: (1,), 2: ()}
    assert [v for v in range(3) if changes[1].declares(v)] == [1]
    assert not any(changes[i].declares(v) for i in (0, 2) for v in range(3))
