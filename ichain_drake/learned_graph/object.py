"""A learned object as a Drake system: one node of the learned graph."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydrake.autodiffutils import AutoDiffXd
from pydrake.systems.framework import BasicVector_, Context_, DiscreteValues_, LeafSystem_
from pydrake.systems.scalar_conversion import TemplateSystem

from ichain_drake.learned_graph.autodiff import values_of
from ichain_drake.learned_graph.transition import ObjectTransition
from ichain_drake.learning.chain.models import ForwardModel
from ichain_drake.state import FloatArray, StateSpace
from ichain_drake.timing import TICK


@TemplateSystem.define("LearnedObject_", T_list=[float, AutoDiffXd])
def LearnedObject_(T: type) -> type:  # noqa: N802 - the template is the class
    """An object of the learned graph, for scalar type T."""

    class Impl(LeafSystem_[T]):  # type: ignore[misc, valid-type]
        """An object of the learned graph, advanced once a tick (paper sec. III: O_i with the learned Tr_i).

        `next_state` is a Mealy output: the parents' `next_state` passes through to it, so that within one tick every
        object sees its parents at t + 1 and no level of the graph lags behind. In a cycle of interactions that would be
        an algebraic loop: there `next_state` is taken from a `LearnedComponent`, and Drake sees no feedthrough from the
        parents; everything else stays the same.

        Ports: inputs `<parent>` (its `next_state`) and `<parent>.now` (its `state`) for every parent; in a cycle also
        `component`. Outputs `state` (no feedthrough), `next_state`, and `active`: one 0/1 per incoming interaction, a
        held discrete state, 1 by default, that whoever predicts sets in the context. An object adds up the changes that
        its active interactions make; without any it keeps its state.

        Args:
            name: the object's name in the graph.
            space: its observable state space.
            models: forward model of every incoming interaction, by parent, in the graph's order.
            initial: state at t = 0, shape (n_variables,); default 0, clipped to the bounds.
            in_component: whether the object is part of a cycle.

        Raises:
            InputError: if a model doesn't fit the state space or the initial state is not finite; names the variable.
        """

        def _construct(
            self,
            name: str,
            space: StateSpace,
            models: Mapping[str, ForwardModel],
            initial: FloatArray | None = None,
            in_component: bool = False,
            converter: Any = None,
        ) -> None:
            LeafSystem_[T].__init__(self, converter=converter)
            self.set_name(name)
            self.transition = ObjectTransition(name, space, models)
            start = np.clip(np.zeros(len(space)), space.lower, space.upper) if initial is None else initial
            self.initial = space.check(start, f"learned object {name}: initial state")
            self._parents = []
            for parent, model in models.items():
                after = self.DeclareVectorInputPort(parent, len(model.parent_space))
                now = self.DeclareVectorInputPort(f"{parent}.now", len(model.parent_space))
                self._parents.append((now, after))
            self._component = self.DeclareVectorInputPort("component", len(space)) if in_component else None
            self._state = self.DeclareDiscreteState(self.initial)
            self._active = self.DeclareDiscreteState(np.ones(len(models)))
            self.DeclareStateOutputPort("state", self._state)
            if self._component is not None:
                sources = {self._component.ticket()}
            else:
                sources = {self.xd_ticket()} | {port.ticket() for pair in self._parents for port in pair}
            self._next = self.DeclareVectorOutputPort("next_state", len(space), self._calc_next, sources)
            self.DeclareStateOutputPort("active", self._active)
            self.DeclarePeriodicDiscreteUpdateEvent(TICK, 0.0, self._update)

        def _construct_copy(self, other: Any, converter: Any = None) -> None:
            t = other.transition
            in_component = other._component is not None
            Impl._construct(self, t.name, t.space, t.models, other.initial, in_component, converter=converter)

        def _calc_next(self, context: Context_[T], output: BasicVector_[T]) -> None:  # type: ignore[valid-type]
            output.SetFromVector(self._evaluate(context))

        def _evaluate(self, context: Context_[T]) -> NDArray[Any]:  # type: ignore[valid-type]
            if self._component is not None:
                return self._component.Eval(context)
            active = values_of(context.get_discrete_state(self._active).CopyToVector()) > 0.5  # flags are 0 or 1
            return self.transition(
                context.get_discrete_state(self._state).CopyToVector(),
                [now.Eval(context) for now, _ in self._parents],
                [after.Eval(context) for _, after in self._parents],
                active,
            )

        def _update(self, context: Context_[T], discrete: DiscreteValues_[T]) -> None:  # type: ignore[valid-type]
            discrete.set_value(self._state, self._next.Eval(context))

    return Impl


LearnedObject = LearnedObject_[None]
