"""How an object moves with the robot, to first order: the learned effect's slope, and the least motion for a change."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ichain_drake.control.planning.model import GraphModel, row
from ichain_drake.control.planning.plan import States
from ichain_drake.control.planning.travel import jumping
from ichain_drake.graph import Interaction
from ichain_drake.state import FloatArray

_UNSHOWN = 0.05  # size of a motion that was not shown, as a share of that of others
_DEPENDENT = 0.02  # of the largest singular value: smaller ones are noise


def slope(model: GraphModel, edge: Interaction, states: States) -> tuple[FloatArray, FloatArray]:
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
    shown = np.where(model.edges[edge].active_step > 0, 1.0, _UNSHOWN)
    size = np.maximum(shown * model.step_limit[edge.parent], 1e-9)
    size[jumping(model.graph.objects[edge.parent].observable)] = 0.0
    n = len(size)
    probes = np.asarray(states[edge.parent], dtype=float) + np.vstack([np.diag(size), np.zeros(n)])
    batch = {k: np.repeat(np.asarray(states[k], dtype=float)[None], n + 1, axis=0) for k in (edge.parent, edge.child)}
    effect = model.effect(edge, batch, probes)
    return size, effect[:-1] - effect[-1]


def least_motion(by_push: FloatArray, wanted: FloatArray) -> FloatArray:
    """The smallest combination of pushes that makes a change, shape (n_root,).

    Args:
        by_push: what each push changes, shape (n_root, n_wanted).
        wanted: the change, shape (n_wanted,).
    """
    return np.asarray(np.linalg.lstsq(by_push.T, wanted, rcond=_DEPENDENT)[0])


def independent(model: GraphModel, edge: Interaction, variables: Sequence[int]) -> bool:
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
    return bool((size > _DEPENDENT * size[0]).sum() == len(variables))
