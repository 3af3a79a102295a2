"""Vessels: objects that hold water and hand it to each other, without losing a drop or a degree.

Two vessels may give to each other, so that neither can wait for the other's new state: the graph is a cycle. Each
publishes what left it in the last frame (hidden variables `flow` and `flow_heat`) and, once the modes of the frame are
decided, from whom it takes (hidden `from_<giver>`). In the step that follows, the receiver adds what it takes to its
amount, and the giver, who sees the same two states, books the rest as spilled. So, at every frame,

    amounts + spilled amounts + flows  and  amounts x temperatures + spilled heat + flow heat - heat added

are constant over all vessels of a world.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from ichain_drake.errors import InputError
from ichain_drake.objects.base import ParentStates
from ichain_drake.state import FloatArray, Role, StateSpace, Variable
from ichain_drake.timing import FRAMES_PER_TICK

CAPACITY = 1.0
"""Amounts are fractions of a full vessel; all vessels have the same size."""

AMOUNT_NOISE = 0.004
"""Standard deviation of a reading of amount, temperature or change."""

_EMPTY = 1e-12
_PAST = FRAMES_PER_TICK - 1


def contents(amount: str) -> tuple[Variable, ...]:
    """The observable variables of what a vessel holds (paper sec. VI).

    Args:
        amount: name of the amount's variable.
    """
    return (
        Variable(amount, "1", 0.0, CAPACITY, role=Role("amount")),
        Variable("temperature", "1", 0.0, 1.0, role=Role("intensive", of=amount)),
        Variable("change", "1", -CAPACITY, CAPACITY, role=Role("change", of=amount)),
    )


def bookkeeping(givers: Iterable[str]) -> tuple[Variable, ...]:
    """The hidden variables of a vessel: what it published, spilled and held before, and from whom it takes."""
    hidden = ["flow", "flow_heat", "spilled", "spilled_heat"]
    hidden += [f"past_{k}" for k in range(1, _PAST + 1)]
    takes = [Variable(f"from_{g}", "1", 0.0, 1.0, "binary", hidden=True) for g in givers]
    return (*(Variable(name, hidden=True) for name in hidden), *takes)


def vessels(parents: Mapping[str, StateSpace]) -> list[str]:
    """Names of the parents that hold water, in order."""
    return [name for name, space in parents.items() if len(space.role_indices("amount"))]


def fill(space: StateSpace, state: FloatArray, amount: float, temperature: float, where: str) -> None:
    """Let a vessel hold an amount of a temperature since ever, in place.

    Raises:
        InputError: if one is outside 0..1.
    """
    for value, what in ((amount, "amount"), (temperature, "temperature")):
        if not 0.0 <= value <= CAPACITY:
            raise InputError(f"{where}: {what} {value} given; it is between 0 and 1")
    index = int(space.role_indices("amount")[0])
    state[index : index + 2] = amount, temperature
    state[space.index("past_1") : space.index("past_1") + _PAST] = amount


class Exchange:
    """The water of one vessel: what it takes from others, what of its own is spilled, and its change over a tick.

    Args:
        name: of the vessel.
        space: its state space, made of `contents` and `bookkeeping`.
        parents: state spaces of its parents.

    Raises:
        InputError: if a parent that holds water does not show what it gives, or does not tell that it takes.
    """

    def __init__(self, name: str, space: StateSpace, parents: Mapping[str, StateSpace]) -> None:
        self.givers = vessels(parents)
        self.amount = int(space.role_indices("amount")[0])
        self.flow = space.index("flow")
        self.past = space.index("past_1")
        for giver in self.givers:
            if f"from_{giver}" not in space.names:
                raise InputError(f"{name}: its state space was made without its parent {giver}")
            for variable in ("flow", f"from_{name}"):
                if variable not in parents[giver].names:
                    raise InputError(f"{name}: its parent {giver} has no hidden variable {variable}")
        self._takes = [space.index(f"from_{g}") for g in self.givers]
        self._theirs = [
            (g, p.index("flow"), p.index(f"from_{name}"), int(p.role_indices("amount")[0]))
            for g, p in ((g, parents[g]) for g in self.givers)
        ]

    def show(self, state: FloatArray, active: Mapping[str, bool]) -> None:
        """Tell in the state from whom it takes in this frame, in place; shape (..., n_variables)."""
        for giver, index in zip(self.givers, self._takes, strict=True):
            state[..., index] = active[giver]

    def step(self, s: FloatArray, parents: ParentStates, out: FloatArray) -> FloatArray:
        """One frame of everything that `contents` and `bookkeeping` declare.

        Args:
            s: the settled state, transposed: shape (n_variables, ...).
            parents: settled states of the parents, shape (..., n_parent_variables).
            out: water that leaves in the frame, shape (...).

        Returns:
            The state at the frame's end, transposed; other variables as they were.
        """
        new = s.copy()
        i, k, past = self.amount, self.flow, self.past
        water, heat = self._taken(s, parents)
        rest = s[i] - out
        new[i] = rest + water
        new[i + 1] = mix(rest, s[i + 1], water, heat)
        new[i + 2] = new[i] - s[past + _PAST - 1]
        lost = self._lost(s, parents)
        new[k], new[k + 1] = out, out * s[i + 1]
        new[k + 2] += lost * s[k]
        new[k + 3] += lost * s[k + 1]
        new[past + 1 : past + _PAST] = s[past : past + _PAST - 1]
        new[past] = s[i]
        return new

    def _taken(self, s: FloatArray, parents: ParentStates) -> tuple[FloatArray, FloatArray]:
        """Water that flows in, and its heat, shape (...) each."""
        water: FloatArray = np.float64(0.0)  # type: ignore[assignment]
        heat: FloatArray = np.float64(0.0)  # type: ignore[assignment]
        for (giver, flow, _, _), takes in zip(self._theirs, self._takes, strict=True):
            theirs = parents[giver].T
            share = _share(theirs[flow], s[self.amount], s[takes])
            water = water + share * theirs[flow]
            heat = heat + share * theirs[flow + 1]
        return water, heat

    def _lost(self, s: FloatArray, parents: ParentStates) -> FloatArray:
        """The share of its own published flow that nobody takes, shape (...)."""
        rest: FloatArray = np.float64(1.0)  # type: ignore[assignment]
        for giver, _, takes, amount in self._theirs:
            theirs = parents[giver].T
            rest = rest - _share(s[self.flow], theirs[amount], theirs[takes])
        return np.maximum(rest, 0.0)


def _share(flow: FloatArray, amount: FloatArray, takes: FloatArray) -> FloatArray:
    """The share of a flow that a vessel of this amount takes, shape (...): all of it while there is room."""
    room = np.maximum(CAPACITY - amount, 0.0)
    return takes * np.minimum(room / np.maximum(flow, _EMPTY), 1.0)


def mix(amount: FloatArray, temperature: FloatArray, water: FloatArray, heat: FloatArray) -> FloatArray:
    """Temperature of a mixture by volume (paper sec. VI); an empty vessel keeps what it shows. Shape (...)."""
    total = amount + water
    return np.where(total > _EMPTY, (amount * temperature + heat) / np.maximum(total, _EMPTY), temperature)
