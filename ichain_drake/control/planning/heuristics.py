"""Which predicted states a search looks at first: unmet conditions, and how new a state is (width-based search).

Counting unmet conditions alone fails where progress has to be undone first. States that show a value, or a pair of
values, that no state with the same unmet conditions has shown before are therefore preferred (best-first width search,
Lipovetzky & Geffner, AAAI 2017). Values are binned over the demonstrated ranges, so that no symbol has to be given.

Landmarks (Hoffmann, Porteous & Sebastia, JAIR 2004) are what must be true on the way: what only mixes becomes as hot,
or as anything, as what comes in, so that one of the givers must be so first. They follow from roles alone.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from itertools import combinations

import numpy as np

from ichain_drake.control.planning.goals import gap, value_of
from ichain_drake.control.planning.model import keeps, span
from ichain_drake.control.planning.plan import Condition, States
from ichain_drake.control.settings import PLANNING
from ichain_drake.learning.model import InteractionModel
from ichain_drake.learning.settings import LEARNING
from ichain_drake.rules import enabled


class Novelty:
    """How new states are.

    Args:
        model: names ranges and variables that keep their values.
        objects: those that count; default: all. A drift of the others would make every state new.
    """

    def __init__(self, model: InteractionModel, objects: Collection[str] | None = None) -> None:
        self._model = model
        counted = model.graph.objects if objects is None else objects
        self._objects = tuple(n for n in model.graph.objects if n != model.graph.root and n in counted)
        self._kept = {n: np.flatnonzero(keeps(model, n)) for n in self._objects}
        self._seen: dict[tuple[int, ...], set[tuple[tuple[int, int], ...]]] = {}

    def bins(self, states: States, count: float) -> tuple[int, ...]:
        """Bin of every variable that keeps its value."""
        out: list[int] = []
        for n in self._objects:
            part = self._kept[n]
            share = (states[n][part] - self._model.low[n][part]) / span(self._model, n)[part]
            out += np.round(share * count).astype(int).tolist()
        return tuple(out)

    def key(self, states: States) -> tuple[int, ...]:
        """States with equal keys are taken as the same."""
        return self.bins(states, 1.0 / LEARNING.near)

    def rank(self, states: States, unmet: Sequence[int]) -> int:
        """1 for a new value, 2 for a new pair of values, 3 for neither; remembers the state.

        Args:
            states: shape (n_variables,) each.
            unmet: what states are compared within.
        """
        if not enabled("novelty"):
            return 1
        seen = self._seen.setdefault(tuple(unmet), set())
        atoms = tuple(enumerate(self.bins(states, PLANNING.bins)))
        singles = {(a,) for a in atoms}
        pairs = set(combinations(atoms, 2))
        rank = 1 if singles - seen else 2 if pairs - seen else 3
        seen |= singles | pairs
        return rank


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
