"""A policy that decides for many runs at once, for each to the bits that it decides for that run alone.

A level works element by element, or on a matrix a row; only frozen models put rows together into one matrix product, in
which BLAS sums in an order that depends on how many there are. Here each row is a table of its own.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ichain_drake.control.tracking.levels import InverseLevel, Level, PredictiveLevel
from ichain_drake.control.tracking.move_to import MoveTo
from ichain_drake.learning.chain.models import ForwardModel
from ichain_drake.learning.frozen import FrozenModel
from ichain_drake.state import FloatArray


@dataclass(frozen=True)
class _AsTables:
    """A frozen model that takes each row for a table of one row."""

    model: FrozenModel

    def batch(self, rows: FloatArray) -> FloatArray:
        if self.model.takes_batches:
            return self.model.batch(rows[:, None])[:, 0]
        return np.concatenate([self.model.batch(row[None]) for row in rows])

    def batch_noted(self, rows: FloatArray) -> tuple[FloatArray, Any]:
        if self.model.takes_batches:
            values, note = self.model.batch_noted(rows[:, None])
            return values[:, 0], note
        each = [self.model.batch_noted(row[None]) for row in rows]
        return np.concatenate([value for value, _ in each]), [note for _, note in each]

    def jacobians(self, notes: Sequence[Any]) -> FloatArray:
        if self.model.takes_batches:
            return self.model.jacobians(notes)[:, :, 0]
        return np.concatenate([self.model.jacobians(of_row) for of_row in zip(*notes, strict=True)], axis=1)


@dataclass(frozen=True)
class _AsRows:
    """A frozen model that takes each row by itself, as a level does that has but one."""

    model: FrozenModel

    def value(self, row: FloatArray) -> FloatArray:
        return self.model.value(row)

    def batch(self, rows: FloatArray) -> FloatArray:
        return np.array([self.model.value(row) for row in rows])


def each_row(policy: MoveTo) -> MoveTo:
    """The policy for many runs at once.

    Args:
        policy: a `MoveTo` with levels of this package; or any that works row by row already.
    """
    if not isinstance(policy, MoveTo):
        return policy
    command = policy.robot.command
    robot = policy.robot if command is None else replace(policy.robot, command=_AsRows(command))  # type: ignore[arg-type]
    return MoveTo([_level(level) for level in policy.levels], robot)


def _level(level: Level) -> Level:
    if isinstance(level, InverseLevel):
        alone = _AsRows(level.inverse.frozen)
        return replace(level, inverse=replace(level.inverse, frozen=alone))  # type: ignore[arg-type]
    if isinstance(level, PredictiveLevel) and isinstance(level.model, ForwardModel):
        return replace(level, model=replace(level.model, frozen=_AsTables(level.model.frozen)))  # type: ignore[arg-type]
    return level
