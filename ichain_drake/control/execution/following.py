"""Whether an object goes along with what moves it, seen in the last readings: a second witness beside the classifier.

A status classifier knows what was shown. An object that is held a little differently may look let go of to it, although
it goes wherever the robot goes. The learned effects say how far an object moves with its parent while their interaction
is active: where the parent has moved clearly, the readings show whether the object did.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ichain_drake.control.planning.model import is_change, keeps
from ichain_drake.control.settings import EXECUTION
from ichain_drake.graph import Interaction
from ichain_drake.learning.model import InteractionModel
from ichain_drake.learning.settings import LEARNING
from ichain_drake.rules import enabled
from ichain_drake.state import FloatArray, StateSpace


def goes_along(
    model: InteractionModel,
    edge: Interaction,
    readings: Sequence[Mapping[str, FloatArray]],
    ticks: int = 2 * LEARNING.ticks,
) -> bool | None:
    """Whether a child moved as its parent makes it move while their interaction is active.

    Compared is the pose alone: what else an interaction changes may have other causes.

    Args:
        model: the learned graph.
        edge: the interaction.
        readings: measured states of the last ticks, the newest last.
        ticks: how many of them to look back at most.

    Returns:
        None where nothing tells it: the parent hardly moved, the child moved in part, or no effect on its pose was
        learned.
    """
    if not enabled("goes_along"):
        return None
    expected, missing = _displacements(model, edge, readings, ticks)
    clear = np.flatnonzero(expected[EXECUTION.shortest - 1 :] >= LEARNING.plain)
    if not len(clear):
        return None
    n = EXECUTION.shortest - 1 + int(clear[0])
    if missing[n] <= LEARNING.unexplained * expected[n]:
        return True
    return False if missing[n] >= (1.0 - LEARNING.slight) * expected[n] else None


def strays(
    model: InteractionModel,
    edge: Interaction,
    readings: Sequence[Mapping[str, FloatArray]],
    ticks: int = 2 * LEARNING.ticks,
) -> bool:
    """Whether a child moved although its parent hardly did: it fell, or was knocked. Arguments as in `goes_along`."""
    expected, missing = _displacements(model, edge, readings, ticks)
    return bool(len(expected) and expected.max() < LEARNING.plain <= missing[-1])


def _displacements(
    model: InteractionModel, edge: Interaction, readings: Sequence[Mapping[str, FloatArray]], ticks: int
) -> tuple[FloatArray, FloatArray]:
    """How far the child should have moved in the last 1, 2, ... ticks, and how far it is from there, both in noises."""
    space = model.graph.objects[edge.child].observable
    index = sorted({f.variable for f in model.edges[edge].effects} & pose_of(space))
    last = list(readings)[-(min(ticks, 2 * LEARNING.ticks) + 2) :]
    count = min(ticks, 2 * LEARNING.ticks, len(last) - 1)
    if not index or count < EXECUTION.shortest:
        return np.zeros(0), np.zeros(0)
    parent, child = (np.array([r[n] for r in last]) for n in (edge.parent, edge.child))
    effect = model.effect(edge, {edge.parent: parent[:-1], edge.child: child[:-1]}, parent[1:])
    # Of a variable that has a value of its own, an effect says how far from it the child is: it moves by the change.
    held = keeps(model, edge.child) | is_change(model, edge.child)
    effect = np.where(held, effect, np.diff(effect, axis=0, prepend=effect[:1]))[-count:]
    child = child[-count - 1 :]
    noise = np.sqrt(2.0) * np.maximum(model.noise[edge.child], 1e-9)
    expected = (np.cumsum(effect[::-1], axis=0) / noise)[:, index]
    seen = (space.difference(child[-1], child[-2::-1]) / noise)[:, index]
    return np.linalg.norm(expected, axis=1), np.linalg.norm(seen - expected, axis=1)


def pose_of(space: StateSpace) -> set[int]:
    """Indices of the variables that say where an object is and how it is turned, by their roles."""
    kinds = ("position", "orientation")
    return {i for i, v in enumerate(space.variables) if v.role is not None and v.role.kind in kinds}
