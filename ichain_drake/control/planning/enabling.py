"""Places of an object at which some interaction is possible: a weight on a button, a door out of the way.

Whether an interaction is active may depend on any parent of its child, and on what has still to be brought about. So it
is asked about in demonstrated states in which it was active, with the object put somewhere else: where it would be
active then, the object's place is no obstacle, whatever else is missing (regression through enabling conditions).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ichain_drake.control.planning.borders import active_samples
from ichain_drake.control.planning.carries import CarryOption
from ichain_drake.control.planning.frames import Frames
from ichain_drake.control.planning.model import Batch
from ichain_drake.control.planning.plan import States
from ichain_drake.control.settings import PLANNING
from ichain_drake.graph import Interaction
from ichain_drake.learning.model import InteractionModel
from ichain_drake.state import FloatArray


@dataclass(frozen=True, eq=False)
class Enabling:
    """Where an object makes an interaction possible.

    Attributes:
        carry: of the object.
        edge: the interaction.
        samples: demonstrated states in which it was active, shape (n, n_variables) each.
        place: values of the followed variables at which it is surest of all known places, shape (n_follow,).
        anchor: object that the place is relative to; None where it holds as it is.
    """

    carry: CarryOption
    edge: Interaction
    samples: Batch
    place: FloatArray
    anchor: str | None = None

    def missing(self, model: InteractionModel, frames: Frames, nodes: Sequence[States]) -> np.ndarray:
        """Whether the object's present place makes the interaction impossible, in each of several states."""
        obj, follow = self.carry.edge.child, self.carry.follow
        here = np.array([n[obj] for n in nodes])
        if self.anchor is not None:
            then = np.array([n[self.anchor] for n in nodes])
            here = frames.beside(obj, here, self.anchor, then, self._stands())
        on = _decide(model, self.edge, self.carry, self.samples, here[:, follow]) >= 0.0
        return np.asarray(on.mean(axis=1) <= 1.0 - PLANNING.likely)

    def place_in(self, frames: Frames, node: States) -> FloatArray:
        """`place` where the object is now that it is relative to, shape (n_follow,)."""
        if self.anchor is None:
            return self.place
        obj = self.carry.edge.child
        state = node[obj].copy()
        state[self.carry.follow] = self.place
        return frames.beside(obj, state, self.anchor, self._stands(), node[self.anchor])[self.carry.follow]

    def _stands(self) -> FloatArray:
        """Where the anchor is in the samples, shape (n_anchor,)."""
        assert self.anchor is not None
        return np.asarray(np.median(self.samples[self.anchor], axis=0))


def find_enabling(model: InteractionModel, carry: CarryOption) -> tuple[Enabling, ...]:
    """For each interaction that an object's place may matter to, where it is surest.

    Args:
        model: the learned graph.
        carry: of the object.
    """
    obj, out, frames = carry.edge.child, [], Frames(model)
    for edge in model.graph.interactions:
        if edge == carry.edge or obj not in (edge.child, *model.graph.parents(edge.child)):
            continue
        samples = active_samples(model, edge)
        if not len(samples[obj]):
            continue
        sure = _decide(model, edge, carry, samples, carry.places).max(axis=1)
        if sure.max() >= 0.0:
            place = carry.places[int(np.argmax(sure))]
            relative = obj in (edge.parent, edge.child) and frames.is_relative(edge)
            other = edge.child if obj == edge.parent else edge.parent
            # What can be brought to the object itself is not what it has to be brought to.
            anchor = other if relative and not frames.is_carried(other) else None
            out.append(Enabling(carry, edge, samples, place, anchor))
    return tuple(out)


def _decide(
    model: InteractionModel, edge: Interaction, carry: CarryOption, samples: Batch, places: FloatArray
) -> FloatArray:
    """Decision values in the samples with the object put at each place, shape (n_places, n_samples)."""
    obj, count = carry.edge.child, len(samples[carry.edge.child])
    batch = {n: np.tile(v, (len(places), 1)) for n, v in samples.items()}
    batch[obj][:, carry.follow] = np.repeat(places, count, axis=0)
    return model.decide(edge, batch).reshape(len(places), count)
