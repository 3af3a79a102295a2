"""Passive dynamics: what an object does while nothing acts on it (paper sec. V)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ichain_drake.learning.data import GraphData
from ichain_drake.learning.effects.fitted import Regression
from ichain_drake.learning.effects.regression import choose_regression, instrumented
from ichain_drake.learning.selection import by_part, clearly
from ichain_drake.learning.settings import LEARNING
from ichain_drake.learning.spec import InteractionSpec
from ichain_drake.state import FloatArray, StateSpace, wrap_angle

PassiveKind = Literal["hold", "constant", "learned", "change"]


@dataclass(frozen=True)
class PassiveVariable:
    """Passive dynamics of one variable.

    Attributes:
        kind: it keeps its value, goes to a constant, drifts as learned, or is the change of an amount (not learned).
        value: the constant.
        drift: for `learned`: the change in a tick from `inputs` of the object's own state.
        inputs: indices of the object's variables that `drift` sees.
        amount: for `change`: index of the amount.
        std: standard deviation of one tick's residual, in the variable's unit.
        samples: number of passive ticks seen.
    """

    kind: PassiveKind
    value: float = 0.0
    drift: Regression | None = None
    inputs: tuple[int, ...] = ()
    amount: int = -1
    std: float = 0.0
    samples: int = 0


@dataclass(frozen=True)
class PassiveDynamics:
    """Passive dynamics of an object.

    Attributes:
        space: its observable state space.
        variables: one entry a variable.
    """

    space: StateSpace
    variables: tuple[PassiveVariable, ...]

    def __call__(self, state: FloatArray) -> FloatArray:
        """The state one tick later while nothing acts, shape (n, n_variables), from one of the same shape.

        A change is given as 0: `settle` computes it once the amount is known.
        """
        out = np.array(state, dtype=float)
        for i, v in enumerate(self.variables):
            if v.kind == "constant":
                out[:, i] = v.value
            elif v.kind == "change":
                out[:, i] = 0.0
            elif v.drift is not None:
                out[:, i] += v.drift(state[:, list(v.inputs)])
        return out

    def settle(self, state: FloatArray, after: FloatArray) -> FloatArray:
        """Keep a predicted state within its declared bounds and compute changes from amounts; in place."""
        after[...] = self.space.clip(after)
        if self.space.angle_mask.any():
            after[:, self.space.angle_mask] = wrap_angle(after[:, self.space.angle_mask])
        for i, v in enumerate(self.variables):
            if v.kind == "change":
                after[:, i] = after[:, v.amount] - state[:, v.amount]
        return after


def learn_passive(data: GraphData, obj: str, spec: InteractionSpec, noise: Mapping[str, FloatArray]) -> PassiveDynamics:
    """Passive dynamics of an object, from the ticks in which no interaction acts on it."""
    space = data.spaces[obj]
    return PassiveDynamics(space, tuple(_learn_variable(data, obj, i, spec, noise[obj]) for i in range(len(space))))


def _learn_variable(data: GraphData, obj: str, i: int, spec: InteractionSpec, noise: FloatArray) -> PassiveVariable:
    space = data.spaces[obj]
    role = space.variables[i].role
    if role is not None and role.kind == "change":
        return PassiveVariable("change", amount=space.index(role.of), std=float(noise[i]))
    before, after, quiet_piece, lagged, piece, row = [], [], [], [], [], []
    for k, p in enumerate(data.pieces):
        busy = np.any([p.flags[e] for e in data.incoming(obj)], axis=0)
        states = p.states[obj]
        quiet = np.flatnonzero(~busy[1:])
        before.append(states[quiet])
        after.append(states[quiet + 1])
        quiet_piece.append(np.full(len(quiet), k))
        # With the reading before: the noise of a reading that also starts the change would look like a return to rest.
        quiet = np.flatnonzero(~busy[:-2] & ~busy[1:-1] & ~busy[2:])
        lagged.append((states[quiet], states[quiet + 1], states[quiet + 2]))
        piece.append(np.full(len(quiet), k))
        row.append(quiet)
    start, end = np.vstack(before), np.vstack(after)
    if len(start) < LEARNING.short:
        return PassiveVariable("hold", std=float(noise[i]), samples=len(start))
    change = space.difference(end, start)[:, i]
    middle = float(np.median(end[:, i]))
    held, around = float(np.mean(change**2)), float(np.mean((end[:, i] - middle) ** 2))
    # Rows at rest speak for neither, however many they are. What decides starts as far from rest as the variable is
    # while something acts on it: what is let go just above a table is no spring.
    acting = np.concatenate(
        [p.states[obj][np.any([p.flags[e] for e in data.incoming(obj)], axis=0)] for p in data.pieces]
    )
    away = float(np.sqrt(np.mean((acting[:, i] - middle) ** 2))) if len(acting) else 0.0
    away = max(away, LEARNING.away * float(noise[i]))
    # Two readings' noise is in a change, one's in a distance from rest.
    gain = change**2 / (4.0 * noise[i] ** 2) - (end[:, i] - middle) ** 2 / (2.0 * noise[i] ** 2)
    if clearly(by_part(np.where(np.abs(start[:, i] - middle) >= away, gain, 0.0), np.concatenate(quiet_piece))):
        return PassiveVariable("constant", value=middle, std=max(np.sqrt(around), noise[i]), samples=len(start))
    drift = None
    columns = [j for j in data.variables[obj] if not _is_change(space, j)]
    earlier, first, second = (np.vstack([part[k] for part in lagged]) for k in range(3))
    if len(first):
        drift = choose_regression(
            instrumented(first[:, columns], earlier[:, columns]),
            space.difference(second, first)[:, i],
            np.concatenate(piece),
            np.concatenate(row),
            spec.effect_estimators[:1],
            spec.window,
            np.ones(len(columns), dtype=bool),
            noise=float(noise[i]),
        )
    if drift is not None:
        inputs = tuple(columns[c] for c in drift.columns)
        return PassiveVariable("learned", drift=drift, inputs=inputs, std=drift.std, samples=len(start))
    return PassiveVariable("hold", std=float(np.sqrt(held)), samples=len(start))


def _is_change(space: StateSpace, index: int) -> bool:
    role = space.variables[index].role
    return role is not None and role.kind == "change"
