"""A commander that knows beforehand what it will send."""

from __future__ import annotations

from pydrake.systems.framework import Context, LeafSystem, State

from ichain_drake.state import FloatArray
from ichain_drake.timing import FRAME, FRAMES_PER_TICK


class Commands(LeafSystem):
    """Sends a list of hand commands, one a tick, and stays at the last.

    Ports: output `hand_command`.

    Args:
        commands: shape (n_ticks, n_hand).
    """

    def __init__(self, commands: FloatArray) -> None:
        super().__init__()
        self.set_name("commands")
        self._commands = commands
        self._command = self.DeclareDiscreteState(commands[0])
        self._frame = self.DeclareDiscreteState(1)
        self.DeclareStateOutputPort("hand_command", self._command)
        self.DeclarePeriodicUnrestrictedUpdateEvent(FRAME, 0.0, self._decide)

    def _decide(self, context: Context, state: State) -> None:
        frame = int(context.get_discrete_state(self._frame).value()[0])
        discrete = state.get_mutable_discrete_state()
        discrete.set_value(self._frame, [frame + 1])
        if frame % FRAMES_PER_TICK == 0:
            tick = min(frame // FRAMES_PER_TICK, len(self._commands) - 1)
            discrete.set_value(self._command, self._commands[tick])
