"""Places of an object that let some other interaction happen: a door has to be open before food can be taken out.

Whether an interaction is active may depend on any parent of its child. Demonstrated states in which it was active are
therefore looked at with the object put where it is now: where that alone switches the interaction off, the object's
demonstrated place is worth going to, whatever else is still missing.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ichain_drake.control.planning.macros import Carry
from ichain_drake.control.planning.model import GraphModel, span, take
from ichain_drake.control.planning.plan import States
from ichain_drake.graph import Interaction
from ichain_drake.rules import enabled
from ichain_drake.state import FloatArray

_SAMPLES = 60
_MOST = 0.5  # of the samples that the object's present place must switch off


def enabling_places(model: GraphModel, carry: Carry, nodes: Sequence[States]) -> list[list[FloatArray]]:
    """Places that make interactions possible which the present place forbids.

    Args:
        model: the learned graph.
        carry: what is carried.
        nodes: states, shape (n_variables,) each.

    Returns:
        Values of the followed variables, shape (n_follow,) each, for each state.
    """
    obj = carry.edge.child
    out: list[list[FloatArray]] = [[] for _ in nodes]
    if not enabled("enabling_places"):
        return out
    for edge in model.graph.interactions:
        # Of its two ends `carry_targets` takes care.
        if obj in (edge.parent, edge.child) or obj not in model.graph.parents(edge.child):
            continue
        samples, sure = _surest(model, edge)
        if not len(sure):
            continue
        best = _let_go(model, carry, samples[obj][int(np.argmax(sure))][carry.follow])
        for places, node in zip(out, nodes, strict=True):
            moved = {n: v.copy() for n, v in samples.items()}
            moved[obj][:, carry.follow] = node[obj][carry.follow]
            if np.mean(model.decide(edge, moved) < 0.0) > _MOST:
                places.append(best)
    return out


def _let_go(model: GraphModel, carry: Carry, pose: FloatArray) -> FloatArray:
    """The place nearest to a pose at which the object was let go of in demonstrations."""
    width = span(model, carry.edge.child)[carry.follow]
    return carry.places[int(np.argmin((np.abs(carry.places - pose) / width).sum(axis=1)))]


def _surest(model: GraphModel, edge: Interaction) -> tuple[dict[str, FloatArray], FloatArray]:
    """Demonstrated states in which an interaction was active, by the classifier, and its decision values."""
    samples = dict(model.edges[edge].examples.active)
    sure = model.decide(edge, samples)
    rows = np.flatnonzero(sure >= 0.0)
    if len(rows) > _SAMPLES:
        rows = rows[np.linspace(0, len(rows) - 1, _SAMPLES).round().astype(int)]
    return take(samples, rows), sure[rows]
