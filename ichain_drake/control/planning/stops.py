"""Where along its prediction a drive may end: at the goal, where an interaction becomes possible, or at the last."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ichain_drake.control.planning.borders import Border, crossed
from ichain_drake.control.planning.goals import gap, value_of
from ichain_drake.control.planning.model import Batch
from ichain_drake.control.planning.plan import Condition
from ichain_drake.graph import Interaction
from ichain_drake.learning.model import InteractionModel


class Predicted(Protocol):
    """A batch of predicted drives."""

    @property
    def model(self) -> InteractionModel: ...  # noqa: D102

    @property
    def history(self) -> Sequence[Batch]: ...  # noqa: D102 - states after each step, shape (n, n_variables) each

    @property
    def last(self) -> NDArray[np.intp]: ...  # noqa: D102 - step at which each row ended, shape (n,)

    @property
    def lost(self) -> Sequence[Interaction | None]: ...  # noqa: D102 - what was inactive, a row


@dataclass(frozen=True)
class Stop:
    """One end of a drive.

    Attributes:
        row: of the batch.
        step: of the history.
        share: of the way from the step before, where it is between the two; else 1.
        condition: index of the condition that is met there, if that is why.
    """

    row: int
    step: int
    share: float = 1.0
    condition: int | None = None


def find_stops(run: Predicted, conditions: Sequence[Condition], borders: Sequence[Border]) -> list[Stop]:
    """All ends of all rows, in order of rows and steps, the full drive last.

    Args:
        run: predicted drives.
        conditions: a drive may end where one begins to hold.
        borders: and where its variables pass one of these values.
    """
    graph = run.model.graph
    found: list[list[Stop]] = [[] for _ in run.last]
    for k, c in enumerate(conditions):
        values = np.array([value_of(c, b, graph) for b in run.history])
        met = gap(c, values) == 0
        for r, last in enumerate(run.last):
            first = int(np.argmax(met[:last, r])) if met[:last, r].any() else None
            passed = None
            if np.isfinite(c.lower + c.upper) and first != 0:  # a narrow range may lie between two steps
                passed = crossed(values[: last + 1, r], 0.5 * (c.lower + c.upper))
            if passed is not None and abs(values[passed[0], r] - values[passed[0] - 1, r]) > 0.5 * (c.upper - c.lower):
                found[r].append(Stop(r, *passed, condition=k))
            elif first:
                found[r].append(Stop(r, first, condition=k))
    for b in borders:
        values = np.array([batch[b.object][:, b.variable] for batch in run.history])
        for r in map(int, np.flatnonzero((values.min(axis=0) < b.value) & (values.max(axis=0) > b.value))):
            passed = crossed(values[: run.last[r] + 1, r], b.value)
            found[r] += [] if passed is None else [Stop(r, *passed)]
    out = []
    for r, stops in enumerate(found):
        early = {(s.step, s.share): s for s in reversed(stops)}  # a condition's, where there is one
        if run.lost[r] is None:
            out += [early[k] for k in sorted(early) if early[k].step < run.last[r] or early[k].share < 1.0]
        out.append(Stop(r, int(run.last[r])))
    return out
