"""What planning asks of a learned interaction graph beside its predictions, and states in batches."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from ichain_drake.learning.model import InteractionModel
from ichain_drake.state import BoolArray, FloatArray

Batch = dict[str, FloatArray]
"""States of every object and the robot, shape (n, n_variables) each."""


def keeps(model: InteractionModel, obj: str) -> BoolArray:
    """Which variables of an object keep their value or drift while nothing acts on it, shape (n_variables,)."""
    return np.array([v.kind in ("hold", "learned") for v in model.passive[obj].variables], dtype=bool)


def is_change(model: InteractionModel, obj: str) -> BoolArray:
    """Which variables of an object are the change of another one in a tick, shape (n_variables,)."""
    return np.array([v.kind == "change" for v in model.passive[obj].variables], dtype=bool)


def conserved(model: InteractionModel) -> tuple[tuple[tuple[str, int], ...], ...]:
    """Variables whose role is a conserved amount, as (object, index), grouped by unit."""
    found: dict[str, list[tuple[str, int]]] = {}
    for name in model.passive:
        space = model.graph.objects[name].observable
        for i in space.role_indices("amount"):
            found.setdefault(space.variables[i].unit, []).append((name, int(i)))
    return tuple(tuple(group) for group in found.values())


def span(model: InteractionModel, obj: str) -> FloatArray:
    """Width of the demonstrated range, shape (n_variables,), in the variables' units; above 0."""
    return np.maximum(model.high[obj] - model.low[obj], 1e-9)


def stack(states: Sequence[Mapping[str, FloatArray]]) -> Batch:
    """Rows of several states."""
    return {n: np.array([s[n] for s in states], dtype=float) for n in states[0]}


def row(batch: Mapping[str, FloatArray], index: int) -> Batch:
    """One row of a batch, shape (n_variables,) each."""
    return {n: np.array(v[index]) for n, v in batch.items()}


def take(batch: Mapping[str, FloatArray], rows: ArrayLike) -> Batch:
    """Some rows of a batch."""
    return {n: v[np.asarray(rows)] for n, v in batch.items()}
