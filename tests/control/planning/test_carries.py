"""What follows the robot: there and back, not by itself, by more than noise, and for good once it is let go.

And where that can be put: where it was let go of, and in the middle of where it stood while something acted.
"""

from types import SimpleNamespace
from typing import Any

import numpy as np
from toy_models import TAP_START, tap

from ichain_drake.control.planning.carries import _followers, find_carries
from ichain_drake.control.planning.goals import parse_goal
from ichain_drake.control.planning.plan import Plan
from ichain_drake.control.planning.planner import GraphPlanner
from ichain_drake.control.settings import PLANNING
from ichain_drake.graph import Interaction
from ichain_drake.learning.settings import LEARNING
from ichain_drake.state import FloatArray

HOLD = Interaction("hand", "cup")
FALL, TAKE, PRESS = Interaction("tank", "cup"), Interaction("robot", "cup"), Interaction("robot", "tap")
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


def never_let_go_below_the_tap() -> Any:
    """The tap, whose cup was let go of at 0 and 0.5 alone, and stood below it when something ran."""
    model: Any = tap()
    let_go = model.edges[TAKE].examples.deactivations.after
    elsewhere = let_go["cup"][:, 0] < 0.9
    for name in let_go:
        let_go[name] = let_go[name][elsewhere]
    return model


def stand(model: Any, *xs: float) -> None:
    """While water ran, the cup stood there."""
    active = model.edges[FALL].examples.active
    for name in active:
        active[name] = np.repeat(active[name][:1], len(xs), axis=0)
    active["cup"][:, 0] = xs
    active["robot"][:] = [2.0, 0.0]


def test_a_thing_is_put_in_the_middle_of_where_it_stood_though_nobody_put_it_there() -> None:
    model = never_let_go_below_the_tap()
    stand(model, 0.97, 0.99, 1.03)
    (carry,) = find_carries(model)
    np.testing.assert_allclose(carry.places[:, 0], [0.0, 0.5, 0.99])
    found = GraphPlanner(model).plan(TAP_START, parse_goal(["cup.water >= 0.5"], model, TAP_START))
    assert isinstance(found, Plan)
    assert [s.chain[0] for s in found.steps] == [TAKE, PRESS]
    assert found.steps[0].wanted["cup", "x"] == 0.99


def test_between_two_places_where_it_stood_there_may_be_none() -> None:
    model = never_let_go_below_the_tap()
    model.gates[FALL] = lambda s: 0.05 - np.abs(np.abs(s["cup"][:, 0] - 1.0) - 0.4)
    stand(model, 0.6, 0.61, 1.4, 1.41)
    (carry,) = find_carries(model)
    np.testing.assert_allclose(carry.places[:, 0], [0.0, 0.5])


def test_where_it_was_held_it_did_not_stand() -> None:
    model = never_let_go_below_the_tap()
    stand(model, 0.97, 0.99, 1.03)
    active = model.edges[FALL].examples.active
    active["robot"][:] = np.column_stack([active["cup"][:, 0], np.ones(3)])
    (carry,) = find_carries(model)
    np.testing.assert_allclose(carry.places[:, 0], [0.0, 0.5])
