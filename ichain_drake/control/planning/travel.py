"""How the robot travels between far apart states: straight, in demonstrated steps, around what it would switch."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ichain_drake.control.planning.plan import States
from ichain_drake.control.settings import PLANNING
from ichain_drake.graph import Interaction
from ichain_drake.learning.model import InteractionModel
from ichain_drake.rules import enabled
from ichain_drake.state import FloatArray, StateSpace

_POINTS = 12  # a leg is judged at so many


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
    way = space.difference(goal, now)
    jumps = jumping(space)
    ratio = float(np.max(np.abs(way[~jumps]) / np.maximum(limit[~jumps], 1e-9), initial=0.0))
    if ratio <= 1.0 + 1e-9:
        return np.array(goal, dtype=float), True
    return np.where(jumps, now, now + way / np.ceil(ratio - 1e-6)), False


def jumping(space: StateSpace) -> np.ndarray:
    """Which variables can't change gradually, shape (n_variables,)."""
    return space.jump_mask


def corners(model: InteractionModel, states: States, goal: FloatArray, vias: Sequence[FloatArray]) -> list[FloatArray]:
    """States to pass on the way of the free robot to a goal, the goal last.

    The straight line, unless the classifiers say that it switches an interaction of the robot; then over the
    demonstrated state that makes the shortest way without.

    Args:
        model: the learned graph.
        states: now, shape (n_variables,) each.
        goal: robot state, shape (n_root,).
        vias: robot states in which nothing is switched, shape (n_root,) each.
    """
    if not enabled("corners"):
        return [goal]
    root = model.graph.root
    mine = [e for e in model.graph.interactions if e.parent == root]
    space = model.graph.objects[root].observable
    start = np.asarray(states[root], dtype=float)
    if not _switches(model, mine, states, [(start, goal)], (PLANNING.spared, PLANNING.spared))[0] or not vias:
        return [goal]
    jumps = jumping(space)
    limit = np.maximum(model.step_limit[root], 1e-9)
    stops = [np.where(jumps, start, v) for v in vias]

    def length(a: FloatArray, b: FloatArray) -> float:
        return float(np.max(np.abs(space.difference(b, a)[~jumps]) / limit[~jumps], initial=0.0))

    near = sorted(stops, key=lambda v: length(start, v) + length(v, goal))[: PLANNING.samples]
    first = _switches(model, mine, states, [(start, v) for v in near], (PLANNING.spared, 0.0))
    second = _switches(model, mine, states, [(v, goal) for v in near], (0.0, PLANNING.spared))
    for via, a, b in zip(near, first, second, strict=True):
        if not a and not b:
            return [via, goal]
    return [goal]


def resting_states(model: InteractionModel) -> list[FloatArray]:
    """Demonstrated states of the robot in which none of its interactions is active."""
    root = model.graph.root
    mine = [e for e in model.graph.interactions if e.parent == root]
    samples = {n: np.vstack([model.edges[e].examples.inactive[n] for e in mine]) for n in model.graph.objects}
    quiet = np.all([model.decide(e, samples) < 0 for e in mine], axis=0)
    rows = np.unique(samples[root][quiet], axis=0)
    if not len(rows):
        return []
    return [rows[k] for k in np.linspace(0, len(rows) - 1, min(len(rows), 200)).round().astype(int)]


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


def _switches(
    model: InteractionModel,
    edges: Sequence[Interaction],
    states: States,
    legs: Sequence[tuple[FloatArray, FloatArray]],
    spared: tuple[float, float],
) -> list[bool]:
    """Whether a straight leg leads through states in which an interaction is active."""
    root = model.graph.root
    space = model.graph.objects[root].observable
    share = np.linspace(spared[0], 1.0 - spared[1], _POINTS)[:, None]
    points = np.concatenate([a + share * space.difference(b, a) for a, b in legs])
    points = np.where(jumping(space), np.repeat([a for a, _ in legs], _POINTS, axis=0), points)
    batch = {n: np.repeat(np.asarray(v, dtype=float)[None], len(points), axis=0) for n, v in states.items()}
    batch[root] = points
    on = np.any([model.decide(e, batch) >= 0 for e in edges], axis=0).reshape(len(legs), _POINTS)
    return [bool(x) for x in on.any(axis=1)]
