"""The scene of a scenario in the browser while something runs in it."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray
from pydrake.geometry import Meshcat, MeshcatParams
from pydrake.systems.framework import Diagram

from ichain_drake.visualization.controls import Axis, Controls, PageButton
from ichain_drake.visualization.live_page import LivePage
from ichain_drake.visualization.plant_drawing import PlantDrawing
from ichain_drake.visualization.playback import Camera, quiet, set_stage
from ichain_drake.visualization.recording import RATE
from ichain_drake.visualization.scene import Drawing, EpisodeDrawing, Scene

FloatArray = NDArray[np.float64]

_TRAIL = 10  # samples between two pieces of a trail


@runtime_checkable
class TrailDrawing(Drawing, Protocol):
    """A drawing that shows where its object has been while it is still on its way."""

    def extend_trail(self, scene: Scene, states: FloatArray) -> None:
        """Add the last states, shape (n, n_variables), of which the first was the last of the call before."""


class LiveView:
    """A Meshcat with a scenario's scene, and the page that shows it.

    Only the thread that made it may call it. It draws at most 30 times a second, however fast the simulation runs.

    Args:
        title: of the page.
        drawings: how objects look, by name.
        plant: the arm: a finalized plant with its scene graph; None without one.
        axes, buttons: what a person may steer and press.
        instructions: lines above those of axes and buttons: [keys, text, gamepad].
        camera: view to start with.
    """

    def __init__(
        self,
        title: str,
        drawings: Mapping[str, Drawing],
        plant: Diagram | None = None,
        axes: Sequence[Axis] = (),
        buttons: Sequence[PageButton] = (),
        instructions: Sequence[Sequence[object]] = (),
        camera: Camera | None = None,
    ) -> None:
        with quiet():
            self.meshcat = Meshcat(MeshcatParams(host="127.0.0.1", show_stats_plot=False))
        self._drawings = dict(drawings)
        self._arm = PlantDrawing(plant) if plant is not None else None
        scene = Scene(self.meshcat, live=True)
        self._scenes = {name: scene.under(name) for name in [*drawings, "plant"]}
        set_stage(scene, camera if camera is not None else Camera())
        if self._arm is not None:
            self._arm.setup(self._scenes["plant"])
        for name, drawing in self._drawings.items():
            drawing.setup(self._scenes[name])
        self.controls = Controls(self.meshcat, axes, buttons)
        lines = [*instructions, *self.controls.instructions()]
        self.page = LivePage(self.meshcat, title, lines, self.controls.page_keys())
        self._shown = -1.0
        self._trails: dict[str, list[FloatArray]] = {}

    def begin(self, now: float, states: Mapping[str, FloatArray], lines: Mapping[str, FloatArray]) -> None:
        """An episode begins.

        Args:
            now: simulation time [s].
            states: true state of each object, shape (n_variables,).
            lines: commanded polylines, shape (m, 2), by object.
        """
        for name, drawing in self._drawings.items():
            if isinstance(drawing, EpisodeDrawing):
                drawing.begin_episode(
                    self._scenes[name], np.array([now]), np.asarray(states[name])[None], lines.get(name)
                )
        self._trails = {n: [] for n, d in self._drawings.items() if isinstance(d, TrailDrawing)}
        self._shown = -1.0
        self.show(now, states, None)

    def show(self, now: float, states: Mapping[str, FloatArray], plant_positions: FloatArray | None) -> None:
        """Bring the scene to a state, unless it was brought to another within the last 1/30 s of real time.

        Args:
            now: simulation time [s].
            states: true state of each object, shape (n_variables,).
            plant_positions: of the arm's plant; None leaves the arm where it is.
        """
        for name, trail in self._trails.items():
            trail.append(np.array(states[name], dtype=float))
            drawing = self._drawings[name]
            if len(trail) > _TRAIL and isinstance(drawing, TrailDrawing):
                drawing.extend_trail(self._scenes[name], np.array(trail))
                del trail[:-1]
        if time.monotonic() - self._shown < 0.7 / RATE:  # less than a period: a frame a little early is one to show
            return
        self._shown = time.monotonic()
        for name, drawing in self._drawings.items():
            drawing.update(self._scenes[name], now, states[name])
        fits = plant_positions is not None and self._arm is not None and len(plant_positions) == self._arm.num_positions
        if fits:
            self._arm.update(self._scenes["plant"], now, plant_positions)  # type: ignore[union-attr, arg-type]

    def close(self) -> None:
        """Stop serving the page."""
        self.page.close()
