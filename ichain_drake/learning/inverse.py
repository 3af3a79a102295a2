"""Inverse models: which interaction, and which state of its parent, makes a wanted change (paper appendix B)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ichain_drake.errors import InputError
from ichain_drake.graph import Interaction
from ichain_drake.learning.model import InteractionModel, States
from ichain_drake.learning.tick import LearnedInteraction
from ichain_drake.state import FloatArray, StateSpace

_STARTS = 32
_REFINED = 4
_ITERATIONS = 12
_DAMPING = 1e-6
_DIFFERENCE = 1e-4  # of a variable's range


@dataclass(frozen=True)
class Inverse:
    """An answer of the inverse model.

    Attributes:
        edge: the interaction type: which parent has to act.
        parent: its state at t + 1, shape (n_parent,); only `variables` of it matter.
        variables: indices of the parent's variables that the wanted change depends on.
        change: the child's change that the forward model predicts, shape (n_child,), passive dynamics included.
        error: wanted less predicted change, shape (n_child,); 0 where nothing is wanted.
        size: that error, each variable in units of its usual change, root mean square over those wanted.
    """

    edge: Interaction
    parent: FloatArray
    variables: tuple[int, ...]
    change: FloatArray
    error: FloatArray
    size: float


def invert(
    model: InteractionModel, child: str, wanted: ArrayLike, states: States, *, one_tick: bool = True
) -> tuple[Inverse, ...]:
    """Ways to make a wanted change of a child, best first; empty if no interaction affects any wanted variable.

    The learned effects are inverted numerically: from the parent's state and from states in the demonstrations, by
    damped Gauss-Newton within the range of the demonstrations.

    Args:
        model: the learned graph.
        child: the object to change.
        wanted: change over one tick, shape (n_child,); NaN for variables that don't matter.
        states: of child and parents now, shape (n_variables,).
        one_tick: keep each of the parent's variables within the largest step that the demonstrations show.

    Raises:
        InputError: on an object that nothing acts on, a wrong shape, or if nothing is wanted.
    """
    incoming = model.graph.incoming(child) if child in model.graph.objects else ()
    if not incoming:
        raise InputError(f"{child}: no interaction acts on it, so that no inverse exists; objects that can be changed "
                         f"are {', '.join(model.passive)}")  # fmt: skip
    space = model.graph.objects[child].observable
    target = np.asarray(wanted, dtype=float)
    if target.shape != (len(space),):
        raise InputError(f"wanted change of {child}: shape {target.shape} given, {len(space)} values needed "
                         f"({', '.join(space.names)})")  # fmt: skip
    asked = np.flatnonzero(np.isfinite(target))
    if not len(asked):
        raise InputError(f"wanted change of {child}: all values are NaN; name at least one change")
    answers = []
    for edge in incoming:
        learned = model.edges[edge]
        if any(learned.affects(int(i)) for i in asked):
            answers.append(_Problem(model, edge, learned, target, asked, states, one_tick).solve())
    return tuple(sorted(answers, key=lambda a: (a.size, model.order.index(a.edge))))


class _Problem:
    """The inversion of one interaction."""

    def __init__(
        self,
        model: InteractionModel,
        edge: Interaction,
        learned: LearnedInteraction,
        target: FloatArray,
        asked: np.ndarray,
        states: States,
        one_tick: bool,
    ) -> None:
        self.model, self.edge, self.target, self.asked = model, edge, target, asked
        self.states = {n: np.asarray(states[n], dtype=float) for n in (edge.parent, edge.child)}
        self.space = model.graph.objects[edge.parent].observable
        effects = [e for e in learned.effects if e.variable in asked]
        self.variables = tuple(sorted({i for e in effects for c in e.columns for i in c.parent_variables}))
        now = self.states[edge.parent]
        low, high = model.low[edge.parent], model.high[edge.parent]
        self.low, self.high = np.minimum(low, now), np.maximum(high, now)
        if one_tick:
            limit = model.step_limit[edge.parent]
            self.low, self.high = np.maximum(self.low, now - limit), np.minimum(self.high, now + limit)
        child = self.states[edge.child]
        passive = model.passive[edge.child]
        self.drift = passive.settle(child[None], passive(child[None]))[0] - child
        usual = {e.variable: e.regression.scale for e in learned.effects}
        noise = model.noise[edge.child]
        self.scale = np.array([max(usual.get(i, 0.0), noise[i], 1e-12) for i in range(len(child))])
        self.examples = learned.examples.active[edge.parent]

    def predicted(self, parents: FloatArray) -> FloatArray:
        """The child's change for parent states, shape (n, n_parent) -> (n, n_child)."""
        child = self.states[self.edge.child]
        effect = self.model.effect(self.edge, self.states, parents)
        passive = self.model.passive[self.edge.child]
        start = np.broadcast_to(child, effect.shape)
        after = passive.settle(start, passive(start) + effect)
        return passive.space.difference(after, start)

    def residual(self, parents: FloatArray) -> FloatArray:
        """Scaled error of the asked variables, shape (n, n_asked)."""
        return ((self.predicted(parents) - self.target) / self.scale)[:, self.asked]

    def consistent(self, parents: FloatArray) -> FloatArray:
        """Clip to the limits; a change goes with its amount."""
        out = np.clip(parents, self.low, self.high)
        for i, v in enumerate(self.space.variables):
            if v.role is not None and v.role.kind == "change":
                amount = self.space.index(v.role.of)
                if amount in self.variables:
                    out[:, i] = out[:, amount] - self.states[self.edge.parent][amount]
        return out

    def solve(self) -> Inverse:
        now, index = self.states[self.edge.parent], list(self.variables)
        starts = np.repeat(now[None], 1 + min(_STARTS, len(self.examples)), axis=0)
        drawn = np.linspace(0, len(self.examples) - 1, len(starts) - 1).round().astype(int)
        starts[1:, index] = self.examples[drawn][:, index]
        starts = self.consistent(starts)
        order = np.argsort((self.residual(starts) ** 2).sum(axis=1), kind="stable")
        best, best_cost = starts[order[0]], np.inf
        for k in order[:_REFINED]:
            candidate, cost = self._refine(starts[k])
            if cost < best_cost * (1 - 1e-9):
                best, best_cost = candidate, cost
        change = self.predicted(best[None])[0]
        error = np.where(np.isfinite(self.target), self.target - change, 0.0)
        size = float(np.sqrt(np.mean((error / self.scale)[self.asked] ** 2)))
        return Inverse(self.edge, best, self.variables, change, error, size)

    def _refine(self, start: FloatArray) -> tuple[FloatArray, float]:
        index = list(self.variables)
        point, error = start, self.residual(start[None])[0]
        if not index:
            return point, float(error @ error)
        width = np.maximum(self.model.high[self.edge.parent] - self.model.low[self.edge.parent], 1e-9)[index]
        damping = _DAMPING
        for _ in range(_ITERATIONS):
            probes = np.repeat(point[None], 2 * len(index), axis=0)
            step = _DIFFERENCE * width
            for k, i in enumerate(index):
                probes[k, i] += step[k]
                probes[len(index) + k, i] -= step[k]
            values = self.residual(probes)
            slope = ((values[: len(index)] - values[len(index) :]) / 2.0 / _DIFFERENCE).T
            shift = np.linalg.solve(slope.T @ slope + damping * np.eye(len(index)), -slope.T @ error)
            trial = point.copy()
            trial[index] += shift * width
            trial = self.consistent(trial[None])[0]
            value = self.residual(trial[None])[0]
            if value @ value < error @ error:
                point, error, damping = trial, value, max(damping * 0.1, 1e-12)
            else:
                damping = max(damping * 100.0, 1e-3)
        return point, float(error @ error)


def wanted_change(space: StateSpace, **changes: float) -> FloatArray:
    """A wanted change by variable name, shape (n_variables,); NaN elsewhere."""
    out = np.full(len(space), np.nan)
    for name, value in changes.items():
        out[space.index(name)] = value
    return out
