"""The limit: predictive control that plans with the true model of the world and reads the true states."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ichain_drake.control.tracking.levels import PredictiveLevel, PredictiveWeights
from ichain_drake.control.tracking.tick_model import LinearizedModel
from ichain_drake.graph import InteractionGraph
from ichain_drake.objects.base import WorldObject
from ichain_drake.robot.motion import LINEAR_SPEED, MOVE_FRAMES
from ichain_drake.scenarios.command_chart import CommandChart
from ichain_drake.state import FloatArray, StateSpace
from ichain_drake.timing import FRAME, FRAMES_PER_TICK
from ichain_drake.world.reference import WorldReference

_STEP = 1e-5


def straight_frames(hand: FloatArray, command: FloatArray) -> FloatArray:
    """Hand states at the ends of a tick's frames, (frames, ..., n): straight to the command in the first four.

    Longer where the speed limit asks for it; positions only. An arm's hand by contact is off by 0.05 mm at a tick's end
    and by 0.36 mm in its first frame, of 17 mm (root mean square; car game, seed 100): it is no worse a limit there.
    """
    distance = np.linalg.norm(command - hand, axis=-1)
    frames = np.maximum(MOVE_FRAMES, np.ceil(distance / (LINEAR_SPEED * FRAME) - 1e-9))
    k = np.arange(1, FRAMES_PER_TICK + 1).reshape(-1, *([1] * distance.ndim))
    part = np.minimum(1.0, k / frames)[..., None]
    return hand + part * (command - hand)


@dataclass(frozen=True)
class TrueTickModel(LinearizedModel):
    """The noise-free world as a one-tick model from the hand to all other objects' states, joined.

    Attributes:
        reference: the world in plain numpy.
        names: objects, robot first, in the order their states are joined.
        sizes: length of each state.
        chart: of the hand, where the parent's states are given in its coordinates.
    """

    reference: WorldReference
    names: tuple[str, ...]
    sizes: tuple[int, ...]
    chart: CommandChart | None = None

    def predict(self, child: FloatArray, parent: FloatArray, parent_next: FloatArray) -> FloatArray:
        """Joined states one tick later, shape (n, n_joined)."""
        ends = np.cumsum(self.sizes[1:])[:-1]
        if self.chart is not None:
            parent, parent_next = self.chart.to_hand(parent), self.chart.to_hand(parent_next)
        states = dict(zip(self.names, [parent, *np.split(child, ends, axis=-1)], strict=True))
        after = self.reference.tick(states, parent_next)
        return np.concatenate([after[n] for n in self.names[1:]], axis=-1)

    def linearize(
        self, child: FloatArray, parent: FloatArray, parent_next: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """As `ForwardModel.linearize`, by forward differences in one batch."""
        n, a, b = len(child), child.shape[1], parent.shape[1]
        base = np.concatenate([child, parent, parent_next], axis=1)
        moved = base[None] + _STEP * np.concatenate([np.zeros((1, a + 2 * b)), np.eye(a + 2 * b)])[:, None]
        flat = moved.reshape(-1, a + 2 * b)
        after = self.predict(flat[:, :a], flat[:, a : a + b], flat[:, a + b :]).reshape(-1, n, a)
        slope = np.moveaxis((after[1:] - after[0]) / _STEP, 0, -1)
        return after[0], slope[..., :a], slope[..., a : a + b], slope[..., a + b :]


class OraclePolicy:
    """Takes the place of `MoveTo`: one predictive level over the whole true world, straight to the hand command.

    Args:
        graph: the interaction graph.
        objects: the world's objects.
        target: the followed object.
        targets: indices of its target variables in its full state.
        target_scale: usual step of the target in one tick.
        lower, upper: range of hand commands, shape (n_hand,), or of their coordinates, shape (k,).
        weights: of the predictive level.
        chart: of the hand commands that make sense; None where all in the range do.
    """

    def __init__(
        self,
        graph: InteractionGraph,
        objects: Mapping[str, WorldObject],
        target: str,
        targets: Sequence[int],
        target_scale: float,
        lower: FloatArray,
        upper: FloatArray,
        weights: PredictiveWeights,
        chart: CommandChart | None = None,
    ) -> None:
        names = graph.chain(target)
        sizes = tuple(len(graph.objects[n]) for n in names)
        self.sizes = sizes
        self._chart = chart
        frames = straight_frames if chart is None else chart.frames
        offset = sum(sizes[1:-1])
        joined = StateSpace(
            "world",
            tuple(
                type(v)(f"{n}_{v.name}", v.unit, v.lower, v.upper, v.kind)
                for n in names[1:]
                for v in graph.objects[n].variables
            ),
        )
        self._level = PredictiveLevel(
            TrueTickModel(WorldReference(graph, objects, frames), names, sizes, chart),
            joined,
            tuple(offset + i for i in targets),
            np.full(len(targets), target_scale),
            lower,
            upper,
            (upper - lower) / 4,
            weights,
        )
        self.memory_size = self._level.memory_size
        self.lookahead = self._level.lookahead

    def decide(
        self, states: Sequence[FloatArray], wanted: FloatArray, memory: FloatArray
    ) -> tuple[FloatArray, FloatArray, list[FloatArray]]:
        """As `MoveTo.decide`, from full states."""
        joined = np.concatenate(list(states[1:]), axis=-1)
        place = states[0] if self._chart is None else self._chart.from_hand(states[0])
        plan, memory = self._level.decide(joined, place, wanted, memory)
        command = plan[:, 0] if self._chart is None else self._chart.within_tick(states[0], plan[:, 0])
        handed = [command, *(np.zeros((1, k)) for k in self.sizes[1:-1])]
        return command, memory, handed
