"""The simplest effect that pays: what roles declare, a constant, or a line; none where too few ticks show any."""

import numpy as np
import pytest

from ichain_drake.learning.discovery.effect_fit import explained, fit_effects
from ichain_drake.learning.discovery.features import Features
from ichain_drake.learning.discovery.log import RawPiece, make_log
from ichain_drake.learning.discovery.residual import Residual
from ichain_drake.learning.discovery.term import VariableEffect
from ichain_drake.state import BoolArray, FloatArray, StateSpace, Variable

TICKS, NOISE = 120, 1e-3
HAND, TANK = StateSpace("hand", (Variable("x"),)), StateSpace("tank", (Variable("level", lower=0.0, upper=900.0),))


def columns(seed: int = 0) -> FloatArray:
    return np.random.default_rng(seed).uniform(0.1, 0.5, (TICKS, 3))


def residual(change: FloatArray, start: float = 100.0) -> Residual:
    """Of a tank whose level changes by so much in each tick, read with some noise."""
    rng = np.random.default_rng(1)
    level = start + np.r_[0.0, np.cumsum(change)] + NOISE / np.sqrt(2.0) * rng.normal(size=TICKS + 1)
    states = {"hand": rng.normal(size=(TICKS + 1, 1)), "tank": np.clip(level, 0.0, 900.0)[:, None]}
    found = Residual(make_log([RawPiece("p", states)], {"hand": HAND, "tank": TANK}, "hand", {}), "tank", {0: None})
    found.log.noise["tank"][:] = NOISE / np.sqrt(2.0)
    found.quiet[:], found.spread[:] = NOISE, NOISE
    return found


def features(values: FloatArray, declared: tuple[int, ...] = ()) -> Features:
    return Features(values, ("a", "b", "c"), {0: declared}, {}, np.zeros(3, dtype=bool), np.zeros(3))


def fitted(
    change: FloatArray, declared: tuple[int, ...] = (), rows: BoolArray | None = None
) -> tuple[VariableEffect, ...]:
    every = np.ones(TICKS, dtype=bool)
    return fit_effects(residual(change), every if rows is None else rows, features(columns(), declared))


def test_nothing_is_explained_where_nothing_happens() -> None:
    assert fitted(np.zeros(TICKS), (0,)) == ()


def test_a_constant_needs_no_column() -> None:
    (effect,) = fitted(np.full(TICKS, 0.2))
    assert (effect.columns, effect.declared) == ((), False)
    assert effect.coefficients == pytest.approx([0.2], abs=5e-4)
    assert effect.std == pytest.approx(NOISE, rel=0.3)


@pytest.mark.parametrize("used", [(1,), (0, 2)])
def test_a_line_has_the_columns_that_pay(used: tuple[int, ...]) -> None:
    x = columns()
    (effect,) = fitted(0.05 + 2.0 * x[:, used[0]] - (x[:, used[1]] if len(used) > 1 else 0.0))
    assert sorted(effect.columns) == list(used)
    by_column = dict(zip(effect.columns, effect.coefficients[1:], strict=True))
    assert by_column == pytest.approx(dict(zip(used, (2.0, -1.0), strict=False)), abs=0.01)
    assert effect.coefficients[0] == pytest.approx(0.05, abs=0.005)


def test_what_is_pushed_both_ways_alike_has_a_line_though_no_constant() -> None:
    x = columns()
    push = np.where(np.arange(TICKS) % 2, 1.0, -1.0) * x[:, 1]
    push -= push.mean()
    values = np.column_stack([x[:, 0], push, x[:, 2]])
    (effect,) = fit_effects(residual(0.1 * push), np.ones(TICKS, dtype=bool), features(values))
    assert effect.columns == (1,)
    assert effect.coefficients == pytest.approx([0.0, 0.1], abs=1e-3)


def test_what_roles_declare_is_taken_as_it_is_though_a_line_would_fit_better() -> None:
    x = columns()
    other = 9.0 * NOISE * (x[:, 1] - 0.3) / 0.2
    (effect,) = fitted(x[:, 0] + other, (0, 2))
    assert (effect.declared, effect.columns, list(effect.coefficients)) == (True, (0,), [0.0, 1.0])
    (line,) = fitted(x[:, 0] + other)
    assert sorted(line.columns) == [0, 1]


def test_what_roles_declare_is_not_taken_where_it_explains_next_to_nothing() -> None:
    (effect,) = fitted(2.0 * columns()[:, 1], (0,))
    assert (effect.declared, effect.columns) == (False, (1,))


@pytest.mark.parametrize(("ticks", "line"), [(5, False), (6, False), (8, True)])
def test_few_ticks_show_no_line_and_fewer_nothing(ticks: int, line: bool) -> None:
    found = fitted(2.0 * columns()[:, 1], rows=np.arange(TICKS) < ticks)
    assert any(e.columns for e in found) == line


def test_evidence_is_that_of_what_bounds_leave_of_the_predicted_change() -> None:
    made = residual(np.full(TICKS, 0.2), start=899.9)
    effect = VariableEffect(0, False, (), np.array([0.2]), NOISE)
    evidence, predicted = explained(made, (effect,), features(columns()))
    np.testing.assert_allclose(predicted[0], made.clipped(np.full(TICKS, 0.2), 0)[0])
    assert predicted[0, 0] == pytest.approx(0.1, abs=0.005)
    assert np.abs(predicted[2:]).max() < 4 * NOISE
    np.testing.assert_allclose(evidence, made.evidence(predicted[:, 0], 0, NOISE))


def test_what_leaves_a_bound_shows_an_effect() -> None:
    """A tank that fills from empty in one tick, and is emptied in the next."""
    change = np.where(np.arange(TICKS) % 2 == 0, 5.0, -5.0)
    rows = np.arange(TICKS) % 2 == 0
    (effect,) = fit_effects(residual(change, start=0.0), rows, features(columns()))
    assert effect.columns == ()
    assert effect.coefficients == pytest.approx([5.0], abs=0.01)


def test_what_roles_declare_is_as_uncertain_as_the_ticks_in_which_it_acts() -> None:
    """Where it does nothing, nothing is left to explain."""
    rng, x = np.random.default_rng(3), columns()
    acts = np.arange(TICKS) % 4 == 0
    x[:, 0] = np.where(acts, x[:, 0], 0.0)
    change = x[:, 0] + np.where(acts, 2.0 * NOISE * rng.choice([-1.0, 1.0], TICKS), 0.0)
    (effect,) = fit_effects(residual(change), np.ones(TICKS, dtype=bool), features(x, (0,)))
    assert effect.declared
    assert effect.std > 2.0 * NOISE


@pytest.mark.parametrize("memory", [True, False])
def test_what_has_no_memory_follows_a_curve_where_a_line_leaves_more_than_noise(memory: bool) -> None:
    rng, x = np.random.default_rng(2), columns()
    bend = np.tanh(5.0 * (x[:, 0] - 0.3)) + 0.5 * x[:, 1]
    level = 100.0 + np.r_[0.0, bend] + NOISE * rng.normal(size=TICKS + 1)
    states = {"hand": rng.normal(size=(TICKS + 1, 1)), "tank": level[:, None]}
    log = make_log([RawPiece("p", states)], {"hand": HAND, "tank": TANK}, "hand", {})
    found = Residual(log, "tank", {0: None if memory else 100.0})
    log.noise["tank"][:] = NOISE
    found.quiet[:], found.spread[:] = NOISE, NOISE
    (effect,) = fit_effects(found, np.ones(TICKS, dtype=bool), features(x)) or (None,)
    if memory:
        assert effect is None or effect.curve is None
        return
    assert effect is not None and effect.curve is not None
    assert (sorted(effect.columns), effect.curve.degree) == ([0, 1], 3)
    line = np.column_stack([np.ones(TICKS), x[:, :2]])
    left = bend - line @ np.linalg.lstsq(line, bend, rcond=None)[0]
    assert (bend - effect.predict(x)).std() < 0.5 * left.std()
