"""What the objects of a cycle of interactions share: the evaluation of their next states."""

from __future__ import annotations

import sys
from typing import Any

import numpy as np
from pydrake.autodiffutils import AutoDiffXd
from pydrake.common.value import AbstractValue, Value
from pydrake.systems.framework import BasicVector_, Context_, LeafSystem_, ValueProducer
from pydrake.systems.scalar_conversion import TemplateSystem

from ichain_drake.learned_graph.autodiff import values_of
from ichain_drake.learned_graph.members import Members


@TemplateSystem.define("LearnedComponent_", T_list=[float, AutoDiffXd], scope=sys.modules[__name__])
def LearnedComponent_(T: type) -> type:  # noqa: N802 - the template is the class
    """Next states of the objects of one strongly connected component, for scalar type T."""

    class Impl(LeafSystem_[T]):  # type: ignore[misc, valid-type]
        """Next states of the objects of one strongly connected component of the graph (paper sec. V allows cycles).

        Which interactions are active decides in which order the members can be evaluated, so no fixed wiring of Drake
        ports can do it: this system reads the members' states and flags and sweeps the active interactions in order. It
        holds no state of its own.

        Ports: inputs `<member>.now` (its `state`) and `<member>.active`; for every parent outside, `<parent>` (its
        `next_state`) and `<parent>.now`. Outputs `<member>.next_state` and
        `<member>.next_active`.

        Args:
            members: the objects, more than one.

        Raises:
            ActiveCycleError: in an evaluation, if the active interactions form a cycle.
        """

        def _construct(self, members: Members, converter: Any = None) -> None:
            LeafSystem_[T].__init__(self, converter=converter)
            self.members = members
            self.set_name(f"component:{','.join(members.spaces)}")
            sizes = {n: len(s) for n, s in members.spaces.items()}
            counts = {n: len(members.parents[n]) for n in sizes}
            outside = {n: len(s) for n, s in members.outside.items()}
            self._now = {n: self.DeclareVectorInputPort(f"{n}.now", k) for n, k in (sizes | outside).items()}
            self._after = {n: self.DeclareVectorInputPort(n, k) for n, k in outside.items()}
            self._active = {n: self.DeclareVectorInputPort(f"{n}.active", k) for n, k in counts.items()}
            ends = np.cumsum([0, *sizes.values(), *counts.values()])
            parts = [slice(a, b) for a, b in zip(ends[:-1], ends[1:], strict=True)]
            producer = ValueProducer(allocate=lambda: Value(BasicVector_[T](int(ends[-1]))), calc=self._sweep)
            self._swept = self.DeclareCacheEntry("swept", producer, {self.all_input_ports_ticket()})
            names = [*(f"{n}.next_state" for n in sizes), *(f"{n}.next_active" for n in sizes)]
            for name, part in zip(names, parts, strict=True):
                size = part.stop - part.start
                self.DeclareVectorOutputPort(name, size, self._reader(part), {self._swept.ticket()})

        def _construct_copy(self, other: Any, converter: Any = None) -> None:
            Impl._construct(self, other.members, converter=converter)

        def _reader(self, part: slice) -> Any:
            def calc(context: Context_[T], output: BasicVector_[T]) -> None:  # type: ignore[valid-type]
                output.SetFromVector(self._swept.Eval(context).CopyToVector()[part])

            return calc

        def _sweep(self, context: Context_[T], swept: AbstractValue) -> None:  # type: ignore[valid-type]
            flags = {n: values_of(port.Eval(context)) > 0.5 for n, port in self._active.items()}  # flags are 0 or 1
            time = float(values_of(np.array([context.get_time()]))[0])
            now = {n: port.Eval(context) for n, port in self._now.items()}
            after = {n: port.Eval(context) for n, port in self._after.items()}
            states, on = self.members(now, after, flags, time)
            swept.get_mutable_value().SetFromVector(np.concatenate([*states.values(), *on.values()]))

    return Impl
