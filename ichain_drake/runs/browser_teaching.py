"""Demonstrations by a person in the browser: the world in real time, driven by gamepad, keys or mouse."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from pydrake.systems.framework import Context, LeafSystem

from ichain_drake.demonstrations import Demonstration
from ichain_drake.errors import InputError
from ichain_drake.runs.browser_pieces import PieceRecorder
from ichain_drake.scenarios.seats import Seat
from ichain_drake.simulation.episode import Episode
from ichain_drake.simulation.interruption import deferred_interrupt
from ichain_drake.simulation.real_time import FrameClock
from ichain_drake.state import FloatArray
from ichain_drake.timing import FRAME, FRAMES_PER_TICK
from ichain_drake.visualization import Camera, LiveView, PageButton

if TYPE_CHECKING:
    from ichain_drake.scenarios.base import Scenario

RECORD = PageButton("Record (R)", "KeyR", "record a piece; again: keep it", 0)
KEEP = PageButton("Keep and save (K)", "KeyK", "keep it, on disk", 2)
DISCARD = PageButton("Discard (X)", "KeyX", "discard it", 1)
RESTART = PageButton("Start anew (N)", "KeyN", "start anew (a piece is kept)", 3)
END = PageButton("End (Esc)", "Escape", "end")

_FIRST_RUN, _RUNS = 950, 50  # numbers that key noise; neither evaluations nor scripts use them
FRAMES_PER_NOTE = 20
"""How often an open piece goes to disk: a killed process loses two thirds of a second and a tick of it."""

_IDLE = 0.1  # [s] between two looks for a browser
# Nearer than a playback's, and with room at the left for the page's panel.
_CAMERA = Camera((0.42, -1.55, 0.85), (0.74, 0.1, 0.40), 38.0)
_ALARM = 8  # late frames
_FAREWELL = 0.6  # [s] in which the page asks once more


class Person(LeafSystem):
    """Sends the hand command that the person gave last.

    Ports: output `hand_command`.

    Args:
        command: the first one, shape (n_hand,).
    """

    def __init__(self, command: FloatArray) -> None:
        super().__init__()
        self.set_name("person")
        self._command = self.DeclareDiscreteState(command)
        self.DeclareStateOutputPort("hand_command", self._command)

    def send(self, root: Context, command: FloatArray) -> None:
        """Send a command from now on; `root` is the diagram's context."""
        self.GetMyMutableContextFromRoot(root).SetDiscreteState(self._command, command)


class TeachingSession:
    """A person drives; the world runs in real time while somebody looks, and stands still while nobody does.

    Axes are sampled at 30 Hz. The hand gets its command at the tick, as from every other commander: learning expects
    demonstrations whose hand moves at the beginning of a tick and then rests.

    Args:
        scenario: what is demonstrated.
        seat: what the person drives.
        folder: where kept pieces go.
        say: called with a line at each event.
    """

    def __init__(self, scenario: Scenario, seat: Seat, folder: Path, say: Callable[[str], None]) -> None:
        self._seat, self._say = seat, say
        about = {"scenario": scenario.name, "physics": scenario.physics, "seed": scenario.seed, "driven": seat.name}
        self.pieces = PieceRecorder(seat, scenario.graph, folder, about)
        for piece in self.pieces.recovered:
            say(f"{piece.name} is what a session that ended unexpectedly had recorded: {len(piece)} rows")
        self._marks = {
            f"{edge} on/off ({key})": (edge, f"Digit{key}") for key, edge in enumerate(self.pieces.edges[:9], 1)
        }
        marks = tuple(
            PageButton(label, key, f"mark {edge}: active, inactive") for label, (edge, key) in self._marks.items()
        )
        self.view = LiveView(
            f"Teach {scenario.name}: drive the {seat.name}",
            seat.drawings(),
            seat.plant(),
            seat.axes,
            (*seat.toggles, RECORD, KEEP, DISCARD, RESTART, *marks, END),
            camera=seat.camera or scenario.view() or _CAMERA,
        )
        self._folder = folder
        self._graph = scenario.graph
        self._restarts = 0
        self._over = False
        self._notice = ""
        self.clock = FrameClock()

    @property
    def address(self) -> str:
        """URL to open in a browser."""
        return self.view.page.address

    def run(self) -> list[Demonstration]:
        """Until the person ends it.

        Returns:
            The pieces saved.

        Raises:
            KeyboardInterrupt: on Ctrl-C; an open piece was saved.
            InputError: if the last piece can't be written then.
        """
        self._start()
        present = True  # so that the first look says that nobody is there
        try:
            with deferred_interrupt() as pressed:
                while not self._over:
                    if pressed():
                        self._save("Ctrl-C")
                        raise KeyboardInterrupt
                    if present and not self.view.page.watched:
                        present = False
                        self._leave()
                    elif not present and self.view.page.watched:
                        present = True
                        self._say("a browser is there")
                        self.clock.restart()
                    if present:
                        self._frame()
                    else:
                        time.sleep(_IDLE)
            self.view.page.show("ended", f"ended: {_count(len(self.pieces.saved))} in {self._folder}; close this page")
            time.sleep(_FAREWELL)
        except Exception:
            self._save("an error")
            raise
        finally:
            self.view.close()
        return self.pieces.saved

    def _start(self) -> None:
        """A world at its start."""
        number = _FIRST_RUN + self._restarts % _RUNS
        self._restarts += 1
        world = self._seat.world(number)
        context = world.CreateDefaultContext()
        states = {r: world.GetOutputPort(f"{r}.state").Eval(context) for r in world.graph.roots}
        hand = np.array(world.graph.join_command(states))
        self._person = Person(hand)
        self._episode = Episode(world, self._person)
        self._command, self._count = hand, 0
        self.view.begin(0.0, self._states(), {})

    def _states(self) -> dict[str, FloatArray]:
        return {name: self._episode.value(name, "state") for name in self._graph.objects}

    def _frame(self) -> None:
        """One frame: wait, read, step, show."""
        self.clock.wait()
        axes = self.view.controls.read()
        # Of buttons pressed within one frame, those first that make room for what the others begin.
        for name in sorted(self.view.controls.pressed(), key=lambda n: n not in (RESTART.name, DISCARD.name)):
            self._press(name)
        robot = self._graph.root
        hand = self._graph.join_command({r: self._episode.value(r, "state") for r in self._graph.roots})
        self._command = self._seat.command(axes, self._command, hand)
        if self._count % FRAMES_PER_TICK == 0:
            self._person.send(self._episode.context, self._command)
        self._episode.simulator.AdvanceTo((self._count + 1) * FRAME)
        self._count += 1
        if self._count % FRAMES_PER_NOTE == 0:
            self._note()
        world = self._episode.world
        positions = self._episode.value(robot, "plant_positions") if world.HasOutputPort("plant_positions") else None
        self.view.show(self._count * FRAME, self._states(), positions)
        self._tell()

    def _press(self, name: str) -> None:
        if name in (t.name for t in self._seat.toggles):
            self._command = self._seat.toggle(name, self._command)
        elif name == RECORD.name and self.pieces.open is None:
            self.pieces.begin(self._count)
            self.clock.measure()
            self._notice = ""
        elif name in (RECORD.name, KEEP.name):
            self._keep("the person")
        elif name == DISCARD.name and self.pieces.open is not None:
            self._notice = f"{self.pieces.open.name} was discarded"
            self.pieces.drop()
            self._say(self._notice)
        elif name == RESTART.name:
            if self._keep("a new start"):
                self._start()
                self.clock.restart()
        elif name in self._marks:
            edge = self._marks[name][0]
            self.pieces.mark(edge, self._count, self._active(edge))
        elif name == END.name:
            self._over = self._keep("the end")

    def _note(self) -> None:
        """Put the open piece on disk as far as it goes; the person hears of it where that can't be."""
        try:
            self.pieces.note(self._episode, self._count)
        except InputError as error:
            if not self._notice.startswith("NOT SAVED"):
                self._notice = f"NOT SAVED meanwhile: {error}"
                self._say(self._notice)

    def _keep(self, why: str) -> bool:
        """Save an open piece; whether none is open now. One that can't be written stays open, and the page says why."""
        try:
            self._save(why)
        except InputError as error:
            self._notice = f"NOT SAVED: {error}; make room and keep it again, or discard it"
            self._say(self._notice)
            return False
        return True

    def _save(self, why: str) -> None:
        if self.pieces.open is None:
            return
        name, sampling = self.pieces.open.name, self.clock.sampling()
        piece = self.pieces.keep(self._episode, self._count, sampling, why)
        if piece is None:
            self._notice = f"{name} was too short to keep"
            self._say(self._notice)
            return
        self._notice = f"{name} is saved: {len(piece)} rows"
        late = f", {sampling['late_frames']} late frames" if sampling["late_frames"] else ""
        rate = sampling.get("mean_period_ms", 0.0), sampling.get("p99_period_ms", 0.0)
        self._say(f"{self._notice}; sampled every {rate[0]:.2f} ms, 99 % within {rate[1]:.1f} ms{late} ({why})")

    def _leave(self) -> None:
        """Nobody looks any more: what was recorded until then is a piece of its own."""
        self._keep("the browser was lost")
        self.view.controls.let_go()
        self.view.page.show("waiting", "everything stands still until a browser looks", {"last": self._notice})
        self._say(f"nobody looks; open {self.address}")

    def _tell(self) -> None:
        piece = self.pieces.open
        values = {}
        if piece is not None:
            seconds = max(0.0, (self._count - piece.first) * FRAME)
            values["piece"] = f"{piece.name}, {seconds:.1f} s, {piece.rows(self._count)} rows"
            values["late frames"] = str(self.clock.late)
        values["saved"] = _count(len(self.pieces.saved))
        if self._notice:
            values["last"] = self._notice
        values["driven with"] = self.view.controls.device
        for edge in self.pieces.edges:
            values[edge] = self._flag(edge)
        text = "recording" if piece is not None else "not recording: press R to record"
        self.view.page.show("recording" if piece is not None else "idle", text, values, self._alarm())

    def _alarm(self) -> str:
        if self._notice.startswith("NOT SAVED"):
            return self._notice
        behind = self.clock.recently_late
        return f"{behind} frames came late in the last 5 s: this machine is too busy" if behind >= _ALARM else ""

    def _active(self, name: str) -> bool:
        """What the simulation says about an interaction."""
        edge = next(e for e in self._graph.interactions if e.name == name)
        index = self._graph.parents(edge.child).index(edge.parent)
        return bool(self._episode.value(edge.child, "active")[index])

    def _flag(self, name: str) -> str:
        mark = None if self.pieces.open is None else self.pieces.open.marked(name)
        active = self._active(name) if mark is None else mark
        return ("active" if active else "inactive") + ("" if mark is None else " (your mark)")


def _count(pieces: int) -> str:
    return "1 piece" if pieces == 1 else f"{pieces} pieces"
