"""How an object moves with the robot, to first order: the learned effect's slope, and the least motion for a change."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ichain_drake.control.planning.model import row
from ichain_drake.control.planning.plan import States
from ichain_drake.control.planning.travel import jumping
from ichain_drake.control.settings import PLANNING
from ichain_drake.graph import Interaction
from ichain_drake.learning.model import InteractionModel
from ichain_drake.learning.settings import LEARNING
from ichain_drake.state import FloatArray

_CORRECTIONS = 4  # Newton's, and halvings of a way that is not straight


def slope(model: InteractionModel, edge: Interaction, states: States) -> tuple[FloatArray, FloatArray]:
    """What pushes of the robot do to the child of one of its interactions.

    Motions that were never shown while the interaction was active are small pushes: the model can't know much about
    them, and the interaction may not last.

    Args:
        model: the learned graph.
        edge: from the robot.
        states: shape (n_variables,) each.

    Returns:
        The push in each of the robot's variables, 0 where it can't change gradually, shape (n_root,); and what each
        push changes, shape (n_root, n_child).
    """
    shown = np.where(model.edges[edge].active_step > 0, 1.0, LEARNING.near)
    size = np.maximum(shown * model.step_limit[edge.parent], 1e-9)
    size[jumping(model.graph.objects[edge.parent].observable)] = 0.0
    n = len(size)
    probes = np.asarray(states[edge.parent], dtype=float) + np.vstack([np.diag(size), np.zeros(n)])
    batch = {k: np.repeat(np.asarray(states[k], dtype=float)[None], n + 1, axis=0) for k in (edge.parent, edge.child)}
    effect = model.effect(edge, batch, probes)
    return size, effect[:-1] - effect[-1]


def led(
    model: InteractionModel, edge: Interaction, states: States, wanted: FloatArray, tolerance: FloatArray
) -> tuple[FloatArray, bool]:
    """Where the robot has to be for its child to have changed, or to have come as far as a straight way leads.

    The least motion by the model's slope is corrected by what the model says of it. A child that is turned moves aside
    on a straight way of the robot: where what should stay would leave its place on the way, part of the way is gone.

    Args:
        model: the learned graph.
        edge: from the robot.
        states: shape (n_variables,) each.
        wanted: changes of the child's variables, shape (n_child,); NaN where any will do.
        tolerance: by which what should stay may move, shape (n_child,).

    Returns:
        State of the robot, shape (n_root,), and whether it is that of the whole change.
    """
    asked = np.flatnonzero(np.isfinite(wanted))
    change, slack = wanted[asked], tolerance[asked]
    stays = np.abs(change) <= slack
    root = np.asarray(states[edge.parent], dtype=float)
    goal = root
    for part in (0.5**k for k in range(_CORRECTIONS)):
        goal = _solved(model, edge, states, asked, part * change)
        halfway = model.effect(edge, states, 0.5 * (root + goal))[asked] - model.effect(edge, states, root)[asked]
        if (np.abs(halfway - 0.5 * part * change)[stays] <= slack[stays]).all():
            return goal, part == 1.0
    return goal, False


def _solved(
    model: InteractionModel, edge: Interaction, states: States, asked: NDArray[np.intp], change: FloatArray
) -> FloatArray:
    """State of the robot that changes some variables of the child, by Newton's method, as long as that comes nearer."""
    root, child = (np.asarray(states[n], dtype=float) for n in (edge.parent, edge.child))
    still = model.effect(edge, states, root)
    goal, moved = root, np.zeros_like(child)
    for _ in range(_CORRECTIONS):
        size, by_push = slope(model, edge, {edge.parent: goal, edge.child: child + moved})
        further = goal + least_motion(by_push[:, asked], change - moved[asked]) * size
        after = model.effect(edge, states, further) - still
        if goal is not root and np.linalg.norm(change - after[asked]) >= np.linalg.norm(change - moved[asked]):
            break
        goal, moved = further, after
    return goal


def least_motion(by_push: FloatArray, wanted: FloatArray) -> FloatArray:
    """The smallest combination of pushes that makes a change, shape (n_root,).

    Args:
        by_push: what each push changes, shape (n_root, n_wanted).
        wanted: the change, shape (n_wanted,).
    """
    return np.asarray(np.linalg.lstsq(by_push.T, wanted, rcond=PLANNING.same)[0])


def independent(model: InteractionModel, edge: Interaction, variables: Sequence[int]) -> bool:
    """Whether the robot can change each of some variables of a child without the others, where it was shown to.

    Args:
        model: the learned graph.
        edge: from the robot.
        variables: indices of the child's.
    """
    samples = model.edges[edge].examples.active
    if not len(samples[edge.child]):
        return True
    by_push = slope(model, edge, row(samples, len(samples[edge.child]) // 2))[1][:, list(variables)]
    size = np.linalg.svd(by_push / np.maximum(np.abs(by_push).max(axis=0), 1e-12), compute_uv=False)
    return bool((size > PLANNING.same * size[0]).sum() == len(variables))
