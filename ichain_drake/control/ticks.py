"""The base class of systems that decide once a tick: on every tenth 30 Hz frame, by an integer counter."""

from __future__ import annotations

from abc import abstractmethod

from pydrake.systems.framework import Context, LeafSystem, State

from ichain_drake.timing import FRAME, FRAMES_PER_TICK

# Frames from one event to the next: the greatest power of two that divides a tick, since `k (2 FRAME)` equals
# `(2 k) FRAME` to the last bit, which no other multiple does. Each call from Drake into Python costs, also one that
# finds that there is nothing to decide.
_EVENT_FRAMES = FRAMES_PER_TICK & -FRAMES_PER_TICK


class TickSystem(LeafSystem):
    """Decides in an unrestricted update, which Drake runs before the discrete updates of the same instant.

    So a decision read from states at t is in force in the frame that starts at t. A subclass declares its ports and
    the state that it decides about, and implements `decide`.

    Args:
        name: system name.
    """

    def __init__(self, name: str) -> None:
        super().__init__()
        self.set_name(name)
        self._frame = self.DeclareDiscreteState(1)
        self.DeclarePeriodicUnrestrictedUpdateEvent(_EVENT_FRAMES * FRAME, 0.0, self._on_event)

    @abstractmethod
    def decide(self, context: Context, state: State, tick: int) -> None:
        """One decision.

        Args:
            context: as it is at t.
            state: to be changed.
            tick: number of the tick that begins, from 0.
        """

    def _on_event(self, context: Context, state: State) -> None:
        count = state.get_mutable_discrete_state().get_mutable_value(self._frame)
        frame = int(count[0])
        count[0] += _EVENT_FRAMES
        if frame % FRAMES_PER_TICK == 0:
            self.decide(context, state, frame // FRAMES_PER_TICK)
