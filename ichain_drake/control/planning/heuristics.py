"""What a search goes by: unmet conditions, and which states are alike."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from ichain_drake.control.planning.goals import gap, value_of
from ichain_drake.control.planning.model import keeps, span
from ichain_drake.control.planning.plan import Condition, States
from ichain_drake.learning.model import InteractionModel
from ichain_drake.learning.settings import LEARNING


class Alike:
    """Which states of a search are taken as the same.

    Args:
        model: names ranges and variables that keep their values.
        objects: those that count; default: all. A drift of the others would make every state another one.
    """

    def __init__(self, model: InteractionModel, objects: Collection[str] | None = None) -> None:
        self._model = model
        counted = model.graph.objects if objects is None else objects
        self._objects = tuple(n for n in model.graph.objects if n != model.graph.root and n in counted)
        self._kept = {n: np.flatnonzero(keeps(model, n)) for n in self._objects}

    def key(self, states: States) -> tuple[int, ...]:
        """Which part of its demonstrated range each variable is in that keeps its value; equal for like states."""
        out: list[int] = []
        for n in self._objects:
            part = self._kept[n]
            share = (states[n][part] - self._model.low[n][part]) / span(self._model, n)[part]
            out += np.round(share / LEARNING.near).astype(int).tolist()
        return tuple(out)


def unmet_conditions(conditions: Sequence[Condition], states: States, model: InteractionModel) -> tuple[int, ...]:
    """Indices of the conditions that do not hold."""
    return tuple(k for k, c in enumerate(conditions) if gap(c, value_of(c, states, model.graph)) > 0)
