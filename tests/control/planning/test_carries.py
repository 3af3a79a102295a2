"""What follows the robot: there and back, not by itself, by more than noise, and for good once it is let go."""

from types import SimpleNamespace
from typing import Any

import numpy as np

from ichain_drake.control.planning.carries import _followers
from ichain_drake.control.settings import PLANNING
from ichain_drake.graph import Interaction
from ichain_drake.learning.settings import LEARNING
from ichain_drake.state import FloatArray

HOLD = Interaction("hand", "cup")
KINDS = {
    "goes along": "hold",
    "goes along with another variable, and drifts": "learned",
    "is lost on one way": "hold",
    "comes back almost as far": "hold",
    "comes back hardly": "hold",
    "flows a little by itself": "hold",
    "flows by itself": "hold",
    "is made anew in every tick": "constant",
    "moves less than its readings": "hold",
}


def effect(edge: Interaction, states: dict[str, FloatArray], hand: FloatArray) -> FloatArray:
    first, second = (hand - states["hand"]).T
    there, back = np.maximum(first, 0.0), np.minimum(first, 0.0)
    columns = [
        first,
        -2.0 * second,
        -there,
        there + 0.8 * back,
        there + 0.2 * back,
        first + 0.2 * 0.1,
        first + 0.4 * 0.1,
    ]
    return np.column_stack([*columns, first, 1e-3 * first])


def model(rows: int = 4) -> Any:
    n = len(KINDS)
    samples = {"hand": np.arange(2.0 * rows).reshape(rows, 2), "cup": np.zeros((rows, n))}
    return SimpleNamespace(
        edges={HOLD: SimpleNamespace(examples=SimpleNamespace(active=samples))},
        effect=effect,
        step_limit={"hand": np.array([0.1, 0.1]) / PLANNING.push},
        noise={"cup": np.full(n, 1e-3)},
        low={"cup": np.zeros(n)},
        high={"cup": np.ones(n)},
        passive={"cup": SimpleNamespace(variables=[SimpleNamespace(kind=k) for k in KINDS.values()])},
    )


def test_what_follows_is_told_from_what_is_spilled_flows_or_does_not_stay() -> None:
    assert 0.2 < LEARNING.slight < 0.4  # of what moves, as the cases above are made
    names = list(KINDS)
    assert [names[i] for i in _followers(model(), HOLD)] == [names[k] for k in (0, 1, 3, 5)]


def test_of_what_was_never_held_nothing_follows() -> None:
    assert _followers(model(0), HOLD).tolist() == []
