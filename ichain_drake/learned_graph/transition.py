"""One tick of one learned object: the models of its incoming interactions, combined; with derivatives."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ichain_drake.errors import InputError
from ichain_drake.learned_graph.autodiff import chain_rule, values_of
from ichain_drake.learned_graph.reference import combine
from ichain_drake.learning.chain.models import ForwardModel
from ichain_drake.state import FloatArray, StateSpace


class ObjectTransition:
    """The next state of an object from its own and its parents' states (paper eq. 3: Tr_i with a factored action).

    Args:
        name: the object; named in errors.
        space: its observable state space.
        models: forward model of every incoming interaction, by parent, in the graph's order.

    Raises:
        InputError: if there is no model, or one was learned for another state space; names the variable.
    """

    def __init__(self, name: str, space: StateSpace, models: Mapping[str, ForwardModel]) -> None:
        if not models:
            raise InputError(f"learned object {name}: it has no incoming interaction; give a model per parent")
        for parent, model in models.items():
            require_same_space(f"model of {parent}->{name}, child", model.child_space, space)
        self.name = name
        self.space = space
        self.models = dict(models)

    def __call__(
        self,
        state: NDArray[Any],
        now: Sequence[NDArray[Any]],
        after: Sequence[NDArray[Any]],
        active: NDArray[np.bool_],
    ) -> NDArray[Any]:
        """The state at t + 1.

        Args:
            state: the object's state at t, shape (n_variables,), floats or AutoDiffXd.
            now: state of each parent at t, shape (n_parent_variables,) each.
            after: the same at t + 1.
            active: whether each interaction is active, shape (n_parents,).

        Returns:
            shape (n_variables,); of AutoDiffXd where any input is, with the same values to the last bit.
        """
        inputs = (state, *now, *after)
        if all(x.dtype != object for x in inputs):
            return self._value(state, now, after, active)
        floats = values_of(state), [values_of(x) for x in now], [values_of(x) for x in after]
        value, jacobian = self._value(*floats, active), self._jacobian(*floats, active)
        return chain_rule(value, jacobian, np.concatenate(inputs))

    def _value(
        self, state: FloatArray, now: Sequence[FloatArray], after: Sequence[FloatArray], active: NDArray[np.bool_]
    ) -> FloatArray:
        terms = zip(self.models.values(), now, after, active, strict=True)
        return combine(self.space, state, [model.predict_row(state, p, q) for model, p, q, on in terms if on])

    def _jacobian(
        self, state: FloatArray, now: Sequence[FloatArray], after: Sequence[FloatArray], active: NDArray[np.bool_]
    ) -> FloatArray:
        """Derivative by (state, parents at t, parents at t + 1) side by side, shape (n_variables, n_inputs)."""
        eye = np.eye(len(state))
        by_state = eye.copy()
        by_now, by_after = (
            [np.zeros((len(state), len(p))) for p in now],
            [np.zeros((len(state), len(p))) for p in after],
        )
        for i, model in enumerate(self.models.values()):
            if active[i]:
                _, by_child, by_parent, by_next = model.linearize(state[None], now[i][None], after[i][None])
                by_state += by_child[0] - eye  # effects add up as changes of the state
                by_now[i], by_after[i] = by_parent[0], by_next[0]
        return np.concatenate([by_state, *by_now, *by_after], axis=1)


def require_same_space(what: str, given: StateSpace, wanted: StateSpace) -> None:
    """Compare state spaces.

    Raises:
        InputError: if they differ; names the first variable that does.
    """
    if given == wanted:
        return
    if given.names != wanted.names:
        raise InputError(
            f"{what}: learned for the variables {', '.join(given.names)}, the graph has {', '.join(wanted.names)}; "
            "learn the interaction again"
        )
    differs = next((n for n, a, b in zip(given.names, given.variables, wanted.variables, strict=True) if a != b), None)
    detail = (
        f"type {given.type} is not {wanted.type}" if differs is None else f"variable {differs} is declared otherwise"
    )
    raise InputError(f"{what}: {detail} in the graph; learn the interaction again")
