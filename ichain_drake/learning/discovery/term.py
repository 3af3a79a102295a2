"""A gated effect: while its gate holds, it adds something to a child's passive change."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from ichain_drake.learning.discovery.gate import Gate
from ichain_drake.learning.discovery.inputs import GateInput
from ichain_drake.learning.discovery.settings import DISCOVERY
from ichain_drake.learning.effects.alignment import Alignment
from ichain_drake.learning.frozen.monomials import Monomials, all_exponents
from ichain_drake.state import BoolArray, FloatArray


@dataclass(frozen=True, eq=False)
class Curve:
    """Monomials of columns that are brought to a middle of 0 and a spread of 1.

    Attributes:
        degree: highest total degree.
        middle, spread: of each column, shape (n_columns,).
    """

    degree: int
    middle: FloatArray
    spread: FloatArray

    @classmethod
    def over(cls, columns: FloatArray, degree: int) -> Curve:
        """For the range of some columns, shape (n, n_columns)."""
        return cls(degree, columns.mean(axis=0), np.maximum(columns.std(axis=0), 1e-12))

    def __call__(self, columns: FloatArray) -> FloatArray:
        """Monomials, shape (n, n_monomials), the constant first, from columns, shape (n, n_columns)."""
        return _monomials(columns.shape[1], self.degree).batch((columns - self.middle) / self.spread)


@cache
def _monomials(columns: int, degree: int) -> Monomials:
    """All monomials of some columns, made once."""
    return Monomials(all_exponents(columns, degree))


@dataclass(frozen=True, eq=False)
class VariableEffect:
    """What a gated effect adds to one variable of the child.

    Attributes:
        variable: its index.
        declared: whether it is what the roles declare: just the one column.
        columns: indices of the columns that it depends on.
        coefficients: constant, then one per column; of a curve one per monomial.
        std: of what is left of a tick, in the variable's unit.
        curve: of a polynomial in the columns; None for a line.
    """

    variable: int
    declared: bool
    columns: tuple[int, ...]
    coefficients: FloatArray
    std: float
    curve: Curve | None = None

    def predict(self, columns: FloatArray) -> FloatArray:
        """Change, shape (n,), from all columns, shape (n, n_columns)."""
        used = columns[:, list(self.columns)]
        if self.curve is not None:
            return self.curve(used) @ self.coefficients
        return np.asarray(self.coefficients[0] + used @ self.coefficients[1:])

    def price(self) -> float:
        """Of its parameters [nat]."""
        if self.declared:
            return DISCOVERY.declared
        free = len(self.coefficients) - len(self.columns)  # the constant, and what makes a line a curve
        return DISCOVERY.constant * free + DISCOVERY.slope * len(self.columns)


@dataclass(frozen=True, eq=False)
class Term:
    """A gated effect of one parent on one child, and what speaks for it in each tick.

    Attributes:
        parent: whose state acts; the child itself for what it does alone.
        child: on what.
        effects: per variable of the child that changes.
        gate: when.
        inputs: of the gate.
        labels: of the columns of the effects.
        alignment: of the two, where they move together.
        others: further objects that the gate may look at.
        window: length of the means that it was judged by [ticks].
        on: ticks in which the gate holds, shape (n_ticks,).
        predicted: change of each variable if it acts, shape (n_ticks, n_variables).
        evidence: log-likelihood of acting less that of not acting, shape (n_ticks,) [nat].
        value: evidence within the gate less all prices [nat].
        left_out: evidence within gates fitted without each tick's fold, shape (n_ticks,).
    """

    parent: str
    child: str
    effects: tuple[VariableEffect, ...]
    gate: Gate
    inputs: tuple[GateInput, ...]
    labels: tuple[str, ...]
    alignment: Alignment | None
    others: tuple[str, ...]
    window: int
    on: BoolArray
    predicted: FloatArray
    evidence: FloatArray
    value: float
    left_out: FloatArray

    @property
    def objects(self) -> set[str]:
        """The parent and whatever else the gate looks at."""
        return {self.inputs[k].owner for k in np.flatnonzero(self.gate.used)} | {self.parent}

    @property
    def gain(self) -> float:
        """Evidence on left-out ticks [nat]."""
        return float(self.left_out.sum())

    def price(self) -> float:
        """Of what it consists of, on left-out data too: prefers the declared and the near [nat]."""
        owners = self.objects - {self.child}
        return (
            DISCOVERY.face * self.gate.faces
            + sum(e.price() for e in self.effects)
            + DISCOVERY.other_object * len(owners)
        )

    def text(self, names: tuple[str, ...]) -> str:
        """In one line, with the child's variables by name."""
        effects = ", ".join(
            f"{names[e.variable]} by {'+'.join(self.labels[c] for c in e.columns) or f'{e.coefficients[0]:.3g}'}"
            for e in self.effects
        )
        faces = " and ".join(
            f"{low:.3g} < {item.label} < {high:.3g}"
            for item, low, high in zip(self.inputs, self.gate.low, self.gate.high, strict=True)
            if np.isfinite(low) or np.isfinite(high)
        )
        return f"{self.parent} changes {self.child}: {effects}, while {faces or 'always'}"
