"""One tick of the objects of one strongly connected component of a learned graph: of a single object, mostly."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ichain_drake.graph import Interaction
from ichain_drake.learned_graph.autodiff import chain_rule, values_of
from ichain_drake.learned_graph.reference import sweep_order
from ichain_drake.learned_graph.transition import ObjectTransition
from ichain_drake.learning import InteractionModel
from ichain_drake.state import StateSpace

Arrays = Mapping[str, NDArray[Any]]
Flags = Mapping[str, NDArray[np.bool_]]


class Members(Protocol):
    """What is asked of the objects of a component.

    Attributes:
        spaces: observable state space of each member, in the graph's order.
        parents: of each member, in the graph's order.
        outside: observable state space of each parent that is no member.
    """

    spaces: dict[str, StateSpace]
    parents: dict[str, tuple[str, ...]]
    outside: dict[str, StateSpace]

    def __call__(
        self, now: Arrays, after: Arrays, active: Flags, time: float
    ) -> tuple[dict[str, NDArray[Any]], dict[str, NDArray[np.bool_]]]:
        """States and flags of the members at t + 1.

        Args:
            now: states at t of members and outside parents, floats or AutoDiffXd.
            after: of outside parents, at t + 1.
            active: whether each member's incoming interactions are active at t, shape (n_parents,) each.
            time: named in errors [s].
        """
        ...


class LinkedMembers:
    """Members whose interactions have a forward model each, and are as active as whoever predicts says.

    Args:
        transitions: of every member, in the graph's order.
    """

    def __init__(self, transitions: Sequence[ObjectTransition]) -> None:
        self._members = {t.name: t for t in transitions}
        self.spaces = {t.name: t.space for t in transitions}
        self.parents = {t.name: tuple(t.models) for t in transitions}
        self.outside = {
            p: model.parent_space for t in transitions for p, model in t.models.items() if p not in self.spaces
        }

    def __call__(
        self, now: Arrays, after: Arrays, active: Flags, time: float
    ) -> tuple[dict[str, NDArray[Any]], dict[str, NDArray[np.bool_]]]:
        """Each after its active parents, whose order no fixed wiring can give; see `Members`."""
        on = [
            Interaction(parent, name)
            for name, parents in self.parents.items()
            for parent, flag in zip(parents, active[name], strict=True)
            if flag
        ]
        known = dict(after)
        for name in sweep_order(tuple(self.spaces), on, time):
            parents = self.parents[name]
            # An inactive parent may not be evaluated yet; its state at t stands in, unused.
            later = [known.get(p, now[p]) for p in parents]
            known[name] = self._members[name](now[name], [now[p] for p in parents], later, active[name])
        return {n: known[n] for n in self.spaces}, dict(active)


class ModelMembers:
    """Members of a model that tells by itself when interactions are active.

    Derivatives are central differences of the same functions, the status held fixed: effects see features of states,
    and these have no derivative of their own.

    Args:
        model: learned for goals.
        names: of the members, in the graph's order.
    """

    def __init__(self, model: InteractionModel, names: Sequence[str]) -> None:
        self._model = model
        spaces = {n: s.observable for n, s in model.graph.objects.items()}
        self.spaces = {n: spaces[n] for n in names}
        self.parents = {n: model.graph.parents(n) for n in names}
        self.outside = {p: spaces[p] for n in names for p in self.parents[n] if p not in self.spaces}
        self._edges = [(n, [Interaction(p, n) for p in self.parents[n]]) for n in names]

    def __call__(
        self, now: Arrays, after: Arrays, active: Flags, time: float
    ) -> tuple[dict[str, NDArray[Any]], dict[str, NDArray[np.bool_]]]:
        """As `InteractionModel.step`, to the last bit; see `Members`."""
        inputs = [*now.values(), *after.values()]
        plain = np.concatenate([values_of(x) for x in inputs])
        before = {e: flags[k : k + 1] for n, edges in self._edges for k, e in enumerate(edges) for flags in [active[n]]}
        states, on = self._advanced(plain[None], now, after, {}, before)
        self._model.refuse_cycles(on, time)
        flags = {n: np.array([on[e][0] for e in edges]) for n, edges in self._edges}
        values = {n: s[0] for n, s in states.items()}
        if all(x.dtype != object for x in inputs):
            return values, flags
        moved = self._slopes(plain, now, after, on)
        return {n: chain_rule(values[n], moved[n], np.concatenate(inputs)) for n in values}, flags

    def _advanced(
        self, joined: NDArray[Any], now: Arrays, after: Arrays, forced: Mapping[Any, Any], before: Mapping[Any, Any]
    ) -> tuple[dict[str, NDArray[Any]], dict[Any, NDArray[np.bool_]]]:
        """States of the members from all inputs side by side, shape (n, n_inputs)."""
        ends = np.cumsum([len(x) for x in (*now.values(), *after.values())])[:-1]
        parts = np.split(joined, ends, axis=1)
        rows = dict(zip(now, parts[: len(now)], strict=True))
        known = dict(zip(after, parts[len(now) :], strict=True))
        on: dict[Any, NDArray[np.bool_]] = {}
        self._model.advance_component(tuple(self.spaces), rows, known, forced, before, on)
        return {n: known[n] for n in self.spaces}, on

    def _slopes(
        self, plain: NDArray[Any], now: Arrays, after: Arrays, on: Mapping[Any, NDArray[np.bool_]]
    ) -> dict[str, NDArray[Any]]:
        model, size = self._model, len(plain)
        width = np.concatenate([model.high[n] - model.low[n] for n in (*now, *after)])
        steps = np.cbrt(np.finfo(float).eps) * np.maximum(width, np.abs(plain))
        steps = np.where(steps > 0, steps, np.cbrt(np.finfo(float).eps))
        joined = plain + np.concatenate([np.diag(steps), -np.diag(steps)])
        forced = {e: np.full(2 * size, bool(flag[0])) for e, flag in on.items()}
        states, _ = self._advanced(joined, now, after, forced, {})
        return {
            n: (self.spaces[n].difference(s[:size], s[size:]) / (2.0 * steps[:, None])).T for n, s in states.items()
        }
