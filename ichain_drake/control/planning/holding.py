"""Whether the robot can hold an object where it is, by the learned status of their interaction.

What holds depends on more than the two: a door may be in the way. So before an object is carried from one place to
another, the interaction is asked about at both, everything else being as predicted.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ichain_drake.control.planning.frames import Frames
from ichain_drake.control.planning.model import Batch
from ichain_drake.control.planning.motion import Motion
from ichain_drake.control.planning.plan import States
from ichain_drake.control.settings import PLANNING
from ichain_drake.graph import Interaction
from ichain_drake.learning.model import InteractionModel
from ichain_drake.rules import enabled
from ichain_drake.state import BoolArray, FloatArray


def can_hold(model: InteractionModel, edge: Interaction, states: Sequence[States]) -> BoolArray:
    """Whether some demonstrated grasp is likely to make an interaction active; arguments as of `hold_probability`."""
    return hold_probability(model, edge, states) >= PLANNING.likely


def hold_probability(model: InteractionModel, edge: Interaction, states: Sequence[States]) -> FloatArray:
    """Probability that the likeliest demonstrated grasp makes an interaction of the robot active.

    Args:
        model: the learned graph.
        edge: from the robot to the object.
        states: shape (n_variables,) each; where the robot is in them is no matter.

    Returns:
        For each of several states, shape (n_states,); 1 where the object's place is not known to go with the robot's.
    """
    batch = _grasps(model, edge, states)
    if batch is None:
        return np.ones(len(states))
    return np.asarray(model.probability(edge, batch).reshape(len(states), -1).max(axis=1))


def hold_margin(model: InteractionModel, edge: Interaction, states: States) -> float:
    """Largest decision value of a demonstrated grasp; 0 where nothing is known. Arguments as above, of one state."""
    batch = _grasps(model, edge, [states])
    return 0.0 if batch is None else float(model.decide(edge, batch).max())


def _grasps(model: InteractionModel, edge: Interaction, states: Sequence[States]) -> Batch | None:
    """Each state with the robot as in each demonstrated grasp, within its bounds; None where none is known."""
    frames, samples = Frames(model), model.edges[edge].examples.active
    rows = np.flatnonzero(model.decide(edge, samples) >= 0.0)
    if not states or not enabled("can_hold") or not frames.goes_with(edge) or not len(rows):
        return None  # nothing is known of a grasp elsewhere
    if len(rows) > PLANNING.samples:
        rows = rows[np.linspace(0, len(rows) - 1, PLANNING.samples).round().astype(int)]
    batch: Batch = {n: np.repeat(np.array([s[n] for s in states], dtype=float), len(rows), axis=0) for n in states[0]}
    taken, was = (np.tile(samples[n][rows], (len(states), 1)) for n in (edge.parent, edge.child))
    robot = frames.along(edge.parent, taken, edge.child, was, batch[edge.child])
    batch[edge.parent] = model.graph.objects[edge.parent].observable.clip(robot)
    return batch


def taken_as(model: InteractionModel, motion: Motion, node: int, child: FloatArray) -> FloatArray:
    """State of the robot, shape (n_root,), that takes an object as in a demonstrated state, from where the object is.

    Args:
        model: the learned graph.
        motion: names the demonstrated states.
        node: index of one.
        child: where the object is, shape (n_child,).
    """
    frames, edge = Frames(model), motion.edge
    if not frames.goes_with(edge):
        return motion.robot[node].copy()
    return frames.along(edge.parent, motion.robot[node], edge.child, motion.child[node], child)
