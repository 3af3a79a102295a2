"""A learned object as a Drake system: one node of the learned graph."""

from __future__ import annotations

import sys
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydrake.autodiffutils import AutoDiffXd
from pydrake.systems.framework import BasicVector_, Context_, DiscreteValues_, LeafSystem_
from pydrake.systems.scalar_conversion import TemplateSystem

from ichain_drake.learned_graph.autodiff import values_of
from ichain_drake.learned_graph.members import Members
from ichain_drake.state import FloatArray
from ichain_drake.timing import TICK


@TemplateSystem.define("LearnedObject_", T_list=[float, AutoDiffXd], scope=sys.modules[__name__])
def LearnedObject_(T: type) -> type:  # noqa: N802 - the template is the class
    """An object of the learned graph, for scalar type T."""

    class Impl(LeafSystem_[T]):  # type: ignore[misc, valid-type]
        """An object of the learned graph, advanced once a tick (paper sec. III: O_i with the learned Tr_i).

        `next_state` is a Mealy output: the parents' `next_state` passes through to it, so that within one tick every
        object sees its parents at t + 1 and no level of the graph lags behind. In a cycle of interactions that would be
        an algebraic loop: there `next_state` is taken from a `LearnedComponent`, and Drake sees no feedthrough from the
        parents; everything else stays the same.

        Ports: inputs `<parent>` (its `next_state`) and `<parent>.now` (its `state`) for every parent; in a cycle also
        `component` and `component.active`. Outputs `state` (no feedthrough), `next_state`, and `active`: one 0/1 per
        incoming interaction, a discrete state, 1 by default, that whoever predicts may set in the context; what was
        learned for goals tells by itself when they change.

        Args:
            name: the object's name in the graph.
            members: of which it is one, the only one unless it is part of a cycle.
            initial: state at t = 0, shape (n_variables,); default 0, clipped to the bounds.
            active: of its interactions at t = 0, shape (n_parents,).

        Raises:
            InputError: if the initial state is not finite; names the variable.
        """

        def _construct(
            self,
            name: str,
            members: Members,
            initial: FloatArray | None = None,
            active: FloatArray | None = None,
            converter: Any = None,
        ) -> None:
            LeafSystem_[T].__init__(self, converter=converter)
            self.set_name(name)
            self.members = members
            space, parents = members.spaces[name], members.parents[name]
            start = np.clip(np.zeros(len(space)), space.lower, space.upper) if initial is None else initial
            self.initial = space.check(start, f"learned object {name}: initial state")
            self._parents = []
            for parent in parents:
                size = len((members.spaces | members.outside)[parent])
                after = self.DeclareVectorInputPort(parent, size)
                now = self.DeclareVectorInputPort(f"{parent}.now", size)
                self._parents.append((now, after))
            self._component = None
            if len(members.spaces) > 1:
                given = self.DeclareVectorInputPort("component", len(space))
                self._component = given, self.DeclareVectorInputPort("component.active", len(parents))
            self.initial_active = np.ones(len(parents)) if active is None else np.array(active, dtype=float)
            self._state = self.DeclareDiscreteState(self.initial)
            self._active = self.DeclareDiscreteState(self.initial_active)
            self.DeclareStateOutputPort("state", self._state)
            if self._component is not None:
                sources = {self._component[0].ticket()}
            else:
                sources = {self.xd_ticket()} | {port.ticket() for pair in self._parents for port in pair}
            self._next = self.DeclareVectorOutputPort("next_state", len(space), self._calc_next, sources)
            self.DeclareStateOutputPort("active", self._active)
            self.DeclarePeriodicDiscreteUpdateEvent(TICK, 0.0, self._update)

        def _construct_copy(self, other: Any, converter: Any = None) -> None:
            Impl._construct(
                self, other.get_name(), other.members, other.initial, other.initial_active, converter=converter
            )

        def _calc_next(self, context: Context_[T], output: BasicVector_[T]) -> None:  # type: ignore[valid-type]
            output.SetFromVector(self._evaluate(context)[0])

        def _evaluate(self, context: Context_[T]) -> tuple[NDArray[Any], NDArray[Any]]:  # type: ignore[valid-type]
            """State and flags at t + 1."""
            if self._component is not None:
                state, flags = self._component
                return state.Eval(context), flags.Eval(context)
            name = self.get_name()
            state = context.get_discrete_state(self._state).CopyToVector()
            flags = values_of(context.get_discrete_state(self._active).CopyToVector()) > 0.5  # flags are 0 or 1
            now, after = {name: state}, {}
            for parent, (before, later) in zip(self.members.parents[name], self._parents, strict=True):
                now[parent], after[parent] = before.Eval(context), later.Eval(context)
            time = float(values_of(np.array([context.get_time()]))[0])
            states, on = self.members(now, after, {name: flags}, time)
            return states[name], on[name].astype(float)

        def _update(self, context: Context_[T], discrete: DiscreteValues_[T]) -> None:  # type: ignore[valid-type]
            state, flags = self._evaluate(context)
            discrete.set_value(self._state, state)
            discrete.set_value(self._active, flags)

    return Impl
