"""A run in the browser: its scene while it runs, sliders for what may be adjusted, a button to stop it."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any

from ichain_drake.control.tracking.systems import PathController
from ichain_drake.scenarios.adjustable import Adjustable
from ichain_drake.simulation.episode import Episode
from ichain_drake.simulation.real_time import FrameClock
from ichain_drake.timing import FRAME
from ichain_drake.visualization import LiveView, PageButton

if TYPE_CHECKING:
    from ichain_drake.scenarios.base import Scenario

STOP = PageButton("Stop the run (Esc)", "Escape", "stop: report and recording are kept")

_TELL = 0.1  # [s] of real time between two changes of the panel
_FAREWELL = 0.6  # [s] in which the page asks once more


class LiveRun:
    """A `Watcher` that shows episodes in the browser. Whether a browser looks makes no difference to the run.

    Args:
        scenario: what runs; its `adjustables` become sliders.
        realtime: whether frames wait for the clock on the wall.
    """

    def __init__(self, scenario: Scenario, *, realtime: bool = False) -> None:
        self._adjustables = scenario.adjustables()
        lines = [[[], "sliders at the right: change it while it runs", ""]] if self._adjustables else []
        drawings, plant = scenario.drawings(), scenario.drawn_plant()
        title = f"{scenario.name}, {scenario.physics} physics, seed {scenario.seed}"
        self.view = LiveView(title, drawings, plant, buttons=(STOP,), instructions=lines, camera=scenario.view())
        for item in self._adjustables:
            self.view.meshcat.AddSlider(item.name, item.lower, item.upper, item.step, item.value)
        self._clock = FrameClock() if realtime else None
        self._in_force = {item.name: self._slider(item) for item in self._adjustables}
        self._line, self._told, self._episodes = "starting", 0.0, 0
        self._start = (0.0, 0.0)
        self.changes: list[dict[str, Any]] = []

    @property
    def address(self) -> str:
        """URL to open in a browser."""
        return self.view.page.address

    def report(self) -> dict[str, Any]:
        """For the report: what the person changed, and when; without changes, watching makes no difference."""
        return {"realtime": self._clock is not None, "changes": self.changes}

    def say(self, line: str) -> None:
        """Show what is being done."""
        self._line = line
        self.view.page.show("running", line)

    def begin(self, episode: Episode) -> None:
        """Show an episode's start; what was adjusted before stays in force."""
        self._episodes += 1
        driver = episode.commander if isinstance(episode.commander, PathController) else None
        lines = {} if driver is None or episode.path is None else {driver.followed: episode.path.points}
        states = {name: episode.value(name, "state") for name in episode.world.graph.objects}
        self.view.begin(episode.context.get_time(), states, lines)
        for item in self._adjustables:
            value = self._in_force[item.name]
            if not item.at_once and value != item.value:
                item.apply(episode, value)
        if self._clock is not None:
            self._clock.restart()
        self._start = episode.context.get_time(), time.monotonic()

    def frame(self, episode: Episode) -> bool:
        """Show a frame, bring sliders into force, say whether to stop."""
        if self._clock is not None:
            self._clock.wait()
        now, world = episode.context.get_time(), episode.world
        states = {name: episode.value(name, "state") for name in world.graph.objects}
        root = world.graph.root
        positions = episode.value(root, "plant_positions") if world.HasOutputPort("plant_positions") else None
        self.view.show(now, states, positions)
        for item in self._adjustables:
            self._adjust(item, episode)
        if time.monotonic() - self._told > _TELL:
            self._tell(now)
        return STOP.name in self.view.controls.pressed()

    def close(self) -> None:
        """Say on the page that it is over, and stop serving it."""
        self.view.page.show("ended", "ended; close this page")
        if self.view.page.watched:
            time.sleep(_FAREWELL)
        self.view.close()

    def _slider(self, item: Adjustable) -> float:
        return float(self.view.meshcat.GetSliderValue(item.name))

    def _adjust(self, item: Adjustable, episode: Episode) -> None:
        value = self._slider(item)
        if value == self._in_force[item.name]:
            return
        item.apply(episode, value)
        time_of_it = round(episode.context.get_time() / FRAME) * FRAME
        change = {"episode": self._episodes, "time": round(time_of_it, 6), "what": item.name, "value": round(value, 9)}
        self.changes.append(change)
        if item.at_once:
            value = float(self.view.meshcat.SetSliderValue(item.name, item.value))
        self._in_force[item.name] = value

    def _tell(self, now: float) -> None:
        self._told = time.monotonic()
        passed = self._told - self._start[1]
        speed = (now - self._start[0]) / passed if passed > 0 else 0.0
        values = {"time": f"{now:.1f} s", "speed": f"{speed:.1f} x real time"}
        values |= {item.name: f"{self._in_force[item.name]:g}" for item in self._adjustables if not item.at_once}
        behind = 0 if self._clock is None else self._clock.recently_late
        alarm = f"{behind} frames came late in the last 5 s" if behind else ""
        self.view.page.show("running", self._line, values, alarm)
