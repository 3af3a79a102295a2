"""Errors of screened regressions are those of plain ridge regressions with each group left out, row by row."""

from collections.abc import Callable, Collection, Sequence
from itertools import combinations_with_replacement
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ichain_drake.learning.effects.screening import CubicScreening, RectifiedScreening, Screening, window_means
from ichain_drake.learning.settings import LEARNING
from ichain_drake.state import FloatArray

RIDGE = 1e-3
GROUP = np.repeat(np.arange(4), 15)
FIT = [(a, a + 3) for a in range(0, 60, 3)]
JUDGE = [(a + p, a + q) for a in range(0, 60, 15) for p, q in ((0, 5), (5, 8), (8, 15))]


def table() -> tuple[FloatArray, FloatArray]:
    rng = np.random.default_rng(0)
    x = rng.normal(size=(60, 3)) * [1.0, 3.0, 0.2] + [0.0, 5.0, 1.0]
    return x, x[:, 0] * x[:, 1] - 0.5 * x[:, 1] + 0.3 * rng.normal(size=60)


def plain(x: FloatArray, y: FloatArray, columns: list[int], degree: int, fit: list[tuple[int, int]]) -> FloatArray:
    """Squared error of each group's windows by a regression on the windows of the others."""
    z = ((x - x.mean(axis=0)) / x.std(axis=0))[:, columns]
    phi = np.column_stack(
        [
            np.prod(z[:, list(c)], axis=1)
            for n in range(degree + 1)
            for c in combinations_with_replacement(range(len(columns)), n)
        ]
    )
    out = []
    for g in range(4):
        rows = [w for w in fit if GROUP[w[0]] != g]
        a = np.array([phi[i:j].mean(axis=0) for i, j in rows])
        b = np.array([y[i:j].mean() for i, j in rows])
        size = np.array([j - i for i, j in rows], dtype=float)
        ridge = RIDGE * (size.sum() if len(fit) < 60 else 60) * np.eye(phi.shape[1])
        ridge[0, 0] = 1e-9
        w = np.linalg.solve(a.T @ (size[:, None] * a) + ridge, a.T @ (size * b))
        out.append(
            sum((j - i) * float(y[i:j].mean() - phi[i:j].mean(axis=0) @ w) ** 2 for i, j in JUDGE if GROUP[i] == g)
        )
    return np.array(out)


def screening(x: FloatArray, y: FloatArray, degree: int) -> Screening:
    fit_group, judge_group = (GROUP[[a for a, _ in marks]] for marks in (FIT, JUDGE))
    return Screening(x, y, FIT, fit_group, JUDGE, judge_group, degree, np.ones(x.shape[1], dtype=bool))


@pytest.mark.parametrize("degree", [1, 2])
@pytest.mark.parametrize("columns", [[], [1], [0, 1], [2, 0, 1]])
def test_errors_are_those_of_regressions_on_windows(columns: list[int], degree: int) -> None:
    x, y = table()
    screen = screening(x, y, degree)
    expected = plain(x, y, columns, degree, FIT)
    np.testing.assert_allclose(screen.errors(columns), expected, rtol=1e-6)
    assert screen.error(columns) == pytest.approx(expected.sum())


def test_a_product_needs_both_of_its_columns_and_no_other() -> None:
    x, y = table()
    assert set(screening(x, y, 2).select()) == {0, 1}
    assert set(CubicScreening(x, y, GROUP, JUDGE).select()) == {0, 1}


@pytest.mark.parametrize("columns", [[1], [0, 1]])
def test_errors_of_cubics_are_those_of_regressions_on_rows(columns: list[int]) -> None:
    x, y = table()
    error = CubicScreening(x, y, GROUP, JUDGE).error(columns)
    assert error == pytest.approx(plain(x, y, columns, 3, [(k, k + 1) for k in range(60)]).sum(), rel=1e-6)


def test_a_column_that_does_not_vary_beyond_rounding_is_not_chosen() -> None:
    x, y = table()
    rounding = 1e6 + 1e-5 * np.sign(x[:, :1])  # varies by 1e-11 of its size, and by chance as the target does
    wide = np.hstack([np.full((60, 1), 3.0), np.zeros((60, 1)), rounding, x[:, :2], 1e-6 * x[:, 2:]])
    assert set(screening(wide, y, 2).select()) == {3, 4}
    for screen in (
        screening(wide, y, 1),
        CubicScreening(wide, y, GROUP, JUDGE),
        RectifiedScreening(wide, y, GROUP, JUDGE),
    ):
        assert screen.usable.tolist() == [3, 4, 5]
    assert screening(wide[:, :3], y, 1).select() == []
    assert CubicScreening(wide[:, 2:4], y, GROUP, JUDGE).select() == [], "a pair needs two"
    assert RectifiedScreening(wide[:, :3], y, GROUP, JUDGE).select() == []


def test_means_over_windows() -> None:
    values = np.arange(6.0) ** 2
    np.testing.assert_allclose(window_means(values, [(0, 2), (2, 6), (5, 6)]), [0.5, 13.5, 25.0])
    np.testing.assert_allclose(window_means(values[:, None], [(1, 3)]), [[2.5]])
    assert window_means(values, []).shape == (0,)


class Told(Screening):
    """A forward selection whose errors are told."""

    def __init__(
        self, error: Callable[[frozenset[int]], float], n: int, preferred: Collection[int] | None = None
    ) -> None:
        self.usable, self.told = np.arange(n), error
        self.preferred = np.isin(np.arange(n), list(range(n) if preferred is None else preferred))

    def error(self, columns: Sequence[int]) -> float:
        return self.told(frozenset(columns))


@pytest.mark.parametrize(("share", "chosen"), [(0.9, [1]), (1.1, [])])
def test_a_column_is_worth_it_from_a_share_of_the_error_on(share: float, chosen: list[int]) -> None:
    left = {frozenset(): 100.0, frozenset({1}): 100.0 * share * LEARNING.single}
    assert Told(lambda columns: left.get(columns & {1}, 100.0), 3).select() == chosen


@pytest.mark.parametrize(("share", "chosen"), [(0.9, {0, 2}), (1.1, {1})])
def test_a_pair_is_worth_it_from_a_share_of_the_better_single_one(share: float, chosen: set[int]) -> None:
    single = 100.0 * 0.9 * LEARNING.single

    def error(columns: frozenset[int]) -> float:
        if columns >= {0, 2}:
            return single * share * LEARNING.pair
        return single if 1 in columns else 100.0 + len(columns)

    assert set(Told(error, 4).select(2)) == chosen
    assert Told(error, 4).select(1) == [1], "one column is no pair"


@pytest.mark.parametrize("most", [1, 2, 3, 4])
def test_no_more_columns_are_chosen_than_asked_for(most: int) -> None:
    chosen = Told(lambda columns: 0.5 ** len(columns), 6).select(most)
    assert len(chosen) == len(set(chosen)) == most
    assert len(Told(lambda columns: 0.1 ** len(columns & {0, 1, 4}), 6).select(most)) == min(most, 3)
    assert len(Told(lambda columns: 0.5 ** len(columns), 6).select()) == 4, "a polynomial takes four"


@pytest.mark.parametrize(("better", "chosen"), [(0.99, 1), (1.01, 0)])
def test_what_roles_ask_for_is_chosen_unless_another_is_better_by_more_than_the_preference(
    better: float, chosen: int
) -> None:
    good = {1: 10.0, 0: 10.0 / (better * LEARNING.preference)}
    told = Told(lambda columns: min((good.get(c, 100.0) for c in columns), default=100.0), 3, preferred={1})
    assert told.select(1) == [chosen]


def test_pairs_begin_with_one_of_the_best_columns_and_end_with_any() -> None:
    n = LEARNING.seeds + 5
    last = n - 1  # the worst by itself

    def error(columns: frozenset[int]) -> float:
        if columns >= {0, last}:
            return 1.0
        return 50.0 + min(columns, default=n)

    assert set(Told(error, n).select(2)) == {0, last}

    def hidden(columns: frozenset[int]) -> float:
        return 1.0 if columns >= {last - 1, last} else 60.0 + min(columns, default=n)

    assert Told(hidden, n).select(2) == [], "two of no use by themselves are not looked for"


def by_help(*help_: int) -> Any:
    return SimpleNamespace(usable=np.arange(5), error=lambda columns: 0.1 ** len(set(help_) & set(columns)))


@pytest.mark.parametrize("screening", [CubicScreening, RectifiedScreening])
def test_a_third_column_is_chosen_where_it_helps_and_no_more_than_asked_for(screening: Any) -> None:
    assert sorted(screening.select(by_help(0, 2, 4))) == [0, 2, 4]
    assert sorted(screening.select(by_help(0, 1, 2, 3, 4))) == [0, 1, 2]
    assert len(screening.select(by_help(0, 2, 4), 2)) == 2
    assert sorted(screening.select(by_help(1, 3))) == [1, 3]


@pytest.mark.parametrize(("share", "chosen"), [(0.9, [1, 3]), (1.1, [1])])
def test_a_second_column_of_a_threshold_must_be_worth_it(share: float, chosen: list[int]) -> None:
    left = {0: 1.0, 1: 0.5, 2: 0.5 * share * LEARNING.single}
    screen: Any = SimpleNamespace(
        usable=np.arange(5), error=lambda columns: left[len({1, 3} & set(columns)) if 1 in columns else 0]
    )
    assert sorted(RectifiedScreening.select(screen)) == chosen


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_errors_of_thresholds_are_those_of_fits_that_have_not_seen_the_group(sign: float) -> None:
    """Two groups, of which one changes by twice as much as the other: each is predicted as the other has it."""
    one = np.linspace(-1.0, 1.0, 40)
    x, group = np.column_stack([np.tile(one, 2), np.ones(80)]), np.repeat([0, 1], 40)
    beyond = np.maximum(one - 0.205, 0.0)
    judge = [(a + p, a + q) for a in (0, 40) for p, q in ((0, 26), (26, 30), (30, 40))]
    screen = RectifiedScreening(x, sign * np.concatenate([beyond, 2.0 * beyond]), group, judge)
    expected = sum(2.0 * (q - p) * beyond[p:q].mean() ** 2 for p, q in judge[:3])
    assert screen.error([0]) == pytest.approx(expected, rel=1e-3)


def test_a_threshold_of_two_columns_leaves_an_error_with_one() -> None:
    x, _ = table()
    z = (x - x.mean(axis=0)) / x.std(axis=0)
    y = -np.maximum(z[:, 0] + 0.8 * z[:, 2] - 0.5, 0.0)
    y[3] = 0.1  # what goes the other way is not predicted
    screen = RectifiedScreening(x, y, GROUP, [(k, k + 1) for k in range(60)])
    assert screen.error([0, 2]) == pytest.approx(0.01, rel=0.01)
    assert screen.error([0]) > 0.5
    assert sorted(screen.select()) == [0, 2]


def rectified(z: FloatArray, y: FloatArray, out: FloatArray) -> FloatArray:
    """Of the rows that are left out, by alternating between which rows are beyond the threshold and a line in them."""
    phi = np.column_stack([z, np.ones(len(z))])

    def line(rows: FloatArray) -> FloatArray:
        ridge = 1e-6 * (1.0 + rows.sum()) * np.eye(phi.shape[1])
        return np.linalg.solve(phi[rows].T @ phi[rows] + ridge, phi[rows].T @ y[rows])

    beyond = y > 0.15 * y.max()
    while not np.array_equal(after := phi @ line(beyond) > 0.0, beyond):
        beyond = after
    again = (phi @ line(beyond & ~out) > 0.0) & ~out
    return np.maximum(phi[out] @ line(again), 0.0)


@pytest.mark.parametrize("seed", range(3))
def test_errors_of_bent_changes_are_those_of_lines_beyond_a_threshold(seed: int) -> None:
    """Few large changes one way count for more than many small ones the other way."""
    rng = np.random.default_rng(seed)
    x = rng.normal(size=(60, 3))
    z = ((x - x.mean(axis=0)) / x.std(axis=0))[:, [0, 2]]
    y = 0.8 - np.maximum(z[:, 0] + 0.8 * z[:, 1] - 0.4, 0.0) ** 1.7 + 0.05 * rng.normal(size=60)
    prediction = np.empty(60)
    for g in range(4):
        prediction[g == GROUP] = rectified(z, -y, g == GROUP)
    expected = sum((q - p) * (-y - prediction)[p:q].mean() ** 2 for p, q in JUDGE)
    screen = RectifiedScreening(x, y, GROUP, JUDGE)
    assert screen.error([0, 2]) == pytest.approx(expected)
