"""The root of a learned graph: the robot's state is given, not learned."""

from __future__ import annotations

import sys
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydrake.autodiffutils import AutoDiffXd
from pydrake.systems.framework import BasicVector_, Context_, DiscreteValues_, LeafSystem_
from pydrake.systems.scalar_conversion import TemplateSystem

from ichain_drake.state import FloatArray
from ichain_drake.timing import TICK


@TemplateSystem.define("GivenRoot_", T_list=[float, AutoDiffXd], scope=sys.modules[__name__])
def GivenRoot_(T: type) -> type:  # noqa: N802 - the template is the class
    """The robot in a learned graph, for scalar type T."""

    class Impl(LeafSystem_[T]):  # type: ignore[misc, valid-type]
        """The robot in a learned graph, with the ports of a learned object.

        Ports: input `next_state`, the robot's state at t + 1. Outputs `next_state` (the same) and `state`, held
        from the last tick.

        Args:
            name: the robot's name in the graph.
            initial: observable state at t = 0, shape (n_variables,).
        """

        def _construct(self, name: str, initial: FloatArray, converter: Any = None) -> None:
            LeafSystem_[T].__init__(self, converter=converter)
            self.set_name(name)
            self.initial = np.array(initial, dtype=float)
            self._next = self.DeclareVectorInputPort("next_state", len(self.initial))
            self._state = self.DeclareDiscreteState(self.initial)
            self.DeclareStateOutputPort("state", self._state)
            self.DeclareVectorOutputPort("next_state", len(self.initial), self._pass_on, {self._next.ticket()})
            self.DeclarePeriodicDiscreteUpdateEvent(TICK, 0.0, self._update)

        def _construct_copy(self, other: Any, converter: Any = None) -> None:
            Impl._construct(self, other.get_name(), other.initial, converter=converter)

        def _pass_on(self, context: Context_[T], output: BasicVector_[T]) -> None:  # type: ignore[valid-type]
            output.SetFromVector(self._next.Eval(context))

        def _update(self, context: Context_[T], discrete: DiscreteValues_[T]) -> None:  # type: ignore[valid-type]
            value: NDArray[Any] = self._next.Eval(context)
            discrete.set_value(self._state, value)

    return Impl
