"""From the parents' states to an environment's action: one declared, linear term for each number of the action."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ichain_drake.errors import InputError
from ichain_drake.state import FloatArray, StateSpace


@dataclass(frozen=True)
class ActionTerm:
    """One number of an action: `offset + scale * variable`, then clipped to what the action space allows.

    Clipping makes half-waves: where an action is at least 0, a term with a scale above 0 is deaf to negative values
    of its variable, one with a scale below 0 to positive ones.

    Attributes:
        variable: the parent's variable.
        scale: action per unit of the variable.
        offset: action where the variable is 0, or where the interaction is not active.
        parent: whose variable it is; may be left out where there is one parent.
    """

    variable: str
    scale: float = 1.0
    offset: float = 0.0
    parent: str = ""


class ActionMap:
    """Evaluates the terms of an action.

    Args:
        terms: one for each number of the action.
        parents: state space of each parent, by name.
        size: how many numbers an action has.
        where: the object, for errors.

    Raises:
        InputError: on a wrong number of terms, or a parent or variable that is not there.
    """

    def __init__(self, terms: Sequence[ActionTerm], parents: Mapping[str, StateSpace], size: int, where: str) -> None:
        if len(terms) != size:
            raise InputError(f"{where}: an action has {size} number(s), {len(terms)} term(s) are declared")
        self._sources = []
        for term in terms:
            parent = term.parent or (next(iter(parents)) if len(parents) == 1 else "")
            if parent not in parents:
                known = ", ".join(parents) or "none"
                raise InputError(f"{where}: an action term reads parent {parent!r}; its parents are {known}")
            try:
                self._sources.append((parent, parents[parent].index(term.variable)))
            except InputError as error:
                raise InputError(f"{where}: an action term reads a variable of {parent}: {error}") from None
        self._scale = np.array([t.scale for t in terms])
        self._offset = np.array([t.offset for t in terms])

    def __call__(self, parents: Mapping[str, FloatArray], active: Mapping[str, FloatArray]) -> FloatArray:
        """Numbers of the action, not yet clipped, shape (..., size).

        Args:
            parents: state of each parent, shape (..., n_variables).
            active: 0 or 1 per parent, shape (...); an inactive parent counts as standing at 0.
        """
        values = [np.asarray(active[p]) * np.asarray(parents[p])[..., i] for p, i in self._sources]
        return self._offset + self._scale * np.stack(values, axis=-1)
