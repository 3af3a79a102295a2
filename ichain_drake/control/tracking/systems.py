"""The controller and the follower as Drake systems, deciding on every tenth 30 Hz frame by an integer counter."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from pydrake.systems.framework import BasicVector, Context, Diagram, DiagramBuilder, InputPort, State

from ichain_drake.control.settings import TRACKING
from ichain_drake.control.ticks import TickSystem
from ichain_drake.control.tracking.move_to import MoveTo
from ichain_drake.control.tracking.path import TimedPath
from ichain_drake.state import FloatArray, StateSpace
from ichain_drake.timing import TICK


class Controller(TickSystem):
    """Closes the loop around a chain with `MoveTo` (paper, Algorithm 1).

    Ports: an input per object of the chain, named after it, for its `measured`; `target`, the wanted values of the
    last object's target variables in the coming ticks, flattened (lookahead x n_targets); with `foresee` also `delay`,
    after how many ticks a command acts on what was measured, 0 if it is not connected. Outputs `hand_command`, and
    `wanted`, the states wanted of every object but the last, robot first.

    Args:
        policy: what decides.
        chain: observable state spaces along the chain, robot first, by object name.
        n_targets: number of target variables.
        initial_command: hand command before the first decision, shape (n_hand,).
        inputs: sizes of the object ports where they differ from the observable ones (an oracle reads full states).
        foresee: states of all objects so many ticks later, from these states, the command in force, and the ticks.
    """

    def __init__(
        self,
        policy: MoveTo,
        chain: Mapping[str, StateSpace],
        n_targets: int,
        initial_command: FloatArray,
        inputs: Sequence[int] | None = None,
        foresee: Callable[[Sequence[FloatArray], FloatArray, float], list[FloatArray]] | None = None,
    ) -> None:
        super().__init__("controller")
        self.policy = policy
        self._foresee = foresee
        self._n_targets = n_targets
        self.reads = tuple(chain)
        self.initial_command = np.asarray(initial_command, dtype=float)
        sizes = [len(s) for s in chain.values()] if inputs is None else list(inputs)
        self._ports = [self.DeclareVectorInputPort(n, k) for n, k in zip(chain, sizes, strict=True)]
        self._target = self.DeclareVectorInputPort("target", policy.lookahead * n_targets)
        self._delay = None if foresee is None else self.DeclareVectorInputPort("delay", 1)
        self._command = self.DeclareDiscreteState(self.initial_command)
        self._wanted = self.DeclareDiscreteState(sum(sizes[:-1]))
        self._memory = self.DeclareDiscreteState(policy.memory_size)
        self.DeclareStateOutputPort("hand_command", self._command)
        self.DeclareStateOutputPort("wanted", self._wanted)

    def decide(self, context: Context, state: State, tick: int) -> None:
        """Ask the policy."""
        discrete = state.get_mutable_discrete_state()
        states = [port.Eval(context)[None] for port in self._ports]
        wanted = self._target.Eval(context).reshape(1, -1, self._n_targets)
        memory = context.get_discrete_state(self._memory).value()[None]
        delay = delay_of(self._delay, context)
        if self._foresee is not None and delay > 0:
            states = self._foresee(states, context.get_discrete_state(self._command).value()[None], delay)
        command, memory, handed_down = self.policy.decide(states, wanted, memory)
        discrete.set_value(self._command, command[0])
        discrete.set_value(self._memory, memory[0])
        discrete.set_value(self._wanted, np.concatenate([w[0] for w in handed_down]))


def delay_of(port: InputPort | None, context: Context) -> float:
    """What an optional input `delay` says [ticks]."""
    return 0.0 if port is None or not port.HasValue(context) else float(port.Eval(context)[0])


class PathFollower(TickSystem):
    """Follows a timed path: where the object should be in the coming ticks, from where it is now.

    Ports: inputs `measured` of the object, and `delay`, see `Controller`; outputs `target` (lookahead x 2 wanted
    positions, flattened) and `progress` (index of the path's point that has been reached).

    Args:
        path: the timed path.
        space: the object's observable state space.
        targets: indices of the two position variables in it.
        lookahead: ticks of wanted positions.
    """

    def __init__(self, path: TimedPath, space: StateSpace, targets: Sequence[int], lookahead: int) -> None:
        super().__init__("follower")
        self.path = path
        self._targets = list(targets)
        self._ahead = TICK * np.arange(1, lookahead + 1)
        self._measured = self.DeclareVectorInputPort("measured", len(space))
        self._delay = self.DeclareVectorInputPort("delay", 1)
        self._progress = self.DeclareDiscreteState(1)
        self.DeclareVectorOutputPort("target", 2 * lookahead, self._calc_target)
        self.DeclareStateOutputPort("progress", self._progress)

    def _reached(self, context: Context) -> int:
        position = self._measured.Eval(context)[self._targets]
        last = int(context.get_discrete_state(self._progress).value()[0])
        return self.path.advance(position, last, TRACKING.search * TICK)

    def _calc_target(self, context: Context, output: BasicVector) -> None:
        now = self.path.time[self._reached(context)] + TICK * delay_of(self._delay, context)
        output.SetFromVector(self.path.at_time(now + self._ahead).ravel())

    def decide(self, context: Context, state: State, tick: int) -> None:
        """Remember how far it has come."""
        state.get_mutable_discrete_state().set_value(self._progress, [self._reached(context)])


class PathController(Diagram):
    """A controller and the follower that tells it where the last object of its chain should be.

    Ports: an input per object, as `Controller` has them, `<followed>.measured`, and `delay` where the controller has
    it; outputs `hand_command`, `wanted` and `progress`.

    Args:
        controller: decides.
        path: to follow.
        followed: name of the object that follows it.
        space: its observable state space.
        targets: indices of its two position variables in it.
    """

    def __init__(
        self, controller: Controller, path: TimedPath, followed: str, space: StateSpace, targets: Sequence[int]
    ) -> None:
        super().__init__()
        self.controller, self.followed, self.targets = controller, followed, tuple(targets)
        self.follower = PathFollower(path, space, targets, controller.policy.lookahead)
        builder = DiagramBuilder()
        builder.AddSystem(controller)
        builder.AddSystem(self.follower)
        builder.Connect(self.follower.GetOutputPort("target"), controller.GetInputPort("target"))
        for i in range(controller.num_input_ports()):
            port = controller.get_input_port(i)
            if port.get_name() != "target":
                builder.ExportInput(port, port.get_name())
        if controller.HasInputPort("delay"):
            builder.ConnectInput("delay", self.follower.GetInputPort("delay"))
        builder.ExportInput(self.follower.GetInputPort("measured"), f"{followed}.measured")
        for system, name in ((controller, "hand_command"), (controller, "wanted"), (self.follower, "progress")):
            builder.ExportOutput(system.GetOutputPort(name), name)
        builder.BuildInto(self)
        self.set_name("controller")
