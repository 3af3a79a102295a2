"""Where the robot has to be for what it carries to be somewhere: exact for a rigid body on a lever."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ichain_drake.control.planning.slope import independent, least_motion, led, slope
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning.settings import LEARNING
from ichain_drake.state import FloatArray, StateSpace, Variable

EDGE = Interaction("hand", "cup")
_SPACE = StateSpace("body", (Variable("x", "m"), Variable("y", "m"), Variable("turn", "rad", kind="angle")))
SLACK = np.array([0.005, 0.005, 0.01])


def _turned(by: FloatArray, lever: FloatArray) -> FloatArray:
    c, s = np.cos(by), np.sin(by)
    return np.stack([c * lever[..., 0] - s * lever[..., 1], s * lever[..., 0] + c * lever[..., 1]], axis=-1)


def _rigid(edge: Interaction, states: dict[str, FloatArray], parent_next: FloatArray) -> FloatArray:
    hand, cup = np.asarray(states["hand"]), np.asarray(states["cup"])
    by = parent_next[..., 2] - hand[..., 2]
    lever = cup[..., :2] - hand[..., :2]
    return np.concatenate([parent_next[..., :2] + _turned(by, lever) - cup[..., :2], by[..., None]], axis=-1)


MODEL = SimpleNamespace(
    graph=InteractionGraph({"hand": _SPACE, "cup": _SPACE}, ["hand->cup"]),
    step_limit={"hand": np.array([0.04, 0.04, 0.2])},
    effect=_rigid,
    edges={EDGE: SimpleNamespace(active_step=np.ones(3))},
)
START = {"hand": np.array([0.1, 0.2, 0.3]), "cup": np.array([0.25, 0.24, 0.5])}


def test_a_straight_way_is_gone_as_a_whole() -> None:
    goal, whole = led(MODEL, EDGE, START, np.array([0.4, -0.3, 0.0]), SLACK)  # type: ignore[arg-type]
    assert whole
    np.testing.assert_allclose(goal - START["hand"], [0.4, -0.3, 0.0], atol=1e-6)


@pytest.mark.parametrize("turn", [-1.9, 0.5, 1.9])
def test_what_is_turned_stays_where_it_is_all_the_way(turn: float) -> None:
    now, stretches, wanted = dict(START), 0, np.array([0.0, 0.0, turn])
    while True:
        goal, whole = led(MODEL, EDGE, now, wanted - (now["cup"] - START["cup"]), SLACK)  # type: ignore[arg-type]
        for share in np.linspace(0, 1, 9):
            cup = now["cup"] + _rigid(EDGE, now, now["hand"] + share * (goal - now["hand"]))
            assert np.abs(cup - START["cup"])[:2].max() < 2 * SLACK[0]
        now = {"hand": goal, "cup": now["cup"] + _rigid(EDGE, now, goal)}
        stretches += 1
        if whole:
            break
    assert 1 + (abs(turn) > 1) <= stretches < 20
    np.testing.assert_allclose(now["cup"] - START["cup"], wanted, atol=1e-3)


def test_what_may_move_does_not_hold_up_the_rest() -> None:
    goal, whole = led(MODEL, EDGE, START, np.array([np.nan, np.nan, 1.9]), SLACK)  # type: ignore[arg-type]
    assert whole
    assert goal[2] - START["hand"][2] == pytest.approx(1.9, abs=1e-6)


def test_what_can_not_be_reached_is_gone_for_as_long_as_that_comes_nearer() -> None:
    """A spring that gives way: from 2/3 of its stiffness on every push leads back, and Newton's second step far off."""
    space, edge = StateSpace("body", (Variable("x", "m"),)), Interaction("hand", "cup")

    def yields(edge: Interaction, states: dict[str, FloatArray], parent_next: FloatArray) -> FloatArray:
        def force(x: FloatArray) -> FloatArray:
            return 10.0 * (x - x**3 / 3)

        return force(np.asarray(parent_next)) - force(np.asarray(states["hand"]))

    model = SimpleNamespace(
        graph=InteractionGraph({"hand": space, "cup": space}, ["hand->cup"]),
        step_limit={"hand": np.array([1e-4])},
        effect=yields,
        edges={edge: SimpleNamespace(active_step=np.ones(1))},
    )
    start = {"hand": np.zeros(1), "cup": np.zeros(1)}
    goal, whole = led(model, edge, start, np.array([9.0]), np.array([0.1]))  # type: ignore[arg-type]
    assert whole
    np.testing.assert_allclose(goal, [0.9], rtol=1e-3)  # 6.57 of 9; the next step would be to 2.2
    reached = led(model, edge, start, np.array([6.0]), np.array([0.1]))[0]  # type: ignore[arg-type]
    np.testing.assert_allclose(10.0 * (reached - reached**3 / 3), [6.0], rtol=1e-2)


def shown(rows: list[dict[str, list[float]]]) -> SimpleNamespace:
    """The same with these states shown."""
    active = {n: np.array([r[n] for r in rows]).reshape(-1, 3) for n in ("hand", "cup")}
    edge = SimpleNamespace(active_step=np.ones(3), examples=SimpleNamespace(active=active))
    return SimpleNamespace(graph=MODEL.graph, step_limit=MODEL.step_limit, effect=_rigid, edges={EDGE: edge})


def test_what_one_motion_changes_together_can_not_be_changed_one_by_one() -> None:
    held = {n: v.tolist() for n, v in START.items()}
    free: Any = shown([held])
    assert independent(free, EDGE, [0, 1, 2])
    assert independent(shown([]), EDGE, [0, 1, 2]), "of what was never shown nothing is known"  # type: ignore[arg-type]
    slide: Any = shown([held])
    slide.effect = lambda edge, states, after: (after - states["hand"])[..., [0, 0, 2]] * [1.0, 3.0, 1.0]
    assert not independent(slide, EDGE, [0, 1])
    assert not independent(slide, EDGE, [0, 1, 2])
    assert independent(slide, EDGE, [0, 2])
    assert independent(slide, EDGE, [1])
    small: Any = shown([held])
    small.effect = lambda edge, states, after: (after - states["hand"]) * [1.0, 1e-6, 1.0]
    assert independent(small, EDGE, [0, 1]), "whatever it is measured in"


def test_it_is_asked_of_a_state_in_the_middle_of_what_was_shown() -> None:
    """At either end the slide is stuck."""
    rows = [{"hand": [x, 0.0, 0.0], "cup": [0.0, 0.0, 0.0]} for x in (0.0, 1.0, 2.0)]
    stuck: Any = shown(rows)
    stuck.effect = lambda edge, states, after: (after - states["hand"]) * (states["hand"][..., :1] == 1.0)
    assert independent(stuck, EDGE, [0, 1])


@pytest.mark.parametrize("shown_step", [1.0, 0.0])
def test_pushes_are_as_large_as_a_step_and_small_where_no_step_was_shown(shown_step: float) -> None:
    jaw = StateSpace("hand", (*_SPACE.variables[:2], Variable("jaw", kind="binary", lower=0.0, upper=1.0)))
    model: Any = SimpleNamespace(
        graph=InteractionGraph({"hand": jaw, "cup": _SPACE}, ["hand->cup"]),
        step_limit={"hand": np.array([0.04, 0.02, 1.0])},
        effect=lambda edge, states, after: 2.0 * (after - states["hand"]) + 0.5,
        edges={EDGE: SimpleNamespace(active_step=np.array([shown_step, 1.0, 1.0]))},
    )
    size, by_push = slope(model, EDGE, START)
    first = 0.04 if shown_step else 0.04 * LEARNING.near
    np.testing.assert_allclose(size, [first, 0.02, 0.0])
    np.testing.assert_allclose(by_push, np.diag([2.0 * first, 0.04, 0.0]), atol=1e-12)


def test_the_least_motion_is_the_shortest_that_makes_the_change() -> None:
    by_push = np.array([[1.0, 0.0], [1.0, 0.0], [0.0, 1e-6]])
    np.testing.assert_allclose(least_motion(by_push, np.array([2.0, 0.0])), [1.0, 1.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(least_motion(by_push, np.array([2.0, 1.0])), [1.0, 1.0, 0.0], atol=1e-12)
