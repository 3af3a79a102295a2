"""Any discrete system with one clock, seen as one system with one state vector."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydrake.autodiffutils import AutoDiffXd
from pydrake.systems.framework import Context, Context_, DiscreteValues_, LeafSystem_, PortDataType, System
from pydrake.systems.scalar_conversion import TemplateSystem

from ichain_drake.errors import InputError


@TemplateSystem.define("SingleGroupAdapter_", T_list=[float, AutoDiffXd], scope=sys.modules[__name__])
def SingleGroupAdapter_(T: type) -> type:  # noqa: N802 - the template is the class
    """All discrete state groups of a system flattened into one, for scalar type T."""

    class Impl(LeafSystem_[T]):  # type: ignore[misc, valid-type]
        """All discrete state groups of a system flattened into one, at offset 0.

        Drake's `Linearize`, `FirstOrderTaylorApproximation` and `DirectTranscription` accept only a system with
        one discrete group that is updated at offset 0; a diagram of several systems has several groups.

        Ports: the system's inputs, by the same names; output `state`, the groups one after the other.

        Args:
            system: has discrete state only, updated by one clock (one period and offset).
            context: of the system; its state is the default state, and its time, parameters and held groups are those
                of every evaluation. Default: the system's default context.
            held: indices of groups that never change: they keep their values in `context` and are no part of the state.

        Raises:
            InputError: if the system has other state, another clock, or an input that is no vector.
        """

        def _construct(
            self, system: System, context: Context | None = None, held: Sequence[int] = (), converter: Any = None
        ) -> None:
            LeafSystem_[T].__init__(self, converter=converter)
            self.set_name("single_group")
            self.source = system
            self.source_context = system.CreateDefaultContext() if context is None else context.Clone()
            self.held = tuple(held)
            period = _period(system, self.source_context)
            # Every evaluation sets all that it reads in this context, so that nothing is remembered in it.
            self._system = system if T is float else system.ToAutoDiffXd()
            self._inner = self._system.CreateDefaultContext()
            self._inner.SetTimeStateAndParametersFrom(self.source_context)

            count = self.source_context.num_discrete_state_groups()
            self._groups = [i for i in range(count) if i not in self.held]
            parts = [self.source_context.get_discrete_state(i).CopyToVector() for i in self._groups]
            ends = np.cumsum([0, *(len(p) for p in parts)])
            self._parts = [slice(int(a), int(b)) for a, b in zip(ends[:-1], ends[1:], strict=True)]
            self._inputs = []
            for i in range(system.num_input_ports()):
                port = system.get_input_port(i)
                self._inputs.append(self.DeclareVectorInputPort(port.get_name(), port.size()))
            self._state = self.DeclareDiscreteState(np.concatenate([np.zeros(0), *parts]))
            self.DeclareStateOutputPort("state", self._state)
            self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

        def _construct_copy(self, other: Any, converter: Any = None) -> None:
            Impl._construct(self, other.source, other.source_context, other.held, converter=converter)

        def _update(self, context: Context_[T], discrete: DiscreteValues_[T]) -> None:  # type: ignore[valid-type]
            state: NDArray[Any] = context.get_discrete_state(self._state).CopyToVector()
            self._inner.SetTime(context.get_time())
            for group, part in zip(self._groups, self._parts, strict=True):
                self._inner.SetDiscreteState(group, state[part])
            for i, port in enumerate(self._inputs):
                self._system.get_input_port(i).FixValue(self._inner, port.Eval(context))
            after = self._system.EvalUniquePeriodicDiscreteUpdate(self._inner)
            discrete.set_value(self._state, np.concatenate([after.get_vector(g).CopyToVector() for g in self._groups]))

    return Impl


def _period(system: System, context: Context) -> float:
    name = system.get_name()
    if context.num_continuous_states() or context.num_abstract_states():
        raise InputError(
            f"system {name}: it has continuous or abstract state; a single group holds discrete state only"
        )
    timing = system.GetUniquePeriodicDiscreteUpdateAttribute()
    if timing is None:
        raise InputError(
            f"system {name}: its discrete updates have several clocks or none; give all one period and offset"
        )
    for i in range(system.num_input_ports()):
        port = system.get_input_port(i)
        if port.get_data_type() != PortDataType.kVectorValued:
            raise InputError(f"system {name}: input {port.get_name()} is no vector; connect it inside the system")
    return float(timing.period_sec())
