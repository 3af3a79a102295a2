"""Objects that the robot can carry, found in the learned models, with the places where they were let go or stood."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ichain_drake.control.planning.frames import Frames
from ichain_drake.control.planning.model import Batch, keeps, span, take
from ichain_drake.control.settings import PLANNING
from ichain_drake.graph import Interaction
from ichain_drake.learning.model import InteractionModel
from ichain_drake.learning.settings import LEARNING
from ichain_drake.state import FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class CarryOption:
    """An object that follows the robot through an interaction.

    Attributes:
        edge: from the robot.
        follow: indices of the object's variables that follow the robot and stay where they are let go.
        places: values of these variables where the object was let go in demonstrations, shape (n_places, n_follow).
        let_go: all states then, shape (n_places, n_variables) each.
        stood: values of these variables where it was seen to stand in this execution, shape (n_follow,) each.
    """

    edge: Interaction
    follow: IntArray
    places: FloatArray
    let_go: Batch = field(default_factory=dict)
    stood: tuple[FloatArray, ...] = ()

    @property
    def steady(self) -> FloatArray:
        """All of these places, shape (n, n_follow)."""
        return np.vstack([self.places, *self.stood])


def find_carries(model: InteractionModel) -> tuple[CarryOption, ...]:
    """Objects that the robot can carry, in the graph's order."""
    found, frames = [], Frames(model)
    for edge in model.graph.interactions:
        if edge.parent != model.graph.root:
            continue
        follow = _followers(model, edge)
        let_go = model.edges[edge].examples.deactivations.after
        if len(follow) and len(let_go[edge.child]):
            stood = [let_go, *_stood(model, frames, edge)]
            let_go = {n: np.concatenate([s[n] for s in stood]) for n in let_go}
            places, rows = np.unique(let_go[edge.child][:, follow], axis=0, return_index=True)
            found.append(CarryOption(edge, follow, places, take(let_go, rows)))
    return tuple(found)


def _stood(model: InteractionModel, frames: Frames, carry: Interaction) -> list[Batch]:
    """For each interaction of an object, states in the middle of where it stood while that was active.

    The few places where it was let go of may all be near the border, or none of them within: in some demonstrations it
    stood there from the beginning. Readings of many rows say where the middle is. Where they are of several places, the
    middle may be none.
    """
    out, obj = [], carry.child
    holds = [e for e in model.graph.interactions if e.child == obj and model.graph.by_robot(e)]
    for e in model.graph.interactions:
        if obj not in (e.parent, e.child) or model.graph.by_robot(e):
            continue
        samples = dict(model.edges[e].examples.active)
        free = np.all([model.decide(h, samples) < 0.0 for h in holds], axis=0)
        rows = np.flatnonzero(free & (model.decide(e, samples) >= 0.0))
        if not len(rows):
            continue
        samples = take(samples, rows)
        middle = {n: np.median(v, axis=0) for n, v in samples.items()}
        if frames.is_relative(e):
            other = e.child if obj == e.parent else e.parent
            middle[obj] = np.median(frames.along(obj, samples[obj], other, samples[other], middle[other]), axis=0)
        if float(model.decide(e, middle)) >= 0.0:
            out.append({n: v[None] for n, v in middle.items()})
    return out


def _followers(model: InteractionModel, edge: Interaction) -> IntArray:
    """Variables that change with the robot's motion there and back, not at rest, and keep their value when let go."""
    samples = model.edges[edge].examples.active
    root, child = samples[edge.parent], samples[edge.child]
    if not len(root):
        return np.zeros(0, dtype=np.intp)
    pair = {edge.parent: root, edge.child: child}
    held = model.effect(edge, pair, root)
    still = np.sqrt(np.mean(held**2, axis=0))
    moved, one_way = np.zeros_like(still), np.zeros_like(still)
    for i, limit in enumerate(model.step_limit[edge.parent]):
        push = np.zeros(root.shape[1])
        push[i] = PLANNING.push * limit
        there, back = (model.effect(edge, pair, root + sign * push) for sign in (1.0, -1.0))
        largest = [np.sqrt(np.mean(e**2, axis=0)) for e in (there, back)]
        moved = np.maximum(moved, np.max(largest, axis=0))
        one_way = np.maximum(one_way, 0.5 * np.sqrt(np.mean((there + back - 2.0 * held) ** 2, axis=0)))
    floor = np.maximum(model.noise[edge.child], 1e-9 * span(model, edge.child))
    # What is spilled where it is tilted does not come back: it doesn't follow.
    follows = (still < LEARNING.slight * moved) & (one_way < LEARNING.slight * moved)
    return np.flatnonzero(keeps(model, edge.child) & (moved > floor) & follows)
