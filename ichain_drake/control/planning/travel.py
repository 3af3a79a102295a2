"""How the robot travels between far apart states: straight, in demonstrated steps; and where it is out of the way."""

from __future__ import annotations

import numpy as np

from ichain_drake.control.planning.plan import States
from ichain_drake.learning.model import InteractionModel
from ichain_drake.state import FloatArray, StateSpace


def step_towards(space: StateSpace, now: FloatArray, goal: FloatArray, limit: FloatArray) -> tuple[FloatArray, bool]:
    """One tick along the straight line to a state; what can't change gradually changes on arrival.

    Args:
        space: of the robot.
        now: last command, shape (n_root,).
        goal: shape (n_root,).
        limit: largest change in a tick, shape (n_root,).

    Returns:
        The next command, and whether it is the goal.
    """
    goal = space.clip(goal)
    way = space.difference(goal, now)
    jumps = jumping(space)
    ratio = float(np.max(np.abs(way[~jumps]) / np.maximum(limit[~jumps], 1e-9), initial=0.0))
    if ratio <= 1.0 + 1e-9:
        return np.array(goal, dtype=float), True
    return np.where(jumps, now, now + way / np.ceil(ratio - 1e-6)), False


def jumping(space: StateSpace) -> np.ndarray:
    """Which variables can't change gradually, shape (n_variables,)."""
    return space.jump_mask


def parked_state(model: InteractionModel, states: States) -> FloatArray:
    """A demonstrated state of the robot in which it acts on nothing, as surely as possible, shape (n_root,).

    Args:
        model: the learned graph.
        states: of the other objects, shape (n_variables,) each.
    """
    root = model.graph.root
    mine = [e for e in model.graph.interactions if e.parent == root]
    rows = np.concatenate([model.edges[e].examples.deactivations.after[root] for e in mine])
    batch = {n: np.repeat(np.asarray(v, dtype=float)[None], len(rows), axis=0) for n, v in states.items()}
    batch[root] = rows
    surest = np.max([model.decide(e, batch) for e in mine], axis=0)
    return rows[int(np.argmin(surest))]
