"""Whether a variable keeps its value or has no memory, before it is known what acts on it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ichain_drake.learning.discovery.log import Log
from ichain_drake.learning.discovery.residual import Residual, observed
from ichain_drake.learning.discovery.settings import DISCOVERY
from ichain_drake.learning.discovery.term_fit import fit_term
from ichain_drake.learning.settings import LEARNING


def constant_values(log: Log, child: str, parents: Sequence[str]) -> dict[int, float | None]:
    """Per variable the value to which it goes back within a tick, None where it keeps its own.

    Of the two, what leaves less unexplained together with the best single gated effect. Nothing brings a place, a
    content or what is dissolved in it back by itself within a tick. What is hardly ever at rest may have no memory all
    the same: a stick follows the hand that holds it all the time.
    """
    space, out = log.spaces[child], dict[int, float | None]()
    for i in observed(log, child):
        out[i] = None
        value, noise = log.states[child][:, i], log.noise[child][i]
        middle = float(np.median(value))
        if space.angle_mask[i]:
            continue
        rests = np.mean(np.abs(value - middle) <= LEARNING.clear * noise) >= DISCOVERY.rest
        change = space.difference(log.states[child][log.t + 1], log.states[child][log.t])[:, i]
        if rests and np.mean((value - middle) ** 2) < DISCOVERY.leaves * np.mean(change**2):
            out[i] = middle
            continue
        role = space.variables[i].role
        if role is not None and role.kind in ("position", "amount", "intensive"):
            continue
        held, back = (_likelihood(log, child, i, rest, parents) for rest in (None, middle))
        if back > held + DISCOVERY.clearly:
            out[i] = middle
    return out


def _likelihood(log: Log, child: str, i: int, rest: float | None, parents: Sequence[str]) -> float:
    residual = Residual(log, child, {i: rest})
    terms = (fit_term(residual, p) for p in parents)
    return residual.log_likelihood(i) + max([0.0, *(t.value for t in terms if t is not None)])
