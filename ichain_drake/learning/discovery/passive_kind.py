"""Whether a variable keeps its value or goes back to a constant, before it is known what acts on it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ichain_drake.learning.discovery.log import Log
from ichain_drake.learning.discovery.residual import Residual, observed
from ichain_drake.learning.discovery.term_fit import fit_term

_AT_REST = 0.4  # share of rows that a rest value is read in at least
_NEAR = 3.0  # noises within which it is
_NEVER_LEAVES = 0.8  # of a change's square: a distance from rest of no more is one reading's noise against two
_CLEARLY = 5.0  # nat


def constant_values(log: Log, child: str, parents: Sequence[str]) -> dict[int, float | None]:
    """Per variable the value to which it goes back within a tick, None where it keeps its own.

    Of the two, what leaves less unexplained together with the best single gated effect. Nothing brings a place, a
    content or what is dissolved in it back by itself within a tick.
    """
    space, out = log.spaces[child], dict[int, float | None]()
    for i in observed(log, child):
        out[i] = None
        value, noise = log.states[child][:, i], log.noise[child][i]
        middle = float(np.median(value))
        if space.angle_mask[i] or np.mean(np.abs(value - middle) <= _NEAR * noise) < _AT_REST:
            continue
        change = space.difference(log.states[child][log.t + 1], log.states[child][log.t])[:, i]
        if np.mean((value - middle) ** 2) < _NEVER_LEAVES * np.mean(change**2):
            out[i] = middle
            continue
        role = space.variables[i].role
        if role is not None and role.kind in ("position", "amount", "intensive"):
            continue
        held, back = (_likelihood(log, child, i, rest, parents) for rest in (None, middle))
        if back > held + _CLEARLY:
            out[i] = middle
    return out


def _likelihood(log: Log, child: str, i: int, rest: float | None, parents: Sequence[str]) -> float:
    residual = Residual(log, child, {i: rest})
    terms = (fit_term(residual, p) for p in parents)
    return residual.log_likelihood(i) + max([0.0, *(t.value for t in terms if t is not None)])
