"""Where the robot has to be for what it carries to be somewhere: exact for a rigid body on a lever."""

from types import SimpleNamespace

import numpy as np
import pytest

from ichain_drake.control.planning.slope import led
from ichain_drake.graph import Interaction, InteractionGraph
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
