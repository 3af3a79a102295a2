"""Sets of monomials: with all that derivatives need, and nothing more."""

import numpy as np

from ichain_drake.learning.frozen.monomials import Monomials


def test_what_derivatives_need_is_added_and_nothing_else() -> None:
    found = Monomials(np.array([[2, 1], [0, 1]]))
    assert found.exponents.tolist() == [[0, 0], [1, 0], [0, 1], [2, 0], [1, 1], [2, 1]]
    assert found.exponents[found.positions].tolist() == [[2, 1], [0, 1]]
    assert (len(found), found.degree, found.n_lower) == (6, 3, 5)


def test_their_values_are_products() -> None:
    found, z = Monomials(np.array([[2, 1]])), np.array([3.0, 5.0])
    np.testing.assert_array_equal(found.row(z), [1.0, 3.0, 5.0, 9.0, 15.0, 45.0])


def test_rows_have_the_values_of_each_row() -> None:
    rows = np.random.default_rng(0).normal(size=(3, 4, 2))
    for exponents in ([[1, 0], [0, 1]], [[0, 1]], [[2, 1]]):
        found = Monomials(np.array(exponents))
        expected = [[found.row(row) for row in table] for table in rows]
        np.testing.assert_array_equal(found.batch(rows), expected)
