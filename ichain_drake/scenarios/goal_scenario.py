"""What running towards a goal asks of a scenario; `GraphScenario` offers it, and so may any class."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any, Protocol, runtime_checkable

from pydrake.systems.framework import Diagram

from ichain_drake.control.execution.course import RobotMotion
from ichain_drake.graph import InteractionGraph
from ichain_drake.robot import Physics
from ichain_drake.scenarios.base import Progress
from ichain_drake.scenarios.config import ScenarioConfig
from ichain_drake.visualization import Camera
from ichain_drake.world.world import World


class GoalScenario(Protocol):
    """What a scenario offers for a goal over its graph."""

    name: str
    physics: Physics
    seed: int
    config: ScenarioConfig
    graph: InteractionGraph

    def make_world(self, run: int) -> World: ...  # noqa: D102
    def record_demonstrations(self, progress: Progress | None = None, known: Collection[str] = ()) -> Any: ...  # noqa: D102
    def drawings(self) -> Mapping[str, Any]: ...  # noqa: D102
    def drawn_plant(self) -> Diagram | None: ...  # noqa: D102
    def view(self) -> Camera | None: ...  # noqa: D102
    def given(self) -> dict[str, Any]: ...  # noqa: D102


@runtime_checkable
class PlansMotion(Protocol):
    """A scenario whose robot can hit things: it says how to get around them."""

    def make_motion(self) -> RobotMotion | None: ...  # noqa: D102 - None: straight lines
