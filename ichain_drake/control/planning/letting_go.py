"""Where a carried object stays when it is let go of, as far as demonstrations tell, and how to end with it in hand.

A predicted object keeps its place when the robot leaves. In the air it would fall, and half turned it would swing back:
nobody let go of it there, though it often was there, and that is what tells. What is wanted there is held.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.stats import norm

from ichain_drake.control.planning.carries import CarryOption
from ichain_drake.control.planning.frames import Frames
from ichain_drake.control.planning.goals import gap
from ichain_drake.control.planning.model import Batch, span
from ichain_drake.control.planning.plan import Condition, States
from ichain_drake.learning.model import InteractionModel
from ichain_drake.learning.settings import LEARNING
from ichain_drake.state import FloatArray


def stays(model: InteractionModel, carry: CarryOption, place: FloatArray) -> bool:
    """Whether an object may be expected to stay where it is let go of.

    It may not if some variable is beyond all values at which it was let go of, and it was there so often that by chance
    it would have been let go of there, too: the share p of the rows in which it was held makes (1 - p)^n the
    probability that none of the n places where it was let go of, or stood, was.

    Args:
        model: the learned graph.
        carry: what is carried.
        place: values of the followed variables, shape (n_follow,).
    """
    held = _held(model, carry)[carry.edge.child][:, carry.follow]
    places = carry.steady
    if not len(held) or not len(places):
        return True
    slack = LEARNING.surely * model.noise[carry.edge.child][carry.follow]
    low, high = places.min(axis=0) - slack, places.max(axis=0) + slack
    there = np.where(
        place > high, np.mean(held > high, axis=0), np.where(place < low, np.mean(held < low, axis=0), 0.0)
    )
    by_chance = (1.0 - there) ** len(places)
    return bool((by_chance >= norm.sf(LEARNING.sure)).all())


def in_hand(
    model: InteractionModel, carry: CarryOption, states: States, conditions: Sequence[Condition]
) -> tuple[FloatArray, FloatArray] | None:
    """A pose that conditions ask for, held as in a demonstration: the nearest one, and the robot's state there.

    Args:
        model: the learned graph.
        carry: what is carried.
        states: now, shape (n_variables,) each.
        conditions: of the goal; those on other variables are passed over.

    Returns:
        Values of the followed variables, shape (n_follow,), and of the robot, shape (n_root,); None where it was never
        held.
    """
    obj, root, held = carry.edge.child, carry.edge.parent, _held(model, carry)
    if not len(held[obj]):
        return None
    space, width = model.graph.objects[obj].observable, span(model, obj)
    mine = [(space.index(c.variable), c) for c in conditions if c.object == obj]
    mine = [(k, c) for k, c in mine if k in carry.follow]
    far = (np.abs(space.difference(held[obj], states[obj])) / width)[:, carry.follow].sum(axis=1)
    short = np.sum([gap(c, held[obj][:, k]) / width[k] for k, c in mine], axis=0) if mine else np.zeros(len(far))
    row = int(np.lexsort((far, short))[0])
    pose = np.array(held[obj][row] if mine else states[obj], dtype=float)  # without a wish: where it is
    for k, c in mine:
        pose[k] = np.clip(pose[k], c.lower, c.upper)
    frames = Frames(model)
    robot = held[root][row]
    if frames.goes_with(carry.edge):
        robot = frames.along(root, robot, obj, held[obj][row], pose)
    return pose[carry.follow], robot


def _held(model: InteractionModel, carry: CarryOption) -> Batch:
    """Demonstrated states in which an object was held, by the classifier."""
    samples = dict(model.edges[carry.edge].examples.active)
    rows = np.flatnonzero(model.decide(carry.edge, samples) >= 0.0)
    return {n: v[rows] for n, v in samples.items()}
