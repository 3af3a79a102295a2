"""Motions that keep driving a variable: what changes only while the robot moves (a crank, a ratchet, a pump).

Demonstrated states in which the robot moves an object are linked where the learned models say that one tick leads from
one to the other, and where the robot may let go at one and take the object again at another. On these links value
iteration finds the way of moving that changes the variable fastest on and on: round and round, to and fro, a stroke at
a time. So a motion never leaves what was shown, needs no shape of a path, and is the same for any object.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ichain_drake.control.planning.model import Batch, keeps, take
from ichain_drake.control.planning.motion import Motion
from ichain_drake.control.planning.travel import jumping
from ichain_drake.control.settings import PLANNING
from ichain_drake.graph import Interaction
from ichain_drake.learning.model import InteractionModel
from ichain_drake.learning.settings import LEARNING
from ichain_drake.state import BoolArray, FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class Links:
    """Which demonstrated states of an object that the robot moves lead to which.

    Attributes:
        edge: from the robot.
        states: of all objects, shape (n, n_variables) each.
        start, end: indices of states that a tick links, shape (n_links,).
        change: of every object in that tick, shape (n_links, n_variables) each.
        retake: whether the object can be let go of in one state and taken in another, shape (n, n).
        reach: see `Motion`.
    """

    edge: Interaction
    states: Batch
    start: IntArray
    end: IntArray
    change: Batch
    retake: BoolArray
    reach: tuple[FloatArray, FloatArray]


def thinned(model: InteractionModel, edge: Interaction) -> Batch:
    """Demonstrated states of an interaction of the robot, none of which is much like another."""
    samples = dict(model.edges[edge].examples.active)
    samples = take(samples, np.flatnonzero(model.decide(edge, samples) >= 0.0))
    n = len(samples[edge.parent])
    if not n:
        return samples
    ends = [(edge.parent, _reach(model, edge.parent)), (edge.child, _reach(model, edge.child))]
    kept, away = [0], np.full(n, np.inf)
    while len(kept) < min(n, PLANNING.nodes):
        off = [
            np.abs(model.graph.objects[name].observable.difference(samples[name], samples[name][kept[-1]])) / reach
            for name, reach in ends
        ]
        away = np.minimum(away, np.hstack(off).max(axis=1))
        if away.max() < PLANNING.alike:
            break
        kept.append(int(np.argmax(away)))
    return take(samples, np.sort(kept))


def link(model: InteractionModel, edge: Interaction, states: Batch, parked: FloatArray) -> Links:
    """Link states by what the models say of a tick from each to each other that is near enough.

    Args:
        model: the learned graph.
        edge: from the robot to the object.
        states: shape (n, n_variables) each.
        parked: state of the robot in which it acts on nothing, shape (n_root,).
    """
    root, child = states[edge.parent], states[edge.child]
    n, space = len(root), model.graph.objects[edge.child].observable
    reach = _reach(model, edge.parent), _reach(model, edge.child)
    off = np.abs(model.graph.objects[edge.parent].observable.difference(root[None], root[:, None]))
    start, end = np.nonzero(((off / reach[0]).max(axis=2) <= 1.0) & ~np.eye(n, dtype=bool))
    after, on = model.step(take(states, start), root[end], strict=False)
    slack = _slack(model, edge.child, reach[1])
    meets = np.abs(space.difference(after[edge.child], child[end])) <= slack
    good = np.asarray(on[edge]) & meets.all(axis=1)
    start, end, after = start[good], end[good], take(after, np.flatnonzero(good))
    change = {k: model.graph.objects[k].observable.difference(after[k], states[k][start]) for k in states}
    free, _ = model.step(states, np.repeat(parked[None], n, axis=0), strict=False)
    free, _ = model.step(free, np.repeat(parked[None], n, axis=0), strict=False)
    same = np.abs(space.difference(free[edge.child][:, None], child[None])) <= slack
    return Links(edge, states, start, end, change, same.all(axis=2) & ~np.eye(n, dtype=bool), reach)


def best_motion(
    model: InteractionModel, links: Links, obj: str, variable: int, direction: int
) -> tuple[Motion, FloatArray]:
    """The fastest way of changing a variable, and the change in each state's next tick, shape (n,).

    Args:
        model: the learned graph.
        links: of demonstrated states.
        obj, variable: what is driven.
        direction: +1 or -1.
    """
    n = len(links.states[obj])
    gain = np.full((n, n), -np.inf)
    gain[links.start, links.end] = direction * links.change[obj][:, variable]
    gain[np.diag_indices(n)] = 0.0
    later = np.where(links.retake, PLANNING.discount**PLANNING.retake, 0.0)
    value = np.zeros(n)
    for _ in range(PLANNING.steps):
        value = np.maximum((gain + PLANNING.discount * value).max(axis=1), (later * value).max(axis=1))
    moving, taking = gain + PLANNING.discount * value, later * value
    again = taking.max(axis=1) > moving.max(axis=1) + 1e-12
    onward = np.where(again, taking.argmax(axis=1), moving.argmax(axis=1))
    gains = np.where(again, 0.0, gain[np.arange(n), onward])
    space = model.graph.objects[links.edge.child].observable
    motion = Motion(
        links.edge, links.states[links.edge.parent], links.states[links.edge.child], onward, again, value,
        links.reach, space.angle_mask,
    )  # fmt: skip
    return motion, gains


def run_on(motion: Motion, gains: FloatArray, ticks: int) -> FloatArray:
    """Change of the driven variable over some ticks from each state on, shape (n,).

    Args:
        motion: to be followed.
        gains: in each state's next tick, shape (n,).
        ticks: how many; taking an object anew takes `PlanningSettings.retake`.
    """
    n = len(gains)
    at, total, passed = np.arange(n), np.zeros(n), np.zeros(n)
    for _ in range(ticks):
        going = passed < ticks
        total += np.where(going, gains[at], 0.0)
        passed += np.where(motion.again[at], PLANNING.retake, 1)
        at = motion.onward[at]
    return total


def _reach(model: InteractionModel, obj: str) -> FloatArray:
    """How far a variable goes in a tick at most; infinite for those that tell no states apart, shape (n_variables,)."""
    space = model.graph.objects[obj].observable
    reach = np.maximum(model.step_limit[obj], LEARNING.surely * model.noise[obj])
    told = ~jumping(space) & (reach > 0)
    if obj in model.passive:
        told &= keeps(model, obj) | np.array([v.kind == "constant" for v in model.passive[obj].variables])
    return np.where(told, np.maximum(reach, 1e-9), np.inf)


def _slack(model: InteractionModel, obj: str, reach: FloatArray) -> FloatArray:
    return np.where(np.isfinite(reach), np.maximum(PLANNING.meets * reach, LEARNING.surely * model.noise[obj]), np.inf)
