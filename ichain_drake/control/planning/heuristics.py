"""What a search goes by: unmet conditions, landmarks on the way, and which states are alike.

Landmarks (Hoffmann, Porteous & Sebastia, JAIR 2004) are what must be true on the way: what only mixes becomes as hot,
or as anything, as what comes in, so that one of the givers must be so first. They follow from roles alone.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from ichain_drake.control.planning.goals import gap, value_of
from ichain_drake.control.planning.model import keeps, span
from ichain_drake.control.planning.plan import Condition, States
from ichain_drake.learning.model import InteractionModel
from ichain_drake.learning.settings import LEARNING
from ichain_drake.rules import enabled


class Alike:
    """Which states of a search are taken as the same.

    Args:
        model: names ranges and variables that keep their values.
        objects: those that count; default: all. A drift of the others would make every state another one.
    """

    def __init__(self, model: InteractionModel, objects: Collection[str] | None = None) -> None:
        self._model = model
        counted = model.graph.objects if objects is None else objects
        self._objects = tuple(n for n in model.graph.objects if n not in model.graph.roots and n in counted)
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


class Landmarks:
    """For conditions on what mixes: one of the givers must meet them first, and have something to give.

    Args:
        model: names roles and interactions.
        conditions: wanted.
    """

    def __init__(self, model: InteractionModel, conditions: Sequence[Condition]) -> None:
        self._model = model
        self._needed: list[tuple[int, Condition, tuple[tuple[Condition, Condition], ...]]] = []
        for k, c in enumerate(conditions):
            if givers := _givers(model, c):
                self._needed.append((k, c, givers))

    def open(self, states: States, unmet: Sequence[int]) -> tuple[int, ...]:
        """Indices of unmet conditions whose landmarks are not met either.

        Args:
            states: shape (n_variables,) each.
            unmet: indices of unmet conditions.
        """
        if not enabled("landmarks"):
            return ()
        graph = self._model.graph
        return tuple(
            k
            for k, _, givers in self._needed
            if k in unmet and not any(all(gap(c, value_of(c, states, graph)) == 0 for c in pair) for pair in givers)
        )


def _givers(model: InteractionModel, wanted: Condition) -> tuple[tuple[Condition, Condition], ...]:
    """For each object that a condition's variable mixes in from: the same condition there, and enough of it."""
    space = model.graph.objects[wanted.object].observable
    index = space.index(wanted.variable)
    variable = space.variables[index]
    if variable.role is None or variable.role.kind != "intensive":
        return ()
    out = []
    for edge in model.graph.incoming(wanted.object):
        if not any(f.variable == index for f in model.edges[edge].effects):
            continue
        theirs = model.graph.objects[edge.parent].observable
        like = [
            v for v in theirs.variables if v.role is not None and v.role.kind == "intensive" and v.unit == variable.unit
        ]
        if not like:
            return ()  # something else than mixing changes it
        for v in like:
            assert v.role is not None
            amount = v.role.of
            least = LEARNING.empty * float(model.noise[edge.parent][theirs.index(amount)])
            same = Condition(edge.parent, v.name, wanted.lower, wanted.upper)
            out.append((same, Condition(edge.parent, amount, least, float("inf"))))
    return tuple(out)
