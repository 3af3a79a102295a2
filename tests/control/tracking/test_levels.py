"""One level of control: waypoints, the learned inverse, and prediction against the analytic optimum."""

from dataclasses import dataclass, field, replace

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ichain_drake.control.tracking.levels import InverseLevel, PredictiveLevel, PredictiveWeights, _extend, plan_step
from ichain_drake.control.tracking.tick_model import LinearizedModel
from ichain_drake.demonstrations import Demonstration, collect_transitions
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning.chain.link import EstimatorSpec, InverseSpec, fit_inverse
from ichain_drake.state import FloatArray, StateSpace, Variable
from ichain_drake.timing import TICK

MIXED = StateSpace("s", (Variable("a"), Variable("th", "rad", kind="angle")))
TWO = StateSpace("two", (Variable("a"), Variable("b")))
GAIN = np.array([[1.0, 0.5], [0.0, 2.0]])


@given(seed=st.integers(0, 10**6))
def test_a_wanted_state_is_approached_in_a_straight_line_within_the_limit(seed: int) -> None:
    """In exactly as many ticks as the slowest variable needs; the last waypoint is the wanted state."""
    rng = np.random.default_rng(seed)
    current, wanted = rng.uniform(-3, 3, (2, 1, 2))
    limit = rng.uniform(0.2, 1.0, 2)
    way = MIXED.difference(wanted, current)[0]
    needed = int(np.ceil(np.max(np.abs(way) / limit) - 1e-9))
    state = current
    for _ in range(needed):
        before, state = state, plan_step(MIXED, state, wanted, limit, 1)
        step = MIXED.difference(state, before)[0]
        assert (np.abs(step) <= limit + 1e-9).all()
        assert abs(np.cross(np.append(step, 0), np.append(way, 0))[2]) < 1e-9
    np.testing.assert_allclose(MIXED.difference(state, wanted), 0.0, atol=1e-9)


def test_a_waypoint_may_lie_several_ticks_ahead() -> None:
    current, wanted, limit = np.zeros((1, 2)), np.array([[3.0, 0.0], [0.5, 0.0]]), np.ones(2)
    ahead = plan_step(TWO, np.repeat(current, 2, axis=0), wanted, limit, 2)
    np.testing.assert_allclose(ahead, [[2.0, 0.0], [0.5, 0.0]])


@dataclass(frozen=True)
class Linear(LinearizedModel):
    """child(t + 1) = child(t) + gain parent(t + 1)."""

    gain: FloatArray = field(default_factory=lambda: GAIN)

    def predict(self, child: FloatArray, parent: FloatArray, parent_next: FloatArray) -> FloatArray:
        return child + parent_next @ self.gain.T

    def linearize(
        self, child: FloatArray, parent: FloatArray, parent_next: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        eye, gain = (np.tile(m, (len(child), 1, 1)) for m in (np.eye(2), self.gain))
        return self.predict(child, parent, parent_next), eye, np.zeros_like(eye), gain


def level(
    model: object | None = None, bound: float = 50.0, space: StateSpace = TWO, **weights: float
) -> PredictiveLevel:
    values = {"horizon": 4, "effort": 0.3, "along": 1.0} | weights
    ends = np.full(2, bound)
    scale = np.array([0.7, 0.7])
    return PredictiveLevel(
        model or Linear(), space, (0, 1), scale, -ends, ends, np.array([2.0, 0.5]), PredictiveWeights(**values)
    )  # type: ignore[arg-type]


def decide(
    of: PredictiveLevel, wanted: np.ndarray, parent: np.ndarray | None = None, child: np.ndarray | None = None
) -> np.ndarray:
    n = len(wanted)
    child, parent = np.zeros((n, 2)) if child is None else child, np.zeros((n, 2)) if parent is None else parent
    return of.decide(child, parent, wanted, np.zeros((n, of.memory_size)))[0]


def test_the_linear_quadratic_optimum_is_found() -> None:
    """All ticks' errors and moves written as one least-squares problem, solved in closed form."""
    wanted = np.random.default_rng(0).uniform(-2, 2, (3, 4, 2))
    parent = np.array([[0.5, -0.2]] * 3)
    sums = np.kron(np.tril(np.ones((4, 4))), GAIN) / 0.7
    weight = 0.3 / np.array([2.0, 0.5])
    moves = np.kron(np.eye(4) - np.eye(4, k=-1), np.diag(weight))
    for got, goal, start in zip(decide(level(), wanted, parent), wanted, parent, strict=True):
        right = np.concatenate([goal.ravel() / 0.7, weight * start, np.zeros(6)])
        expected = np.linalg.lstsq(np.concatenate([sums, moves]), right, rcond=None)[0]
        np.testing.assert_allclose(got.ravel(), expected, atol=1e-4)


def test_with_little_effort_the_wanted_states_are_reached_exactly() -> None:
    wanted = np.random.default_rng(1).uniform(-2, 2, (2, 4, 2))
    plan = decide(level(effort=1e-4), wanted)
    np.testing.assert_allclose(np.cumsum(plan @ GAIN.T, axis=1), wanted, atol=1e-3)


def test_the_plan_stays_in_the_box() -> None:
    """A child that has to go far to the upper right: as fast as allowed now, and never faster."""
    plan = decide(level(bound=0.4, effort=1e-3), np.full((1, 4, 2), 100.0))
    assert np.abs(plan).max() <= 0.4
    np.testing.assert_allclose(plan[:, 0], 0.4)


def test_an_error_along_the_motion_counts_less_than_one_across() -> None:
    """A parent that moves the child aside as it moves it on: with `along` small, the child keeps to the line."""
    wanted = np.stack([np.arange(1, 5) * 3.0, np.zeros(4)], axis=1)[None]
    on, aside = {}, {}
    for along in (1.0, 0.05):
        plan = decide(level(Linear(np.array([[1.0, 0.0], [0.5, 0.0]])), effort=0.01, along=along), wanted)
        on[along], aside[along] = np.cumsum(plan[0, :, 0]), np.abs(0.5 * np.cumsum(plan[0, :, 0]))
    assert (aside[0.05] < 0.1 * aside[1.0]).all()
    assert (on[0.05] < on[1.0]).all()


@dataclass(frozen=True)
class Cliff(Linear):
    """Linear where the parent is small; not a number elsewhere."""

    def predict(self, child: FloatArray, parent: FloatArray, parent_next: FloatArray) -> FloatArray:
        after = super().predict(child, parent, parent_next)
        return np.where(np.abs(parent_next).max(axis=-1, keepdims=True) > 1.0, np.nan, after)


def test_a_step_that_makes_it_worse_is_not_taken() -> None:
    plan = decide(level(Cliff(), effort=1e-3), np.full((1, 4, 2), 30.0), np.full((1, 2), 0.2))
    np.testing.assert_allclose(plan, 0.2)


def test_a_decision_starts_from_the_shifted_last_plan() -> None:
    of = level(iterations=0)
    memory = np.concatenate([[1.0], np.arange(8.0)])[None]
    plan, kept = of.decide(np.zeros((1, 2)), np.zeros((1, 2)), np.zeros((1, 4, 2)), memory)
    assert plan[0].tolist() == [[2, 3], [4, 5], [6, 7], [6, 7]]
    np.testing.assert_array_equal(kept[0], np.concatenate([[1.0], plan.ravel()]))
    assert of.memory_size == 9
    assert of.lookahead == 4


def test_missing_wanted_ticks_repeat_the_last() -> None:
    wanted = np.array([[[1.0, 2.0]]])
    np.testing.assert_allclose(decide(level(), wanted), decide(level(), np.repeat(wanted, 4, axis=1)), atol=1e-12)


def test_decisions_do_not_depend_on_where_an_angle_wraps() -> None:
    """The same turn around 0 and around +-pi, with errors along the motion weighted less."""
    space = StateSpace("s", (Variable("a"), Variable("th", "rad", kind="angle")))
    of = level(space=space, along=0.2)
    wanted = np.array([[[0.3, -0.2], [0.6, 0.1], [0.9, 0.4], [1.2, 0.7]]])
    shift = np.array([0.0, np.pi])
    shifted = space.difference(wanted + shift, np.zeros(2))
    assert (np.abs(np.diff(shifted[0, :, 1])) > 3).any()
    child = np.array([[0.0, -0.4]])
    moved = decide(of, shifted, child=space.difference(child + shift, np.zeros(2)))
    np.testing.assert_allclose(moved, decide(of, wanted, child=child), atol=1e-9)


def inverse_level(limit: float) -> InverseLevel:
    rng = np.random.default_rng(0)
    parent = rng.uniform(-1, 1, (100, 2))
    child = np.concatenate([np.zeros((1, 2)), np.cumsum(parent[1:] @ GAIN.T, axis=0)])
    columns = dict(zip(("r.a", "r.b", "c.a", "c.b"), np.concatenate([parent, child], axis=1).T, strict=True))
    edge = Interaction("r", "c")
    data = collect_transitions(
        [Demonstration(pd.DataFrame({"time": TICK * np.arange(100), **columns}))],
        InteractionGraph({"r": TWO, "c": TWO}, [edge]),
        edge,
    )
    spec = InverseSpec(EstimatorSpec("polynomial", {"degree": 1, "alphas": [1e-8]}), "raw")
    return InverseLevel(fit_inverse(data, spec, (0, 1), edge).model, np.full(2, limit))


@pytest.mark.parametrize(("limit", "reached"), [(9.0, 1.0), (0.2, 0.25)])
def test_an_inverse_level_inverts_a_linear_link(limit: float, reached: float) -> None:
    """Within reach all the way; else the part of the way that the demonstrations show in one tick."""
    of = inverse_level(limit)
    child, goal = np.array([[1.0, -2.0]]), np.array([[1.4, -2.8]])
    plan, memory = of.decide(child, np.zeros((1, 2)), goal[:, None], np.zeros((1, 0)))
    np.testing.assert_allclose(child + plan[:, 0] @ GAIN.T, child + reached * (goal - child), atol=1e-4)
    assert (of.memory_size, memory.shape, of.lookahead) == (0, (1, 0), 1)


def test_an_inverse_that_aims_further_reads_the_state_wanted_then() -> None:
    of = inverse_level(9.0)
    ahead = InverseLevel(replace(of.inverse, aim=2), of.limit)
    wanted = np.array([[[0.5, 0.6], [0.3, 0.4], [-0.5, -0.6]]])
    np.testing.assert_array_equal(
        ahead.decide(np.zeros((1, 2)), np.zeros((1, 2)), wanted, np.zeros((1, 0)))[0],
        of.decide(np.zeros((1, 2)), np.zeros((1, 2)), wanted[:, 1:], np.zeros((1, 0)))[0],
    )
    now = of.decide(np.zeros((1, 2)), np.zeros((1, 2)), wanted, np.zeros((1, 0)))[0]
    np.testing.assert_allclose(now[:, 0] @ GAIN.T, [[0.5, 0.6]], atol=1e-3)
    assert ahead.lookahead == 2


def test_what_is_wanted_beyond_its_end_is_its_last_and_what_is_too_long_is_cut() -> None:
    wanted = np.arange(6.0).reshape(1, 3, 2)
    for ticks, rows in ((2, [0, 1]), (3, [0, 1, 2]), (5, [0, 1, 2, 2, 2])):
        np.testing.assert_array_equal(_extend(wanted, ticks), wanted[:, rows])


@dataclass(frozen=True)
class Bent(LinearizedModel):
    """What a child does next depends on all three in a bent way."""

    def predict(self, child: FloatArray, parent: FloatArray, parent_next: FloatArray) -> FloatArray:
        return child + 0.1 * child**2 + np.sin(parent) @ GAIN + np.cos(parent_next) @ GAIN.T

    def linearize(
        self, child: FloatArray, parent: FloatArray, parent_next: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        by_child = np.eye(2) * (1.0 + 0.2 * child)[:, None]
        by_parent, by_next = GAIN.T * np.cos(parent)[:, None], -GAIN * np.sin(parent_next)[:, None]
        return self.predict(child, parent, parent_next), by_child, by_parent, by_next


def test_what_a_plan_leaves_changes_with_it_as_its_derivatives_say() -> None:
    """Each planned state acts in its own tick, and as the one before it in the next."""
    of, rng = level(Bent(), along=0.3), np.random.default_rng(0)
    child, parent, plan, offsets = (0.5 * rng.normal(size=s) for s in ((3, 2), (3, 2), (3, 4, 2), (3, 4, 2)))
    wanted = rng.normal(size=(3, 4, 2))
    metric = of._error_metric(child, wanted)

    def left(flat: FloatArray) -> FloatArray:
        return of._residual(child, parent, flat.reshape(plan.shape), offsets, wanted, metric, with_jacobian=False)[0]

    residual, jacobian = of._residual(child, parent, plan, offsets, wanted, metric, with_jacobian=True)
    assert jacobian is not None
    flat, tiny = plan.reshape(3, -1), 1e-6
    np.testing.assert_allclose(residual, left(flat), atol=1e-12)
    for k in range(8):
        push = tiny * (np.arange(8) == k)
        by_push = (left(flat + push) - left(flat - push)) / (2 * tiny)
        np.testing.assert_allclose(jacobian[:, :, k], by_push, atol=1e-6)


def test_the_cost_is_that_of_errors_and_moves() -> None:
    """Errors in usual steps, moves by the parent's usual spread; offsets are added tick by tick and go on."""
    of = level(effort=0.3)
    plan, offsets = np.arange(8.0).reshape(1, 4, 2), 0.1 * np.arange(8.0).reshape(1, 4, 2)
    parent, wanted = np.array([[1.0, -1.0]]), np.zeros((1, 4, 2))
    metric = np.tile(np.eye(2), (1, 4, 1, 1))
    residual, _ = of._residual(np.ones((1, 2)), parent, plan, offsets, wanted, metric, with_jacobian=False)
    after = 1.0 + np.cumsum(plan[0] @ GAIN.T + offsets[0], axis=0)
    moves = np.diff(np.vstack([parent, plan[0]]), axis=0) * 0.3 / [2.0, 0.5]
    np.testing.assert_allclose(residual[0], np.concatenate([(after / 0.7).ravel(), moves.ravel()]))


def test_an_error_is_weighed_by_its_direction_along_the_wanted_way() -> None:
    """In usual steps; the way begins where the child should be, not where it is, and who stands has no way."""
    of = level(along=0.25)
    of = replace(of, target_scale=np.array([2.0, 1.0]))
    wanted = np.array([[[1.0, 0.0], [3.0, 1.0], [3.0, 1.0], [3.0, 5.0]]])
    metric = of._error_metric(np.array([[9.0, 9.0]]), wanted)[0]
    tangent = np.array([1.0, 1.0]) / np.sqrt(2.0)  # 2 of 2, 1 of 1
    np.testing.assert_allclose(metric[0], np.eye(2) - 0.75 * np.outer(tangent, tangent))
    np.testing.assert_allclose(metric[1], metric[0])
    np.testing.assert_allclose(metric[2], np.eye(2))
    np.testing.assert_allclose(metric[3], np.diag([1.0, 0.25]))
    alone = of._error_metric(np.array([[1.0, 4.0]]), wanted[:, :1])[0]
    np.testing.assert_allclose(alone[0], np.diag([1.0, 0.25]), err_msg="of one tick it is from where the child is")


@pytest.mark.parametrize("step", [0.3, 5.0])
def test_the_parent_is_asked_for_no_more_than_the_level_below_can_do(step: float) -> None:
    of = replace(level(effort=1e-3), parent_step=np.array([step, 2.0 * step]))
    parent = np.array([[0.5, -0.5]])
    plan = decide(of, np.full((1, 4, 2), 30.0), parent)[0]
    moves = np.diff(np.vstack([parent, plan]), axis=0)
    assert (np.abs(moves) <= np.array([step, 2.0 * step]) + 1e-12).all()
    np.testing.assert_allclose(moves[0], [step, 2.0 * step], err_msg="as far as it goes, at once")
    free = level()
    np.testing.assert_array_equal(free._within_reach(parent, 9.0 * plan[None]), 9.0 * plan[None])


def test_a_plan_that_is_too_far_is_gone_step_by_step() -> None:
    of = replace(level(), parent_step=np.array([1.0, 1.0]))
    plan = np.array([[[5.0, -0.5], [5.0, -3.0], [1.5, -3.0], [1.5, 0.0]]])
    reached = of._within_reach(np.zeros((1, 2)), plan)
    np.testing.assert_allclose(reached[0], [[1.0, -0.5], [2.0, -1.5], [1.5, -2.5], [1.5, -1.5]])


@pytest.mark.parametrize("believed", [True, False])
def test_a_lasting_error_of_the_model_is_reckoned_with_where_it_is_asked_for(believed: bool) -> None:
    """A child that drifts by the same in each tick stays off the place where it should stand."""
    of = level(effort=1e-3, offset=0.2 if believed else 0.0)
    drift = np.array([0.3, -0.2])
    child, parent, memory = np.zeros((1, 2)), np.zeros((1, 2)), np.zeros((1, of.memory_size))
    for _ in range(60):
        plan, memory = of.decide(child, parent, np.zeros((1, 4, 2)), memory)
        assert memory.shape == (1, of.memory_size)
        parent = plan[:, 0]
        child = child + parent @ GAIN.T + drift
    assert bool(np.abs(child).max() < 0.02) is believed
    assert of.memory_size == (9 + of._offset.memory_size + 4 if believed else 9)


@dataclass(frozen=True)
class Steep(Linear):
    """A parent beyond 2 does the opposite of what its slope says."""

    def predict(self, child: FloatArray, parent: FloatArray, parent_next: FloatArray) -> FloatArray:
        return child + (parent_next - 0.3 * np.maximum(np.abs(parent_next) - 2.0, 0.0) ** 2) @ self.gain.T


def test_a_step_that_does_harm_is_tried_again_shorter_from_its_start() -> None:
    wanted = np.full((1, 4, 2), 6.0)
    for iterations in (3, 6):
        of = level(Steep(), effort=0.02, iterations=iterations)
        plan = decide(of, wanted)
        metric, none = of._error_metric(np.zeros((1, 2)), wanted), np.zeros((1, 4, 2))

        def cost(
            plan: FloatArray, of: PredictiveLevel = of, metric: FloatArray = metric, none: FloatArray = none
        ) -> float:
            start = np.zeros((1, 2))
            return float((of._residual(start, start, plan, none, wanted, metric, with_jacobian=False)[0] ** 2).sum())

        first = cost(none)
        assert cost(plan) < 0.5 * first, iterations


def test_what_is_at_a_bound_and_pushed_against_it_stays_and_the_rest_is_solved_for() -> None:
    """One step of a problem with two unknowns: the first is at its bound, and the second goes where it is best then."""
    of = level(bound=1.0, horizon=1, effort=0.0)
    hessian = np.array([[2.0, 1.0], [1.0, 3.0]])
    root = np.linalg.cholesky(hessian).T
    plan = np.array([[[1.0, 0.0]]])
    residual = -np.linalg.solve(root.T, np.array([3.0, 0.6]))[None]  # the gradient is -3, -0.6
    improved = of._improve(plan, residual, root[None], np.ones(1))
    np.testing.assert_allclose(improved[0, 0], [1.0, 0.2], atol=1e-5)
    half = of._improve(plan, residual, root[None], np.full(1, 0.5))
    np.testing.assert_allclose(half[0, 0], [1.0, 0.1], atol=1e-5)
    away = of._improve(plan, -residual, root[None], np.ones(1))
    expected = np.array([1.0, 0.0]) - np.linalg.solve(hessian, [3.0, 0.6])
    np.testing.assert_allclose(away[0, 0], np.maximum(expected, [0.3, -0.7]), atol=1e-5)
    low = of._improve(-plan, -residual, root[None], np.ones(1))
    np.testing.assert_allclose(low[0, 0], [-1.0, -0.2], atol=1e-5)
    far = of._improve(np.zeros((1, 1, 2)), 100.0 * residual, root[None], np.ones(1))
    np.testing.assert_allclose(far[0, 0], [0.7, -0.7], atol=1e-5, err_msg="no further than a third of the range")


def test_of_a_linear_model_one_step_is_enough_and_without_one_it_stays() -> None:
    wanted = np.random.default_rng(2).uniform(-2, 2, (2, 4, 2))
    np.testing.assert_allclose(decide(level(iterations=1), wanted), decide(level(iterations=5), wanted), atol=1e-6)
    assert not decide(level(iterations=0), wanted).any()
    assert np.abs(decide(level(iterations=1), wanted)).max() > 0.1


@dataclass(frozen=True)
class OneHand(LinearizedModel):
    """A child of two variables that a single one of the parent pushes, and a drift that nobody knows of."""

    def predict(self, child: FloatArray, parent: FloatArray, parent_next: FloatArray) -> FloatArray:
        return child + parent_next * [1.0, 0.0]

    def linearize(
        self, child: FloatArray, parent: FloatArray, parent_next: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        n = len(child)
        by_next = np.tile(np.array([[1.0], [0.0]]), (n, 1, 1))
        return self.predict(child, parent, parent_next), np.tile(np.eye(2), (n, 1, 1)), 0 * by_next, by_next


def test_what_is_remembered_fits_a_parent_and_a_child_of_any_size() -> None:
    one = np.ones(1)
    of = PredictiveLevel(
        OneHand(), TWO, (0,), 0.7 * one, -9 * one, 9 * one, one, PredictiveWeights(horizon=3, effort=1e-3, offset=0.2)
    )
    child, parent, memory = np.array([[0.0, 0.5]]), np.zeros((1, 1)), np.zeros((1, of.memory_size))
    for _ in range(60):
        plan, memory = of.decide(child, parent, np.zeros((1, 3, 1)), memory)
        assert plan.shape == (1, 3, 1)
        assert memory.shape == (1, of.memory_size)
        parent = plan[:, 0]
        child = child + parent * [1.0, 0.0] + [0.3, 0.0]
    assert abs(child[0, 0]) < 0.02
    np.testing.assert_allclose(parent, -0.3, atol=0.02)
