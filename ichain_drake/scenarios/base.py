"""What a scenario is: a configuration, a world, demonstrations to record, and a goal."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from pydrake.systems.framework import Diagram

from ichain_drake.control.tracking.levels import PredictiveWeights
from ichain_drake.control.tracking.path import PathLimits, TimedPath
from ichain_drake.demonstrations.table import Demonstration
from ichain_drake.errors import InputError
from ichain_drake.graph import InteractionGraph
from ichain_drake.robot import ROBOT_PHYSICS, Physics, models_path
from ichain_drake.scenarios.adjustable import Adjustable, noise_scale, path_shift, push
from ichain_drake.scenarios.command_chart import CommandChart
from ichain_drake.scenarios.config import ScenarioConfig, as_plain, load_config
from ichain_drake.scenarios.given import declared
from ichain_drake.scenarios.seats import Seat, place_seat
from ichain_drake.settings import check_settings
from ichain_drake.state import FloatArray, StateSpace
from ichain_drake.visualization import Camera
from ichain_drake.world.world import World

Progress = Callable[[str], None]
_PACKAGE = __name__.partition(".")[0]
CAMERA, READING_NOISE = "camera", "reading noise"
"""A camera that may be turned; a vehicle that declares noise of its readings (`reading_std`)."""


class Scenario(ABC):
    """Base class of scenarios.

    Args:
        overrides: `--set` settings, one or several.
        physics: `ideal`, `arm` or `contact`.
        seed: seed of the run.

    Raises:
        InputError: on a bad setting, an unsupported physics or fault, or a negative seed.
    """

    name: ClassVar[str]
    config_class: ClassVar[type[ScenarioConfig]] = ScenarioConfig
    config_file: ClassVar[Path | None] = None
    """YAML of a scenario that is no part of this package; without one, its settings are the defaults of its class."""

    physics_kinds: ClassVar[tuple[Physics, ...]] = ROBOT_PHYSICS
    """Physics that it can run in."""

    faults: ClassVar[tuple[str, ...]] = ("none",)
    features: ClassVar[tuple[str, ...]] = ()
    """What it has of `CAMERA` and `READING_NOISE`; settings of what it hasn't are refused."""

    config: ScenarioConfig
    graph: InteractionGraph

    def __init__(self, overrides: str | Sequence[str] = (), physics: Physics = "contact", seed: int = 0) -> None:
        if physics not in self.physics_kinds:
            *others, last = self.physics_kinds
            choice = f"{', '.join(others)} or {last}" if others else last
            raise InputError(f"physics {physics!r}: choose {choice}")
        if seed < 0:
            raise InputError(f"seed {seed}: give a whole number from 0")
        self.physics = physics
        self.seed = seed
        self.config = load_config(self.config_class, self.config_path(), overrides)
        check_settings(self.config, getattr(self, "unit", "unit"))
        self.check_config()
        self.graph = self.make_graph()
        self.config.control.candidates()  # what is wrong with these is said now, not after minutes of work
        edges = {e.name for e in self.graph.interactions}
        for name in self.config.learning.candidates():
            if name not in edges:
                raise InputError(f"learning.links: {name} is no interaction of {self.name}; it has {', '.join(edges)}")

    @classmethod
    def config_path(cls) -> Path | None:
        """The YAML file of its configuration; None where the defaults of `config_class` are all there is."""
        if cls.config_file is not None:
            return cls.config_file
        # A scenario from elsewhere that builds on one of ours has its file.
        ours = [c for c in cls.__mro__ if "name" in vars(c) and c.__module__.startswith(f"{_PACKAGE}.")]
        return models_path() / "scenarios" / f"{vars(ours[0])['name']}.yaml" if ours else None

    def check_config(self) -> None:
        """Refuse settings that can't be, before anything is made of them; an override calls this one too.

        Raises:
            InputError: naming the setting.
        """
        if self.config.fault.kind not in self.faults:
            raise InputError(f"{self.name} has no fault {self.config.fault.kind!r}; it has {', '.join(self.faults)}")
        if self.config.camera.yaw_deg != 0.0 and CAMERA not in self.features:
            raise InputError(f"{self.name} has no camera: leave camera.yaw_deg at 0")
        if self.config.noise.vehicle != 0.0 and READING_NOISE not in self.features:
            raise InputError(f"{self.name} has no vehicle that declares noise of readings: leave noise.vehicle at 0")

    @abstractmethod
    def make_graph(self) -> InteractionGraph:
        """The interaction graph, from the configuration."""

    @abstractmethod
    def record_demonstrations(
        self, progress: Progress | None = None, known: Collection[str] = ()
    ) -> Iterator[Demonstration]:
        """Record the scripted demonstrations in this scenario's physics, piece by piece.

        Args:
            progress: called with a line before each piece.
            known: names of interactions that need no demonstration.

        Raises:
            RecordingInterrupted: on Ctrl-C, with what was recorded of the piece.
        """

    @abstractmethod
    def drawings(self) -> Mapping[str, Any]:
        """How objects look in a playback, by name (see `visualization.Drawing`)."""

    def start_world(self, path: str | TimedPath = "", run: int = 0) -> World:
        """A world whose default context is the start of a run; see `build_world`.

        Args:
            path: that the last object starts on, or its name, where there are paths.
            run: number of the run.

        Raises:
            InputError: if it has neither paths nor a goal, or not this path.
        """
        raise InputError(f"{self.name} has neither paths nor a goal; build its world from its graph and objects")

    def drawn_plant(self) -> Diagram | None:
        """A diagram with the plant whose positions are logged; None where there is none."""
        return None

    def view(self) -> Camera | None:
        """Where a playback is seen from at first; None for the usual place."""
        return None

    def seats(self) -> Mapping[str, Seat]:
        """What a person can drive in the browser, by name, the usual one first."""
        return {}

    def adjustables(self) -> Sequence[Adjustable]:
        """What a person may change while it runs live."""
        return (noise_scale(self.config.noise.scale),)

    def shown(self) -> Mapping[str, StateSpace]:
        """What of each object's state a playback's read-out lists; everything unless overridden."""
        return dict(self.graph.objects)

    def given(self) -> dict[str, Any]:
        """What the scenario declares instead of learning, for the report: its configuration and its graph."""
        return {**as_plain(self.config), "graph": declared(self.graph)}


class PathScenario(Scenario):
    """A scenario whose goal is that the last object of a chain follows a path in the plane."""

    target: ClassVar[str]
    """Object that follows."""

    target_variables: ClassVar[tuple[str, str]] = ("x", "y")
    """Its two position variables."""

    unit: ClassVar[str] = "px"
    y_down: ClassVar[bool] = True
    """Whether y points down in pictures of the plane, as on a screen."""

    size: ClassVar[tuple[float, float]] = (800.0, 600.0)
    """Extent of the plane, from (0, 0)."""

    target_length: ClassVar[float | None] = None
    """Length of the object that follows, in the unit; errors are then reported in lengths too."""

    no_oracle: ClassVar[str] = ""
    """Why predictive control with the true model can't be run for comparison; empty where it can."""

    oracle_weights: ClassVar[PredictiveWeights] = PredictiveWeights(effort=0.02)
    """What the oracle weighs, chosen on seeds that no report uses; `benchmarks/oracle_search.py` looks for better."""

    @abstractmethod
    def reference_paths(self) -> Mapping[str, FloatArray]:
        """The paths that `run` and `evaluate` follow, shape (n, 2) each."""

    @abstractmethod
    def path_limits(self) -> PathLimits:
        """How paths are followed."""

    @abstractmethod
    def make_world(self, path: TimedPath, run: int) -> World:
        """A world for one run; its default context is the start.

        Args:
            path: the path that the last object starts on.
            run: number of the run; keys its noise.
        """

    def timed_path(self, name: str) -> TimedPath:
        """A reference path as it is followed.

        Raises:
            InputError: if there is none of that name.
        """
        paths = self.reference_paths()
        if name not in paths:
            raise InputError(f"{self.name} has no path {name!r}; it has {', '.join(paths)}")
        return TimedPath(paths[name], self.path_limits())

    def start_world(self, path: str | TimedPath = "", run: int = 0) -> World:
        """On a path, the first of the reference paths by default."""
        if isinstance(path, str):
            path = self.timed_path(path or next(iter(self.reference_paths())))
        return self.make_world(path, run)

    @abstractmethod
    def monolithic_demonstration(self, count: int) -> Demonstration:
        """Transitions of the robot's hand and the target alone, for a model that knows nothing in between."""

    @abstractmethod
    def command_range(self) -> tuple[FloatArray, FloatArray]:
        """Lowest and highest hand command that makes sense here, for the oracle, shape (n_hand,) each.

        Where not every hand command in a box makes sense: of the coordinates of `command_chart`, shape (k,) each.
        """

    def command_chart(self) -> CommandChart | None:
        """Coordinates of the hand commands that make sense; None where all within `command_range` do."""
        return None

    def view(self) -> Camera | None:
        """Where a playback is seen from at first; None for the usual place."""
        return None

    def seats(self) -> Mapping[str, Seat]:
        """The hand, within the commands that make sense; the world is that of the first reference path."""
        path = TimedPath(next(iter(self.reference_paths().values())), self.path_limits())
        chart = self.command_chart()
        command_at = np.asarray if chart is None else chart.to_hand
        seat = place_seat(self, lambda run: self.make_world(path, run), *self.command_range(), command_at)
        return {seat.name: seat}

    def adjustables(self) -> Sequence[Adjustable]:
        """Noise, pushes of the object that follows, and the path's place."""
        reach = self.path_limits().speed
        pushes = [push(self.target, v, self.unit, reach) for v in self.target_variables]
        shifts = [path_shift(i, v, self.unit, reach) for i, v in enumerate(self.target_variables)]
        return (*super().adjustables(), *pushes, *shifts)

    def target_indices(self) -> tuple[int, ...]:
        """Indices of the target variables in the last object's observable state."""
        return tuple(int(i) for i in self.graph.objects[self.target].observable.indices(self.target_variables))
