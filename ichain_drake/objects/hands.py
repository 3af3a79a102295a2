"""Several hands that may take the same thing: one at a time, from closing around it until it opens."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ichain_drake.errors import InputError
from ichain_drake.objects.base import ParentStates
from ichain_drake.objects.parents import position_indices
from ichain_drake.state import FloatArray, StateSpace, Variable

_CUT = 0.5


class Hands:
    """Reads hands that move in the plane of y and z.

    Args:
        name: of the thing, for errors.
        space: of the thing; its first two variables are its place along y and z, and it has `variables`.
        parents: state spaces of the hands, by name.
        reach: how far from that place, along y and z, a hand that closes takes it [m].

    Attributes:
        places: where y and z are in each hand's state.
        grips: where its grip is.

    Raises:
        InputError: if there is no hand, or one has no position along y and z or no grip.
    """

    def __init__(
        self, name: str, space: StateSpace, parents: Mapping[str, StateSpace], reach: tuple[float, float]
    ) -> None:
        if not parents:
            raise InputError(f"{name}: a {space.type} has a hand among its parents; none given")
        self.places: dict[str, list[int]] = {}
        self.grips: dict[str, int] = {}
        self._closed: dict[str, int] = {}
        self._reach = reach
        for hand, theirs in parents.items():
            self.places[hand] = position_indices(theirs, "yz", name, hand)
            grip = [i for i, v in enumerate(theirs.variables) if v.kind == "binary"]
            if not grip:
                raise InputError(f"{name}: its parent {hand} has no grip, a binary variable")
            self.grips[hand] = grip[0]
            self._closed[hand] = space.index(f"closed_{hand}")

    @staticmethod
    def variables(hands: Sequence[str]) -> tuple[Variable, ...]:
        """The hidden variables of a thing that certain hands may take: whether each was closed a frame before."""
        return tuple(Variable(f"closed_{h}", "1", 0.0, 1.0, "binary", hidden=True) for h in hands)

    def holding(self, state: FloatArray, parents: ParentStates, active: Mapping[str, bool]) -> dict[str, bool]:
        """Which of the hands holds it; arguments as those of `WorldObject.decide_active`."""
        closed = {h: bool(parents[h][i] > _CUT) for h, i in self.grips.items()}
        on = {h: closed[h] and bool(active[h]) for h in self.grips}
        for h in self.grips:
            if closed[h] and state[self._closed[h]] < _CUT and not any(on.values()):
                off = np.abs(parents[h][self.places[h]] - state[:2])
                on[h] = bool((off <= self._reach).all())
        return on

    def remember(self, state: FloatArray, parents: ParentStates) -> None:
        """Note in the state, shape (..., n_variables), in place, which hands are closed."""
        for hand, index in self._closed.items():
            state[..., index] = parents[hand][..., self.grips[hand]] > _CUT
