"""Straight ways in demonstrated steps, and where the robot is out of the way."""

from __future__ import annotations

import numpy as np
import pytest
from toy_models import GRIP, LAMP_START, X, lamp

from ichain_drake.control.planning.travel import jumping, parked_state, step_towards
from ichain_drake.state import StateSpace, Variable

SPACE = StateSpace("robot", (X, Variable("turn", "rad", -np.pi, np.pi, "angle"), GRIP))
LIMIT = np.array([0.1, 0.5, 0.0])


def test_a_way_is_gone_in_as_few_equal_steps_as_the_limits_allow() -> None:
    rng = np.random.default_rng(0)
    for _ in range(50):
        now, goal = (np.array([rng.uniform(-1, 1), rng.uniform(-3, 3), g]) for g in (0.0, 1.0))
        way = SPACE.difference(goal, now)
        count = int(np.ceil(max(abs(way[0]) / 0.1, abs(way[1]) / 0.5)))
        at, steps = now, []
        for k in range(count):
            before = at
            at, there = step_towards(SPACE, at, goal, LIMIT)
            steps.append(SPACE.difference(at, before)[:2])
            assert there == (k == count - 1)
            assert at[2] == float(there), "the grip changes on arrival"
        np.testing.assert_array_equal(at, goal)
        np.testing.assert_allclose(steps, np.tile(way[:2] / count, (count, 1)), atol=1e-9)


def test_just_a_step_is_one_step() -> None:
    goal = np.array([0.1, 0.0, 1.0])
    np.testing.assert_array_equal(step_towards(SPACE, np.zeros(3), goal, LIMIT)[0], goal)
    assert step_towards(SPACE, np.zeros(3), np.zeros(3), LIMIT)[1]
    assert not step_towards(SPACE, np.zeros(3), np.array([0.1001, 0.0, 0.0]), LIMIT)[1]


def test_what_is_beyond_the_robots_bounds_is_gone_to_as_far_as_they_allow() -> None:
    """Else it would never be there."""
    room = StateSpace("robot", (Variable("x", "m", 0.0, 1.0),))
    at, there = step_towards(room, np.array([0.95]), np.array([1.7]), np.array([0.1]))
    assert there
    np.testing.assert_array_equal(at, [1.0])


def test_what_jumps() -> None:
    assert jumping(SPACE).tolist() == [False, False, True]


@pytest.mark.parametrize("dimmer", [0.0, 1.0])
def test_it_parks_where_it_acts_on_nothing_as_surely_as_possible(dimmer: float) -> None:
    """The surest of the states in which something was let go of in a demonstration."""
    model = lamp()
    states = {**LAMP_START, "dimmer": np.array([dimmer])}
    mine = [e for e in model.graph.interactions if e.parent == "robot"]

    def surest(robot: np.ndarray) -> float:
        return max(float(model.decide(e, {**states, "robot": robot})) for e in mine)

    robots = np.concatenate([r.examples.deactivations.after["robot"] for r in model.edges.values()])
    found = parked_state(model, states)
    assert any((found == r).all() for r in robots)
    assert surest(found) == min(map(surest, robots)) < 0
