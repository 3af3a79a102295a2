"""The controller of an interaction graph as a Drake system."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from pydrake.common.value import Value
from pydrake.systems.framework import Context, State

from ichain_drake.control.execution.executor import Executor, Memory
from ichain_drake.control.ticks import TickSystem
from ichain_drake.state import FloatArray, StateSpace


class _Kept:
    """A memory as a value of a context: never changed, so that a copy of the context may share it.

    Drake copies all abstract state at every unrestricted update of any system, 30 times a second.
    """

    def __init__(self, memory: Memory) -> None:
        self.memory = memory

    def __deepcopy__(self, memo: dict[int, object]) -> _Kept:
        return self


class GraphController(TickSystem):
    """Closes the loop around an interaction graph with an `Executor` (paper appendix B).

    Ports: for every object and the robot an input of its name for `measured`, and `<object>.valid`; an unconnected
    `valid` counts as valid. Outputs `hand_command`, and what it is doing: `mode` (see `Mode`), `edge` (index of the
    interaction that it is about; -1 for none), `skill` (0 none, 1 an activation, 2 a deactivation), `plan_step` (index
    of the plan's step; -1 for none).

    Args:
        executor: what decides.
        initial_command: before the first decision, shape (n_hand,).
    """

    def __init__(self, executor: Executor, initial_command: FloatArray) -> None:
        super().__init__("controller")
        self.executor = executor
        self._edges = executor.model.graph.interactions
        spaces: Mapping[str, StateSpace] = {n: s.observable for n, s in executor.model.graph.objects.items()}
        self._measured = {n: self.DeclareVectorInputPort(n, len(s)) for n, s in spaces.items()}
        self._valid = {n: self.DeclareVectorInputPort(f"{n}.valid", 1) for n in spaces}
        self._command = self.DeclareDiscreteState(np.asarray(initial_command, dtype=float))
        self.DeclareStateOutputPort("hand_command", self._command)
        self._shown = {}
        for name, first in (("mode", 0.0), ("edge", -1.0), ("skill", 0.0), ("plan_step", -1.0)):
            self._shown[name] = self.DeclareDiscreteState(np.array([first]))
            self.DeclareStateOutputPort(name, self._shown[name])
        self._memory = self.DeclareAbstractState(Value(_Kept(executor.start(np.asarray(initial_command, dtype=float)))))

    def memory(self, context: Context) -> Memory:
        """What the execution remembers, given this system's context; not to be changed."""
        return context.get_abstract_state(int(self._memory)).get_value().memory

    def decide(self, context: Context, state: State, tick: int) -> None:
        """Ask the executor."""
        discrete = state.get_mutable_discrete_state()
        measured = {n: port.Eval(context) for n, port in self._measured.items()}
        valid = {n: not p.HasValue(context) or bool(p.Eval(context)[0] > 0.5) for n, p in self._valid.items()}
        slot = state.get_mutable_abstract_state(int(self._memory))
        memory = slot.get_value().memory.own()
        command = self.executor.decide(memory, measured, valid)
        slot.set_value(_Kept(memory))
        discrete.set_value(self._command, command)
        edge, skill = memory.edge, {1: 2, 2: 1}.get(int(memory.mode), 0)
        for name, value in (
            ("mode", int(memory.mode)),
            ("edge", -1 if edge is None else self._edges.index(edge)),
            ("skill", skill),
            ("plan_step", memory.step),
        ):
            discrete.set_value(self._shown[name], [float(value)])
