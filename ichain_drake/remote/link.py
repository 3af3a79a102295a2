"""The controller's side of the line: readings frame by frame, in the order in which the robot speaks."""

from __future__ import annotations

import time
from collections import deque

import numpy as np

from ichain_drake.errors import UnreachableError
from ichain_drake.graph import InteractionGraph
from ichain_drake.remote.messages import (
    COMMAND,
    QUESTION,
    WORLD,
    Message,
    command_names,
    opened,
    other_names,
    world_names,
)
from ichain_drake.robot.motion import MOVE_FRAMES
from ichain_drake.state import FloatArray
from ichain_drake.timing import FRAME, FRAMES_PER_TICK

_PATIENCE = 5.0
"""How long a robot may take to speak at first, and be silent later [s]."""

_SLACK = 0.5
"""Part of a frame that a message may come late; then it is taken as lost, and the last reading stays."""

_QUESTIONS = 40
"""Of how long the line is, one a frame, before a run."""


class RobotLostError(UnreachableError):
    """Nobody answers where a robot should be."""


class RobotLink:
    """Hears a robot and commands it.

    The robot's frames are the clock. A message that does not come in time is a drop-out. A robot takes up a new command
    at its own ticks; how long messages take is measured at first, and decisions are made so many frames before a tick
    that they are there in time: no earlier, since what is decided on is then as new as can be. Where that would be
    while the hand moves, of which models of whole ticks know nothing, they are made at the tick before.

    Args:
        address: see `opened`.
        graph: what the robot has to speak of.

    Attributes:
        lead: frames between a reading and the tick at which what is decided on it acts.
        lost: frames without a message in time.
        round_trips: from a command to the first message of a robot that had it [s].

    Raises:
        InputError: on an address that is none.
        RobotLostError: if no robot speaks there, or one of another system.
    """

    def __init__(self, address: str, graph: InteractionGraph) -> None:
        self._address, self._names, self._wanted = address, world_names(graph), command_names(graph)
        self._line = opened(address)
        self._line.Subscribe(WORLD, self._on_world)
        self._newest: Message | None = None
        self._differs = ""
        self._fresh, self._came = False, time.monotonic()
        self._between: deque[float] = deque([FRAME], maxlen=_QUESTIONS)
        self._began, self._start, self._at = 0, 0.0, -1.0
        self._count, self._sent = 0, dict[int, float]()
        self.lead, self.lost = 0, 0
        self.round_trips: list[float] = []
        self._wait(_PATIENCE)
        if self._newest is None:
            raise RobotLostError(f"{address}: no robot speaks there; first start `ichain robot SYSTEM` at that address")
        self._measure_line()

    def _on_world(self, data: bytes) -> None:
        message = Message.decode(data)
        if message is None:
            return
        self._differs = other_names(self._names, message.names)
        if self._differs or (self._newest is not None and 0 < message.count < self._newest.count):
            return
        now = time.monotonic()
        passed = 1 if self._newest is None else max(1, message.count - self._newest.count)
        if self._newest is not None:
            self._between.append((now - self._came) / passed)
        self._newest, self._came, self._fresh = message, now, True

    def _wait(self, seconds: float) -> None:
        """Until there is something new, or the time is over."""
        until = time.monotonic() + seconds
        self._fresh = False
        self._line.HandleSubscriptions(0)
        while not (self._fresh or self._differs) and (left := until - time.monotonic()) > 0:
            self._line.HandleSubscriptions(max(1, min(100, int(1000 * left))))
        if self._differs:
            raise RobotLostError(f"{self._address}: the robot there is of another system: {self._differs}")

    @property
    def _period(self) -> float:
        """Of the robot's frames, by this machine's clock [s]."""
        return float(np.median(self._between))

    def _measure_line(self) -> None:
        """How many frames a question takes, there and back, and whether any was lost."""
        asked, trips = dict[int, float](), dict[int, float]()
        for count in range(1, _QUESTIONS + 1):
            asked[count] = time.monotonic()
            self._line.Publish(COMMAND, Message(count, QUESTION, np.zeros(1)).encode())
            self._wait(2 * self._period)
            assert self._newest is not None
            echo = int(self._newest.values[-1])
            if echo in asked and echo not in trips:
                trips[echo] = self._came - asked[echo]
        if not trips:
            raise RobotLostError(f"{self._address}: the robot there hears nothing")
        usual = float(np.median(list(trips.values())))
        frames = round(usual / self._period)
        # A question that was lost has no echo; an answer that was lost makes the next one late.
        every = len(trips) == 1 + max(trips) - min(trips)
        whole = every and max(trips.values()) < usual + _SLACK * self._period
        # The frame in which a command is heard is no delay. On a long line, or where messages get lost, it may not be
        # there in time: then the one of the next frame still is.
        lead = max(0, frames - 1) + (0 if whole and frames <= 1 else 1)
        part = lead % FRAMES_PER_TICK
        self.lead = lead if part < FRAMES_PER_TICK - MOVE_FRAMES else lead - part + FRAMES_PER_TICK

    def at(self, seconds: float) -> tuple[FloatArray, bool]:
        """The readings of a frame of this side's time, which begins at 0 and only rises; waits for them.

        Returns:
            Values of `world_names`, and whether they are new: else the message was lost or is late.

        Raises:
            RobotLostError: if the robot has been silent for long.
        """
        assert self._newest is not None
        if seconds < self._at or self._at < 0:  # a new run
            self._line.HandleSubscriptions(0)
            now = self._newest.count
            # Of a world that stands still the first command begins the first tick.
            first = -self.lead if now == 0 else now + (-self.lead - now) % FRAMES_PER_TICK
            self._began, self._start, self._at = first, seconds, seconds
            self._fresh = True
        if seconds > self._at or self._at == self._start:
            self._at = seconds
            self._hear(self._frame)
        return self._newest.values, self._fresh

    @property
    def _frame(self) -> int:
        """Of the robot, that this side's present time stands for; below 0 before the robot's first."""
        return self._began + round((self._at - self._start) / FRAME)

    def _hear(self, frame: int) -> None:
        assert self._newest is not None
        self._line.HandleSubscriptions(0)
        while self._newest.count < frame:
            due = self._came + (frame - self._newest.count + _SLACK) * self._period
            self._wait(due - time.monotonic())
            if not self._fresh:
                break
        self._fresh = self._newest.count >= frame
        heard = int(self._newest.values[-2])
        if heard in self._sent:
            self.round_trips.append(self._came - self._sent[heard])
            self._sent = {k: t for k, t in self._sent.items() if k > heard}
        if not self._fresh:
            self.lost += 1
            if time.monotonic() - self._came > _PATIENCE:
                raise RobotLostError(f"{self._address}: the robot has been silent for {_PATIENCE:g} s")

    @property
    def delay(self) -> float:
        """How long after the present reading a command acts, where this is a tick [frames]."""
        assert self._newest is not None
        return max(0.0, float(self._frame + self.lead - self._newest.count))

    def command(self, values: FloatArray) -> None:
        """Send the hand somewhere, shape (n_hand,)."""
        self._count += 1
        self._sent[self._count] = time.monotonic()
        self._line.Publish(COMMAND, Message(self._count, self._wanted, np.asarray(values, dtype=float)).encode())
