"""Whether the robot can hold an object where it is, by the learned status of their interaction.

What holds depends on more than the two: a door may be in the way. So before an object is carried from one place to
another, the interaction is asked about at both, everything else being as predicted.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ichain_drake.control.graph.model import Batch, BoolArray, GraphModel
from ichain_drake.control.graph.plan import States
from ichain_drake.graph import Interaction
from ichain_drake.state import FloatArray

_GRASPS = 40  # demonstrated ways of holding that are tried


def can_hold(model: GraphModel, edge: Interaction, states: Sequence[States]) -> BoolArray:
    """Whether some demonstrated grasp makes an interaction of the robot active, in each of several states.

    Args:
        model: the learned graph.
        edge: from the robot to the object.
        states: shape (n_variables,) each; where the robot is in them is no matter.

    Returns:
        shape (n_states,).
    """
    if not states:
        return np.zeros(0, dtype=bool)
    samples = model.edges[edge].examples.active
    rows = np.flatnonzero(model.decide(edge, samples) >= 0.0)
    if not len(rows):
        return np.ones(len(states), dtype=bool)  # nothing is known
    if len(rows) > _GRASPS:
        rows = rows[np.linspace(0, len(rows) - 1, _GRASPS).round().astype(int)]
    count = len(rows)
    batch: Batch = {n: np.repeat(np.array([s[n] for s in states], dtype=float), count, axis=0) for n in states[0]}
    root = np.tile(samples[edge.parent][rows], (len(states), 1))
    batch[edge.parent] = _beside(model, edge, root, np.tile(samples[edge.child][rows], (len(states), 1)), batch)
    return np.asarray((model.decide(edge, batch).reshape(len(states), count) >= 0.0).any(axis=1))


def _beside(model: GraphModel, edge: Interaction, root: FloatArray, child: FloatArray, batch: Batch) -> FloatArray:
    """Demonstrated robot states, shape (n, n_root), moved along with the object to where it is now."""
    alignment: Any = model.edges[edge].alignment
    if alignment is None:
        return root
    out, index = root.copy(), list(alignment.child.indices)
    out[:, list(alignment.parent.indices)] += (batch[edge.child][:, index] - child[:, index]) @ alignment.turn
    return out
