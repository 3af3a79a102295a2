"""Where a carried object may be brought: places at which it was let go, chosen by what they do to interactions."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import networkx as nx
import numpy as np

from ichain_drake.control.planning.carries import CarryOption
from ichain_drake.control.planning.enabling import Enabling
from ichain_drake.control.planning.frames import Frames
from ichain_drake.control.planning.goals import gap, kept_by_itself, value_of
from ichain_drake.control.planning.letting_go import stays
from ichain_drake.control.planning.model import Batch, row, span
from ichain_drake.control.planning.plan import Condition, States
from ichain_drake.control.planning.slope import least_motion, slope
from ichain_drake.control.settings import PLANNING
from ichain_drake.graph import Interaction
from ichain_drake.learning.model import InteractionModel
from ichain_drake.rules import enabled
from ichain_drake.state import FloatArray


def carry_targets(
    model: InteractionModel,
    carry: CarryOption,
    nodes: Sequence[States],
    start: States,
    conditions: Sequence[Condition],
    enabling: Sequence[Enabling] = (),
    doubted: Sequence[Collection[Interaction]] = (),
) -> list[list[FloatArray]]:
    """Poses worth carrying an object to, for each of several states.

    They are: what the goal wants of it, if it stays there (see `stays`), where it was at the start and was seen to
    stand before, for each other interaction of the object the place of a demonstration that makes it active most
    surely, the nearest place at which none is, and places at which an interaction would be possible that is not, or did
    not do what was predicted, where the object is now (see `Enabling`). Where the object acts on a variable of the goal
    that keeps no value of its own, also poses in even steps between its outermost places.

    Args:
        model: the learned graph.
        carry: what is carried.
        nodes: states, shape (n_variables,) each.
        start: states at the start of planning.
        conditions: of the goal.
        enabling: where the object makes interactions possible.
        doubted: interactions that did not do what was predicted, for each state; none without.

    Returns:
        Values of the followed variables, shape (n_follow,) each, for each state.
    """
    if not nodes:
        return []
    obj = carry.edge.child
    others = [e for e in model.graph.interactions if obj in (e.parent, e.child) and e != carry.edge]
    frames = Frames(model)
    known = _known_places(frames, carry, nodes)
    n = known.shape[1]
    batch: Batch = {k: np.repeat(np.array([s[k] for s in nodes]), n, axis=0) for k in nodes[0]}
    batch[obj][:, carry.follow] = known.reshape(-1, known.shape[2])
    margins = np.array([model.decide(e, batch).reshape(len(nodes), n) for e in others]).reshape(-1, len(nodes), n)
    shown = frames.is_shown(obj, batch[obj]).reshape(len(nodes), n)
    wanted = wanted_place(model, carry, start, conditions)
    if wanted is not None and not stays(model, carry, wanted):
        wanted = None
    back = [start[obj][carry.follow]]
    if float(model.decide(carry.edge, start)) >= 0 and not stays(model, carry, back[0]):
        back = []  # it is in hand there
    width = span(model, obj)[carry.follow]
    out, missing = (
        [],
        [e.missing(model, frames, nodes) | [e.edge in d for d in doubted or [()] * len(nodes)] for e in enabling],
    )
    for k, (node, places) in enumerate(zip(nodes, known, strict=True)):
        here = node[obj][carry.follow]
        asked, found = [] if wanted is None else [wanted], []
        for margin in margins[:, k]:
            if margin.max(initial=-1.0) >= 0:
                likely = np.where(shown[k] | ~(shown[k] & (margin >= 0)).any(), margin, -np.inf)
                found.append(places[int(np.argmax(likely))])
        if enabled("along_a_line") and _acts_on_goal(model, obj, node, conditions):
            found += list(_along(carry.places, width))
        free = np.flatnonzero((margins[:, k] < 0).all(axis=0))
        if len(free):
            away = np.abs((places[free] - here) / width).sum(axis=1)
            found.append(places[free[int(np.argmin(away))]])
        found += [e.place_in(frames, node) for e, needed in zip(enabling, missing, strict=True) if needed[k]]
        if found:
            there = np.repeat(node[obj][None], len(found), axis=0)
            there[:, carry.follow] = found
            found = [place for place, ok in zip(found, frames.in_reach(obj, there), strict=True) if ok]
        out.append(_distinct([*asked, *back, *carry.stood, *found], here, width))
    return out


def _known_places(frames: Frames, carry: CarryOption, nodes: Sequence[States]) -> FloatArray:
    """Where the object was let go, and the same relative to each object that this may be relative to, as it is now.

    Returns:
        Values of the followed variables, shape (n_nodes, n_places, n_follow).
    """
    obj = carry.edge.child
    out = [np.repeat(carry.places[None], len(nodes), axis=0)]
    for anchor in frames.anchors(obj) if carry.let_go else ():
        now = np.array([s[anchor] for s in nodes])[:, None]
        out.append(frames.beside(obj, carry.let_go[obj], anchor, carry.let_go[anchor], now)[..., carry.follow])
    return np.concatenate(out, axis=1)


def _acts_on_goal(model: InteractionModel, obj: str, node: States, conditions: Sequence[Condition]) -> bool:
    """Whether an object acts, directly or through others, on a variable that must be held by what acts on it."""
    below = nx.descendants(model.graph.digraph, obj)
    unmet = (c for c in conditions if c.object in below and gap(c, value_of(c, node, model.graph)) > 0)
    return any(not kept_by_itself(model, c) for c in unmet)


def _along(places: FloatArray, width: FloatArray) -> FloatArray:
    """Poses along the widest direction of known places, shape (n, n_follow)."""
    middle = places.mean(axis=0)
    direction = np.linalg.svd((places - middle) / width)[2][0]
    along = ((places - middle) / width) @ direction
    return middle + np.linspace(along.min(), along.max(), PLANNING.line)[:, None] * direction * width


def _distinct(found: Sequence[FloatArray], here: FloatArray, width: FloatArray) -> list[FloatArray]:
    kept: list[FloatArray] = []
    for place in found:
        if all(np.max(np.abs(place - other) / width) > PLANNING.same for other in (here, *kept)):
            kept.append(place)
    return kept


def wanted_place(
    model: InteractionModel, carry: CarryOption, start: States, conditions: Sequence[Condition]
) -> FloatArray | None:
    """The pose that the goal wants: given values where there are any, the others as at the nearest known place.

    Args:
        model: the learned graph.
        carry: what is carried.
        start: states at the start of planning.
        conditions: of the goal.

    Returns:
        Values of the followed variables, shape (n_follow,); None where the goal wants none of them.
    """
    obj = carry.edge.child
    names = [model.graph.objects[obj].observable.names[i] for i in carry.follow]
    mine = {c.variable: c for c in conditions if c.object == obj and c.variable in names}
    if not mine:
        return None
    width = span(model, obj)[carry.follow]
    known = np.vstack([start[obj][carry.follow][None], carry.steady])
    away = np.zeros(len(known))
    for k, name in enumerate(names):
        if name in mine:
            away += gap(mine[name], known[:, k]) / width[k]
    pose = known[int(np.argmin(away))].copy()
    change, asked = np.zeros(len(pose)), np.array([name in mine for name in names])
    for k, name in enumerate(names):
        if name in mine:
            c = mine[name]
            middle = 0.5 * (c.lower + c.upper)
            change[k] = (middle if np.isfinite(middle) else np.clip(pose[k], c.lower, c.upper)) - pose[k]
    rest = _goes_along(model, carry, pose, np.where(asked, change, np.nan))
    return pose + np.where(asked, change, np.where(np.abs(rest) > PLANNING.same * width, rest, 0.0))


def _goes_along(model: InteractionModel, carry: CarryOption, pose: FloatArray, change: FloatArray) -> FloatArray:
    """What changes of a pose where some of it is changed, since one motion does both: a drawer's place and its opening.

    Args:
        model: the learned graph.
        carry: what is carried.
        pose: values of the followed variables, shape (n_follow,).
        change: wanted, NaN where nothing is asked, shape (n_follow,).
    """
    samples = model.edges[carry.edge].examples.active
    near = np.abs(samples[carry.edge.child][:, carry.follow] - pose) / span(model, carry.edge.child)[carry.follow]
    states = row(samples, int(np.argmin(near.sum(axis=1))))
    by_push = slope(model, carry.edge, states)[1][:, carry.follow]
    asked = np.isfinite(change)
    return np.asarray(by_push.T @ least_motion(by_push[:, asked], change[asked]))
