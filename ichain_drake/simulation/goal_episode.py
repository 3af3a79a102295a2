"""One episode towards a goal over an interaction graph."""

from __future__ import annotations

from ichain_drake.control.execution.controller import GraphController
from ichain_drake.control.execution.executor import Memory
from ichain_drake.simulation.episode import Episode
from ichain_drake.state import FloatArray
from ichain_drake.world.world import World

_PORTS = ("mode", "edge", "skill", "plan_step")


class GraphEpisode(Episode):
    """An episode under a `GraphController`.

    Args:
        world: the world.
        controller: closes the loop.
    """

    def __init__(self, world: World, controller: GraphController) -> None:
        self.controller = controller
        super().__init__(world, controller)

    @property
    def memory(self) -> Memory:
        """What the controller remembers now."""
        return self.controller.memory(self.controller.GetMyContextFromRoot(self.context))

    def doing(self) -> dict[str, FloatArray]:
        """Logged ports of the controller, shape (n,) each."""
        extra = self.log().extra
        return {p: extra[p][:, 0].copy() for p in _PORTS}
