"""Errors of screened regressions are those of plain ridge regressions with each group left out, row by row."""

from itertools import combinations_with_replacement
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ichain_drake.learning.effects.screening import CubicScreening, RectifiedScreening, Screening, window_means
from ichain_drake.state import FloatArray

RIDGE = 1e-3
GROUP = np.repeat(np.arange(4), 15)
FIT = [(a, a + 3) for a in range(0, 60, 3)]
JUDGE = [(a, a + 5) for a in range(0, 60, 5)]


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


@pytest.mark.parametrize("degree", [1, 2])
@pytest.mark.parametrize("columns", [[], [1], [0, 1], [2, 0, 1]])
def test_errors_are_those_of_regressions_on_windows(columns: list[int], degree: int) -> None:
    x, y = table()
    fit_group, judge_group = (GROUP[[a for a, _ in marks]] for marks in (FIT, JUDGE))
    screen = Screening(x, y, FIT, fit_group, JUDGE, judge_group, degree, np.ones(3, dtype=bool))
    expected = plain(x, y, columns, degree, FIT)
    np.testing.assert_allclose(screen.errors(columns), expected, rtol=1e-6)
    assert screen.error(columns) == pytest.approx(expected.sum())


def test_a_product_needs_both_of_its_columns_and_no_other() -> None:
    x, y = table()
    fit_group, judge_group = (GROUP[[a for a, _ in marks]] for marks in (FIT, JUDGE))
    screen = Screening(x, y, FIT, fit_group, JUDGE, judge_group, 2, np.ones(3, dtype=bool))
    assert set(screen.select()) == {0, 1}
    assert set(CubicScreening(x, y, GROUP, JUDGE).select()) == {0, 1}


@pytest.mark.parametrize("columns", [[1], [0, 1]])
def test_errors_of_cubics_are_those_of_regressions_on_rows(columns: list[int]) -> None:
    x, y = table()
    error = CubicScreening(x, y, GROUP, JUDGE).error(columns)
    assert error == pytest.approx(plain(x, y, columns, 3, [(k, k + 1) for k in range(60)]).sum(), rel=1e-6)


def test_means_over_windows() -> None:
    values = np.arange(6.0) ** 2
    np.testing.assert_allclose(window_means(values, [(0, 2), (2, 6), (5, 6)]), [0.5, 13.5, 25.0])
    np.testing.assert_allclose(window_means(values[:, None], [(1, 3)]), [[2.5]])


def test_a_third_column_is_chosen_where_it_helps_and_no_more_than_asked_for() -> None:
    help_ = {0, 2, 4}
    screen: Any = SimpleNamespace(usable=np.arange(5), error=lambda columns: 0.1 ** len(help_ & set(columns)))
    assert sorted(RectifiedScreening.select(screen)) == [0, 2, 4]
    assert len(RectifiedScreening.select(screen, 2)) == 2
