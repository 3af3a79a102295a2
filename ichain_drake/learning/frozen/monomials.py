"""Monomials of several variables, evaluated by one gather and a product, and their derivatives by index tables."""

from __future__ import annotations

from itertools import combinations_with_replacement

import numpy as np
from numpy.typing import NDArray

from ichain_drake.learning.frozen.scaling import FloatArray


def all_exponents(n_in: int, degree: int) -> NDArray[np.int64]:
    """Exponents of all monomials up to a degree, the constant first, shape (n_monomials, n_in)."""
    rows = [
        np.bincount(np.array(chosen, dtype=int), minlength=n_in)
        for k in range(degree + 1)
        for chosen in combinations_with_replacement(range(n_in), k)
    ]
    return np.array(rows, dtype=np.int64).reshape(len(rows), n_in)


class Monomials:
    """A set of monomials that contains every derivative of its members (up to a factor), the constant first.

    Args:
        exponents: shape (n, n_in); missing lower monomials are added.

    Attributes:
        exponents: shape (n_monomials, n_in), by rising degree.
        positions: where each of the given rows is in `exponents`, shape (n,).
        n_lower: how many monomials have less than the highest degree: all that derivatives need.
    """

    def __init__(self, exponents: NDArray[np.int64]) -> None:
        given = [tuple(int(k) for k in row) for row in exponents]
        n_in = exponents.shape[1]
        closed = {(0,) * n_in}
        stack = list(given)
        while stack:
            row = stack.pop()
            if row not in closed:
                closed.add(row)
                stack += [lowered(row, i) for i in range(n_in) if row[i] > 0]
        order = sorted(closed, key=lambda row: (sum(row), [-k for k in row]))
        self._index = {row: j for j, row in enumerate(order)}
        self.exponents = np.array(order, dtype=np.int64).reshape(len(order), n_in)
        self.positions = np.array([self._index[row] for row in given], dtype=np.intp)
        self.degree = sum(order[-1])
        self.n_lower = sum(1 for row in order if sum(row) < self.degree)
        # slots[k, j]: which entry of [1, z] is the k-th factor of monomial j
        self._slots = np.zeros((max(self.degree, 1), len(order)), dtype=np.intp)
        for j, row in enumerate(order):
            factors = [i + 1 for i, k in enumerate(row) for _ in range(k)]
            self._slots[: len(factors), j] = factors
        self._plain = self.degree == 1 and len(order) == n_in + 1  # the constant and every variable

    def __len__(self) -> int:
        return len(self.exponents)

    def row(self, z: FloatArray) -> FloatArray:
        """Evaluate at one row, (n_in,) -> (n_monomials,)."""
        padded = np.empty(len(z) + 1)
        padded[0] = 1.0
        padded[1:] = z
        return np.multiply.reduce(padded.take(self._slots), axis=0)

    def batch(self, z: FloatArray) -> FloatArray:
        """Evaluate at rows, (..., n_in) -> (..., n_monomials)."""
        if self._plain:
            result = np.ones((*z.shape[:-1], z.shape[-1] + 1))
            result[..., 1:] = z
            return result
        padded = np.ones((z.shape[-1] + 1, *z.shape[:-1]))
        padded[1:] = np.moveaxis(z, -1, 0)
        product = padded[self._slots[0]]
        for slots in self._slots[1:]:
            product *= padded[slots]
        return np.ascontiguousarray(np.moveaxis(product, 0, -1))

    def derivative(self, weights: FloatArray) -> FloatArray:
        """Weights of the derivatives of `weights @ monomials`.

        Args:
            weights: shape (n_out, n_monomials).

        Returns:
            shape (n_out, n_in, n_lower): over the first `n_lower` monomials.
        """
        result = np.zeros((len(weights), self.exponents.shape[1], self.n_lower))
        for j, row in enumerate(self.exponents):
            for i in map(int, np.flatnonzero(row)):
                result[:, i, self._index[lowered(tuple(row), i)]] += weights[:, j] * row[i]
        return result


def lowered(row: tuple[int, ...], i: int) -> tuple[int, ...]:
    """Exponents with one factor of variable i taken away."""
    return (*row[:i], row[i] - 1, *row[i + 1 :])
