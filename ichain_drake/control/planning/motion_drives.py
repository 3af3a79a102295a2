"""Drives by motion, found in the learned models: chains whose last object changes only while the robot moves."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ichain_drake.control.planning.carries import CarryOption
from ichain_drake.control.planning.drive_option import DriveOption
from ichain_drake.control.planning.model import Batch, is_change, keeps, row, span, take
from ichain_drake.control.planning.motion_links import Links, best_motion, link, run_on, thinned
from ichain_drake.control.planning.options import chains
from ichain_drake.control.planning.travel import jumping, parked_state
from ichain_drake.control.settings import EXECUTION, PLANNING
from ichain_drake.graph import Interaction
from ichain_drake.learning.model import InteractionModel


def find_motion_drives(
    model: InteractionModel, carries: Sequence[CarryOption], drives: Sequence[DriveOption]
) -> tuple[DriveOption, ...]:
    """Drives by motion, of variables that no drive changes with the robot held still.

    A chain that goes on where a shorter one is driven needs none: what follows from the driven variable follows. What
    is carried needs none of its own but to be turned further than one grasp lets it be.

    Args:
        model: the learned graph.
        carries: objects that the robot can carry.
        drives: that hold the robot still.
    """
    still = {(d.chain[0], d.chain[-1].child, d.variable) for d in drives}
    follow = {(c.edge.child, int(i)) for c in carries for i in c.follow}
    found: list[DriveOption] = []
    nodes: dict[Interaction, Batch] = {}
    for chain in chains(model):
        target = chain[-1].child
        if any(d.chain == chain[: len(d.chain)] and len(d.chain) > 1 for d in found):
            continue
        usable = keeps(model, target) & ~is_change(model, target)
        usable &= np.array([any(f.variable == v for f in model.edges[chain[-1]].effects) for v in range(len(usable))])
        turned = len(chain) == 1 and any(obj == target for obj, _ in follow)
        usable &= np.array([((target, v) in follow) == turned for v in range(len(usable))])
        if turned:
            usable[model.graph.objects[target].observable.role_indices("position")] = False
        usable &= np.array([(chain[0], target, v) not in still for v in range(len(usable))])
        context = _context(model, chain, np.flatnonzero(usable))
        if context is None:
            continue
        if chain[0] not in nodes:
            nodes[chain[0]] = thinned(model, chain[0])
        links = _linked(model, chain[0], nodes[chain[0]], context)
        for v in np.flatnonzero(usable):
            for direction in (1, -1):
                found += _drive(model, chain, links, context, int(v), direction)
    return tuple(found)


def _linked(model: InteractionModel, edge: Interaction, nodes: Batch, context: Batch) -> Links:
    """Links between demonstrated states, all other objects as in one of them."""
    n = len(nodes[edge.child])
    states = {k: np.repeat(v[None], n, axis=0) for k, v in context.items()}
    states |= {k: nodes[k] for k in (edge.parent, edge.child)}
    return link(model, edge, states, parked_state(model, context))


def _drive(
    model: InteractionModel, chain: tuple[Interaction, ...], links: Links, context: Batch, variable: int, direction: int
) -> list[DriveOption]:
    target = chain[-1].child
    motion, gains = best_motion(model, links, target, variable, direction)
    ticks = 3 * PLANNING.retake  # several strokes, with a new grasp between them
    total = run_on(motion, gains, ticks)
    least = max(
        PLANNING.least * float(span(model, target)[variable]), PLANNING.noises * float(model.noise[target][variable])
    )
    if total.max(initial=0.0) < least or (len(chain) == 1 and not motion.again[motion.value > 0].any()):
        return []
    hold = {n: v.copy() for n, v in context.items()}
    best = int(np.argmax(total))
    hold |= {chain[0].parent: motion.robot[best].copy(), chain[0].child: motion.child[best].copy()}
    return [DriveOption(chain, variable, direction, float(total.max()) / ticks, None, hold, hold, motion)]


def _context(model: InteractionModel, chain: tuple[Interaction, ...], usable: np.ndarray) -> Batch | None:
    """A demonstrated state with a chain active in which pushes of the robot change a variable; None if there is none.

    Of all of them that in which the variable is nearest to the middle of its range, so that it can go either way.
    """
    samples = dict(model.edges[chain[0]].examples.active)
    rows = np.flatnonzero(np.all([model.decide(e, samples) >= 0.0 for e in chain], axis=0))
    if not len(rows) or not len(usable):
        return None
    rows = rows[np.linspace(0, len(rows) - 1, min(len(rows), PLANNING.samples)).round().astype(int)]
    states, root, target = take(samples, rows), model.graph.root, chain[-1].child
    still = model.step(states, states[root], strict=False)[0][target][:, usable]
    moved = np.zeros_like(still)
    for i in np.flatnonzero(~jumping(model.graph.objects[root].observable)):
        for sign in (1.0, -1.0):
            push = np.zeros(states[root].shape[1])
            push[i] = sign * PLANNING.push * model.step_limit[root][i]
            after = model.step(states, states[root] + push, strict=False)[0][target][:, usable]
            moved = np.maximum(moved, np.abs(after - still))
    clear = moved > np.maximum(PLANNING.noises * model.noise[target], EXECUTION.slack * span(model, target))[usable]
    if not clear.any():
        return None
    middle = 0.5 * (model.low[target] + model.high[target])[usable]
    away = (np.abs(states[target][:, usable] - middle) / span(model, target)[usable]).max(axis=1)
    return row(states, int(np.argmin(np.where(clear.any(axis=1), away, np.inf))))
