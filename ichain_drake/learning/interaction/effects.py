"""Effects: what an active interaction adds to a child's passive dynamics (paper eq. 2, 3; effects add up)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ichain_drake.graph import Interaction
from ichain_drake.learning.interaction.alignment import Alignment
from ichain_drake.learning.interaction.columns import Column, candidate_columns
from ichain_drake.learning.interaction.data import GraphData, Piece
from ichain_drake.learning.interaction.fitted import Regression
from ichain_drake.learning.interaction.passive import PassiveDynamics
from ichain_drake.learning.interaction.regression import choose_regression
from ichain_drake.learning.interaction.spec import InteractionSpec
from ichain_drake.state import FloatArray, StateSpace

MOVING = 1.5
"""Noises of a difference that a motion must have, root mean square, to be one."""

_AT_BOUND = 3.0  # noises
_EMPTY = 15.0  # noises: what one tick brings to less is one noise divided by another
_LEAST_ALONE = 24  # rows in which no other interaction acts


@dataclass(frozen=True)
class Effect:
    """What one interaction does to one variable of the child in a tick.

    Attributes:
        variable: index of the child's variable.
        columns: inputs, in the order of the regression's.
        regression: the fitted change.
    """

    variable: int
    columns: tuple[Column, ...]
    regression: Regression

    def __call__(self, parent: FloatArray, parent_next: FloatArray, child: FloatArray) -> FloatArray:
        """Predicted change, shape (n,), from the parent's states at t and t + 1 and the child's at t, (n, ...)."""
        if not self.columns:
            return np.full(len(child), self.regression.constant)
        return self.regression(np.stack([c(parent, parent_next, child) for c in self.columns], axis=1))


@dataclass
class _Rows:
    """Ticks in which an interaction is active."""

    parent: FloatArray
    parent_next: FloatArray
    child: FloatArray
    child_next: FloatArray
    others: dict[Interaction, tuple[FloatArray, FloatArray, NDArray[np.bool_]]]
    piece: NDArray[np.intp]
    row: NDArray[np.intp]


def _active_ticks(piece: Piece, edge: Interaction) -> NDArray[np.intp]:
    flag = piece.flags[edge]
    return np.flatnonzero(flag[:-1] & flag[1:])


def _collect(data: GraphData, edge: Interaction) -> _Rows:
    ticks = [_active_ticks(p, edge) for p in data.pieces]
    if sum(map(len, ticks)) == 0:  # never two rows in a row: take what there is
        ticks = [np.flatnonzero(p.flags[edge][1:]) for p in data.pieces]

    def take(obj: str, later: int) -> FloatArray:
        return np.vstack([p.states[obj][t + later] for p, t in zip(data.pieces, ticks, strict=True)])

    others = {
        e: (
            take(e.parent, 0),
            take(e.parent, 1),
            np.concatenate([p.flags[e][t + 1] for p, t in zip(data.pieces, ticks, strict=True)]),
        )
        for e in data.incoming(edge.child)
        if e != edge
    }
    return _Rows(
        take(edge.parent, 0),
        take(edge.parent, 1),
        take(edge.child, 0),
        take(edge.child, 1),
        others,
        np.repeat(np.arange(len(ticks)), [len(t) for t in ticks]),
        np.concatenate(ticks),
    )


def learn_effects(
    data: GraphData,
    child: str,
    passive: PassiveDynamics,
    alignments: Mapping[Interaction, Alignment | None],
    spec: InteractionSpec,
    noise: Mapping[str, FloatArray],
    known: Mapping[Interaction, tuple[Effect, ...]] | None = None,
) -> dict[Interaction, tuple[Effect, ...]]:
    """Effects of all interactions on one object but those whose effects are known.

    Each interaction is first fitted where no other one acts, if there is enough of that; then anew on what the others
    leave, so that several parents of one child are told apart.
    """
    known = known or {}
    edges = tuple(e for e in data.incoming(child) if e not in known)
    rows = {e: _collect(data, e) for e in edges}
    columns = {
        e: [
            c
            for c in candidate_columns(data, e, alignments[e], noise)
            if _shows(c, rows[e], data.spaces[e.parent], noise[e.parent])
        ]
        for e in edges
    }
    found: dict[Interaction, list[Effect]] = {e: [] for e in edges}
    for i, v in enumerate(passive.variables):
        if v.kind == "change":
            continue
        effects = {e: f for e, theirs in known.items() for f in theirs if e.child == child and f.variable == i}
        for sweep in range(2 if len(data.incoming(child)) > 1 else 1):
            for e in edges:
                others = [on for _, _, on in rows[e].others.values()]
                overlap = np.any(others, axis=0) if others else None
                if sweep and (overlap is None or not _overlapping(rows[e], effects)):
                    continue  # nothing to tell apart
                alone = ~overlap if not sweep and overlap is not None else None
                use = alone if alone is not None and alone.sum() >= _LEAST_ALONE else None
                effect = _fit(i, rows[e], columns[e], passive, effects, spec, noise[child], use)
                effects.pop(e, None)
                if effect is not None:
                    effects[e] = effect
        for e in edges:
            if e in effects:
                found[e].append(effects[e])
    return {e: tuple(effects) for e, effects in found.items()}


def _shows(column: Column, rows: _Rows, space: StateSpace, noise: FloatArray) -> bool:
    """Whether an input that is a motion of the parent is more than what readings of a parent at rest give.

    A hand that turns a knob where it is moves by its noise alone, which explains nothing: some of it will always seem
    to, and a controller would then move the hand away to turn the knob.
    """
    if column.source == "aligned_change":
        assert column.alignment is not None
        index = list(column.alignment.parent.indices)
    elif column.source == "parent_change" and space.variables[column.index].kind in ("real", "angle"):
        index = [column.index]
    else:
        return True
    moved = float(np.sqrt(np.mean(column(rows.parent, rows.parent_next, rows.child) ** 2)))
    return moved >= MOVING * np.sqrt(2.0) * float(noise[index].max())


def _overlapping(rows: _Rows, effects: Mapping[Interaction, Effect]) -> bool:
    return any(on.any() for e, (_, _, on) in rows.others.items() if e in effects)


def _fit(
    i: int,
    rows: _Rows,
    columns: list[Column],
    passive: PassiveDynamics,
    effects: Mapping[Interaction, Effect],
    spec: InteractionSpec,
    noise: FloatArray,
    use: NDArray[np.bool_] | None,
) -> Effect | None:
    space = passive.space
    residual = space.difference(rows.child_next, passive(rows.child))[:, i]
    for e, (parent, parent_next, on) in rows.others.items():
        if e in effects:
            residual = residual - on * effects[e](parent, parent_next, rows.child)
    # What stands at a bound can't show an effect that pushes it there.
    near = _AT_BOUND * noise[i]
    value = rows.child[:, i]
    stuck = (value <= space.lower[i] + near) | (value >= space.upper[i] - near)
    keep = ~(stuck & (np.abs(residual) < 2 * near) & (passive.variables[i].kind == "hold"))
    keep &= ~_meaningless(space, i, rows.child_next, noise)
    keep = keep if use is None else keep & use
    if not keep.any():
        return None
    if passive.variables[i].kind == "constant":  # without memory its own past tells only what its parents did then
        columns = [c for c in columns if (c.source, c.index) != ("child", i)]
    x = np.stack([c(rows.parent, rows.parent_next, rows.child) for c in columns], axis=1)
    fitted = choose_regression(
        x[keep],
        residual[keep],
        rows.piece[keep],
        rows.row[keep],
        spec.effect_estimators,
        1 if passive.variables[i].kind == "constant" else spec.window,
        np.array([c.source in ("received", "mixing", "aligned_change") for c in columns]),
        float(noise[i]),
        [k for k, c in enumerate(columns) if c.declares(i)],
    )
    if fitted is None:
        return None
    return Effect(i, tuple(columns[c] for c in fitted.columns), fitted)


def _meaningless(space: StateSpace, i: int, states: FloatArray, noise: FloatArray) -> NDArray[np.bool_]:
    """Rows in which a variable says nothing, shape (n,): an intensive property of what is all but empty."""
    role = space.variables[i].role
    if role is None or role.kind != "intensive":
        return np.zeros(len(states), dtype=bool)
    amount = space.index(role.of)
    return states[:, amount] < _EMPTY * noise[amount]
