"""A commander that knows beforehand what it will send."""

from __future__ import annotations

from pydrake.systems.framework import Context, State

from ichain_drake.control.ticks import TickSystem
from ichain_drake.state import FloatArray


class Commands(TickSystem):
    """Sends a list of hand commands, one a tick, and stays at the last.

    Ports: output `hand_command`.

    Args:
        commands: shape (n_ticks, n_hand).
    """

    def __init__(self, commands: FloatArray) -> None:
        super().__init__("commands")
        self._commands = commands
        self._command = self.DeclareDiscreteState(commands[0])
        self.DeclareStateOutputPort("hand_command", self._command)

    def decide(self, context: Context, state: State, tick: int) -> None:
        """Send the tick's command, or the last."""
        command = self._commands[min(tick, len(self._commands) - 1)]
        state.get_mutable_discrete_state().set_value(self._command, command)
