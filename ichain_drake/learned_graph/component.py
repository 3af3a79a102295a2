"""What the objects of a cycle of interactions share: the evaluation of their next states."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydrake.autodiffutils import AutoDiffXd
from pydrake.common.value import AbstractValue, Value
from pydrake.systems.framework import BasicVector_, Context_, LeafSystem_, ValueProducer
from pydrake.systems.scalar_conversion import TemplateSystem

from ichain_drake.graph import Interaction
from ichain_drake.learned_graph.autodiff import values_of
from ichain_drake.learned_graph.reference import sweep_order
from ichain_drake.learned_graph.transition import ObjectTransition


@TemplateSystem.define("LearnedComponent_", T_list=[float, AutoDiffXd])
def LearnedComponent_(T: type) -> type:  # noqa: N802 - the template is the class
    """Next states of the objects of one strongly connected component, for scalar type T."""

    class Impl(LeafSystem_[T]):  # type: ignore[misc, valid-type]
        """Next states of the objects of one strongly connected component of the graph (paper sec. V allows cycles).

        Which interactions are active decides in which order the members can be evaluated, so no fixed wiring of Drake
        ports can do it: this system reads the members' states and flags and sweeps the active interactions in order. It
        holds no state of its own.

        Ports: inputs `<member>.now` (its `state`) and `<member>.active`; for every parent outside, `<parent>` (its
        `next_state`) and `<parent>.now`. Outputs `<member>.next_state`.

        Args:
            members: transition of every member, in the graph's order.

        Raises:
            ActiveCycleError: in an evaluation, if the active interactions form a cycle.
        """

        def _construct(self, members: Sequence[ObjectTransition], converter: Any = None) -> None:
            LeafSystem_[T].__init__(self, converter=converter)
            self.members = {m.name: m for m in members}
            self.set_name(f"component:{','.join(self.members)}")
            sizes = {n: len(m.space) for n, m in self.members.items()}
            outside: dict[str, int] = {}
            for member in members:
                outside |= {p: len(m.parent_space) for p, m in member.models.items() if p not in self.members}
            self._now = {n: self.DeclareVectorInputPort(f"{n}.now", k) for n, k in (sizes | outside).items()}
            self._after = {n: self.DeclareVectorInputPort(n, k) for n, k in outside.items()}
            self._active = {
                n: self.DeclareVectorInputPort(f"{n}.active", len(m.models)) for n, m in self.members.items()
            }
            ends = np.cumsum([0, *sizes.values()])
            self._parts = {n: slice(a, b) for n, a, b in zip(sizes, ends[:-1], ends[1:], strict=True)}
            producer = ValueProducer(allocate=lambda: Value(BasicVector_[T](int(ends[-1]))), calc=self._sweep)
            self._swept = self.DeclareCacheEntry("swept", producer, {self.all_input_ports_ticket()})
            for name, size in sizes.items():
                self.DeclareVectorOutputPort(f"{name}.next_state", size, self._reader(name), {self._swept.ticket()})

        def _construct_copy(self, other: Any, converter: Any = None) -> None:
            Impl._construct(self, tuple(other.members.values()), converter=converter)

        def _reader(self, name: str) -> Any:
            def calc(context: Context_[T], output: BasicVector_[T]) -> None:  # type: ignore[valid-type]
                output.SetFromVector(self._swept.Eval(context).CopyToVector()[self._parts[name]])

            return calc

        def _sweep(self, context: Context_[T], swept: AbstractValue) -> None:  # type: ignore[valid-type]
            flags = {n: values_of(port.Eval(context)) > 0.5 for n, port in self._active.items()}  # flags are 0 or 1
            on = [
                Interaction(parent, name)
                for name, member in self.members.items()
                for parent, flag in zip(member.models, flags[name], strict=True)
                if flag
            ]
            time = float(values_of(np.array([context.get_time()]))[0])
            now = {n: port.Eval(context) for n, port in self._now.items()}
            after: dict[str, NDArray[Any]] = {n: port.Eval(context) for n, port in self._after.items()}
            for name in sweep_order(tuple(self.members), on, time):
                member = self.members[name]
                # An inactive parent may not be evaluated yet; its state at t stands in, unused.
                later = [after.get(p, now[p]) for p in member.models]
                after[name] = member(now[name], [now[p] for p in member.models], later, flags[name])
            swept.get_mutable_value().SetFromVector(np.concatenate([after[n] for n in self.members]))

    return Impl


LearnedComponent = LearnedComponent_[None]
