"""The robot's side: a world at the pace of the clock, which says what is measured and does what it hears."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from pydrake.systems.analysis import Simulator

from ichain_drake.remote.lossy import Lossy
from ichain_drake.remote.messages import COMMAND, QUESTION, WORLD, Message, command_names, opened, world_names
from ichain_drake.simulation.real_time import FrameClock
from ichain_drake.simulation.wiring import start_command
from ichain_drake.state import FloatArray
from ichain_drake.timing import FRAME, FRAMES_PER_TICK
from ichain_drake.world.world import World

_SILENT = 3 * FRAMES_PER_TICK
"""Frames without a command after which nobody is taken to command any more."""


class RobotServer:
    """Runs a world in real time for a controller in another process.

    In each frame of 1/30 s it says what is measured (see `world_names`), and does what the newest command wants. The
    world stands still at its start until the first command. Without further ones the hand goes to where it was sent
    last, and stays there: whoever commands may die at any moment.

    Args:
        world: at its start.
        address: see `opened`.
        pace: simulated seconds in a second.
        lost, late, seed: of messages either way; see `Lossy`.

    Raises:
        InputError: on an address that is none, or settings of `Lossy`.
    """

    def __init__(
        self, world: World, address: str, *, pace: float = 1.0, lost: float = 0.0, late: int = 0, seed: int = 0
    ) -> None:
        self.world, graph = world, world.graph
        self._names, self._wanted = world_names(graph), command_names(graph)
        self._said: Lossy[Message] = Lossy(lost, late, seed)
        self._heard: Lossy[Message] = Lossy(lost, late, seed + 1)
        self._clock = FrameClock(pace)
        start = start_command(world)
        self._simulator = Simulator(world)
        self._context = self._simulator.get_mutable_context()
        world.GetInputPort("hand_command").FixValue(self._context, start)
        self._simulator.Initialize()
        self._newest = Message(0, self._wanted, start)
        self._line = opened(address)
        self._line.Subscribe(COMMAND, self._on_command)
        self._sent = self._question = 0
        self._last_heard = 0
        self.frame = 0
        """Of the world: how far it has come."""

    def _on_command(self, data: bytes) -> None:
        message = Message.decode(data)
        if message is not None and message.names in (self._wanted, QUESTION):
            self._heard.put(self._sent, message)

    def _say(self) -> None:
        context, values = self._context, []
        for name in self.world.graph.objects:
            for port in ("measured", "valid", "state", "active"):
                if self.world.HasOutputPort(f"{name}.{port}"):
                    values.append(self.world.GetOutputPort(f"{name}.{port}").Eval(context))
        said = np.concatenate([*values, [float(self._newest.count), float(self._question)]])
        self._said.put(self._sent, Message(self.frame, self._names, said))
        for message in self._said.get(self._sent):
            self._line.Publish(WORLD, message.encode())

    def _hear(self) -> None:
        self._line.HandleSubscriptions(0)
        for message in self._heard.get(self._sent):
            if message.names == QUESTION:
                self._question = message.count
            elif message.count > self._newest.count or message.count == 1:  # 1: somebody began anew
                self._newest, self._last_heard = message, self._sent
                self.world.GetInputPort("hand_command").FixValue(self._context, message.values)

    @property
    def commanded(self) -> bool:
        """Whether somebody commands: the newest command is not old."""
        return self._newest.count > 0 and self._sent - self._last_heard <= _SILENT

    def state(self, name: str) -> FloatArray:
        """The true state of an object now, shape (n_variables,)."""
        return np.array(self.world.GetOutputPort(f"{name}.state").Eval(self._context))

    def run(self, seconds: float, seen: Callable[[RobotServer], bool] | None = None) -> None:
        """Serve.

        Args:
            seconds: of the world, at most.
            seen: called after each frame, also of a world that still stands; true ends it.
        """
        self._clock.restart()
        while self.frame * FRAME < seconds:
            self._say()
            self._clock.wait()
            self._hear()
            self._sent += 1
            if self._newest.count:
                self.frame += 1
                self._simulator.AdvanceTo(self.frame * FRAME)
            if seen is not None and seen(self):
                return
