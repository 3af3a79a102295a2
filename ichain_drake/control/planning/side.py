"""What one of the robots can do, as a search sees it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ichain_drake.control.planning.frames import Frames
from ichain_drake.control.planning.repertoire import Repertoire
from ichain_drake.control.planning.travel import parked_state
from ichain_drake.graph import Interaction
from ichain_drake.learning.model import InteractionModel
from ichain_drake.state import FloatArray


class Side:
    """What one of the robots can do, the others staying as they are.

    Args:
        model: the learned graph as this robot sees it (`InteractionModel.acting`).
        options: what it can do.
        start: states, shape (n_variables,) each.
        touching: interactions of robots that are active at the start.
    """

    def __init__(
        self,
        model: InteractionModel,
        options: Repertoire,
        start: Mapping[str, FloatArray],
        touching: Sequence[Interaction] = (),
    ) -> None:
        self.model, self.options, self.robot = model, options, model.graph.root
        self.frames = Frames(model)
        self.touching = tuple(e for e in touching if e.parent == self.robot)
        self.parked = parked_state(model, start) if self.touching else start[self.robot]
        self.holds = options.holds
