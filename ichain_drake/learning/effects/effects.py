"""Effects: what an active interaction adds to a child's passive dynamics (paper eq. 2, 3; effects add up)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ichain_drake.graph import Interaction
from ichain_drake.learning.data import GraphData
from ichain_drake.learning.effects.active_ticks import ActiveTicks, active_ticks
from ichain_drake.learning.effects.alignment import Alignment
from ichain_drake.learning.effects.columns import Column, candidate_columns
from ichain_drake.learning.effects.fitted import Regression
from ichain_drake.learning.effects.regression import choose_regression, instrumented
from ichain_drake.learning.passive import PassiveDynamics
from ichain_drake.learning.settings import LEARNING
from ichain_drake.learning.spec import InteractionSpec
from ichain_drake.state import FloatArray, StateSpace


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


def learn_effects(
    data: GraphData,
    child: str,
    passive: PassiveDynamics,
    alignments: Mapping[Interaction, Alignment | None],
    spec: InteractionSpec,
    noise: Mapping[str, FloatArray],
    known: Mapping[Interaction, tuple[Effect, ...]] | None = None,
) -> dict[Interaction, tuple[Effect, ...]]:
    """Effects of all interactions on one object but those whose effects are known, each variable by itself."""
    known = known or {}
    edges = tuple(e for e in data.incoming(child) if e not in known)
    rows = {e: active_ticks(data, e) for e in edges}
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
        _tell_apart(i, rows, columns, passive, effects, spec, noise[child])
        if passive.space.jump_mask[i]:
            # What can't change gradually may do all of it in the tick in which an interaction begins: a latch.
            begun = {e: active_ticks(data, e, onsets=True) for e in edges if e not in effects}
            _tell_apart(i, begun, columns, passive, effects, spec, noise[child])
        for e in edges:
            if e in effects:
                found[e].append(effects[e])
    return {e: tuple(effects) for e, effects in found.items()}


def _tell_apart(
    i: int,
    rows: Mapping[Interaction, ActiveTicks],
    columns: Mapping[Interaction, list[Column]],
    passive: PassiveDynamics,
    effects: dict[Interaction, Effect],
    spec: InteractionSpec,
    noise: FloatArray,
) -> None:
    """Add to the known effects on one variable those of the interactions that `rows` are about.

    What acts alone often enough is fitted there, where nothing is to be told apart. Of those that hardly do, the one
    that explains most of what is left comes first, then the next on what that leaves (matching pursuit; Mallat and
    Zhang 1993). In any other order an interaction that is merely active at the same time takes what it can by the
    chance of few pieces, and the true cause gets the rest. At last each is fitted anew on all rows, to what the others
    leave.
    """

    def fit(e: Interaction, use: NDArray[np.bool_] | None = None) -> Effect | None:
        return _fit(i, rows[e], columns[e], passive, effects, spec, noise, use)

    together = []
    for e in rows:
        alone = rows[e].alone
        if alone.sum() >= 4 * LEARNING.rows or alone.all():
            _put(effects, e, fit(e, alone))
        else:
            together.append(e)
    while together:
        fits = {e: fit(e) for e in together}
        gains = {e: _gain(f) for e, f in fits.items() if f is not None}
        if not gains:
            break
        best = max(gains, key=gains.__getitem__)
        _put(effects, best, fits[best])
        together.remove(best)
    for _ in rows:
        before = set(effects)
        for e in rows:
            if _overlapping(rows[e], effects):
                found = fit(e)
                _put(effects, e, found if found is not None and _holds_alone(found, rows[e], passive) else None)
        if set(effects) == before:  # else some were fitted to what another left that is none
            break


def _holds_alone(effect: Effect, rows: ActiveTicks, passive: PassiveDynamics) -> bool:
    """Whether an effect predicts the rows in which nothing else acts no worse than no effect does.

    Effects add up: one that only shows beside others is what their models leave.
    """
    alone, i = rows.alone, effect.variable
    if not alone.any():
        return True
    space, ahead = passive.space, passive(rows.child[alone])
    residual = space.difference(rows.child_next[alone], ahead)[:, i]
    ahead[:, i] += effect(rows.parent[alone], rows.parent_next[alone], rows.child[alone])
    left = space.difference(rows.child_next[alone], space.clip(ahead))[:, i]
    return float(left @ left) <= float(residual @ residual)


def _put(effects: dict[Interaction, Effect], edge: Interaction, effect: Effect | None) -> None:
    """Replace what is held to be the effect of an interaction."""
    effects.pop(edge, None)
    if effect is not None:
        effects[edge] = effect


def _gain(effect: Effect) -> float:
    """Squared change that an effect explains on left-out rows, over all rows in which its interaction is active."""
    fitted = effect.regression
    return fitted.explained * fitted.scale**2 * fitted.samples


def _shows(column: Column, rows: ActiveTicks, space: StateSpace, noise: FloatArray) -> bool:
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
    return moved >= LEARNING.moving * np.sqrt(2.0) * float(noise[index].max())


def _overlapping(rows: ActiveTicks, effects: Mapping[Interaction, Effect]) -> bool:
    return any(on.any() for e, (_, _, on) in rows.others.items() if e in effects)


def _fit(
    i: int,
    rows: ActiveTicks,
    columns: list[Column],
    passive: PassiveDynamics,
    effects: Mapping[Interaction, Effect],
    spec: InteractionSpec,
    noise: FloatArray,
    use: NDArray[np.bool_] | None,
) -> Effect | None:
    space = passive.space
    residual = space.difference(rows.child_next, passive(rows.child))[:, i]
    value = rows.child[:, i]
    brought = value.copy()  # by the others
    for e, (parent, parent_next, on) in rows.others.items():
        if e in effects:
            theirs = on * effects[e](parent, parent_next, rows.child)
            residual, brought = residual - theirs, brought + theirs
    # What stands at a bound, or is brought there by others, can't show an effect that pushes it there.
    near = LEARNING.clear * noise[i]
    low, high = space.lower[i] + near, space.upper[i] - near
    stuck = ((value <= low) | (value >= high)) & (np.abs(residual) < 2 * near)
    after = rows.child_next[:, i]
    stuck |= (brought != value) & (((brought <= low) & (after <= low)) | ((brought >= high) & (after >= high)))
    keep = ~(stuck & (passive.variables[i].kind == "hold"))
    keep &= ~_meaningless(space, i, rows.child_next, noise)
    keep = keep if use is None else keep & use
    if not keep.any():
        return None
    if passive.variables[i].kind == "constant":  # without memory its own past tells only what its parents did then
        columns = [c for c in columns if (c.source, c.index) != ("child", i)]
    x = np.stack([c(rows.parent, rows.parent_next, rows.child) for c in columns], axis=1)
    # The noise of a reading that also starts the change would look like a return to the mean.
    for k in (k for k, c in enumerate(columns) if (c.source, c.index) == ("child", i)):
        earlier = columns[k](rows.parent, rows.parent_next, rows.child_before)
        x[keep, k] = instrumented(x[keep][:, [k]], earlier[keep, None])[:, 0]
    fitted = choose_regression(
        x[keep],
        residual[keep],
        rows.piece[keep],
        rows.row[keep],
        spec.effect_estimators,
        1 if passive.variables[i].kind == "constant" else spec.window,
        np.array([c.source in ("received", "mixing", "aligned_change") for c in columns]),
        float(noise[i]),
        {
            k: c.variance(rows.parent[keep], rows.parent_next[keep], rows.child[keep])
            for k, c in enumerate(columns)
            # What a spring takes back at once is where the parent has it, not a displacement from where it was.
            if c.declares(i) and passive.variables[i].kind != "constant"
        },
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
    return states[:, amount] < LEARNING.empty * noise[amount]
