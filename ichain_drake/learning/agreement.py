"""Whether what is known of an interaction holds in new demonstrations too, as far as they show it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ichain_drake.graph import Interaction
from ichain_drake.learning.data import GraphData
from ichain_drake.learning.known import KnownParts
from ichain_drake.learning.passive import PassiveDynamics
from ichain_drake.learning.settings import LEARNING
from ichain_drake.learning.status.scores import f1
from ichain_drake.learning.tick import LearnedInteraction, effects_of
from ichain_drake.state import FloatArray


def disagreements(data: GraphData, known: KnownParts) -> dict[Interaction, str]:
    """Known interactions that the pieces at hand contradict.

    Status: F1 over all rows. Effects: the child's change in ticks in which only known interactions act on it. Passive
    dynamics: its change while nothing acts on it; where they differ, so do all that is known of what acts on it.

    Args:
        data: pieces of the graph at hand.
        known: from before.

    Returns:
        What differs, in words, by interaction; what is shown in fewer than 12 rows is taken on trust.
    """
    found: dict[Interaction, str] = {}
    for obj, about in known.objects.items():
        if about.passive is not None and (what := _drifts(data, obj, about.passive, about.noise)):
            found |= {e: what for e in known.edges if e.child == obj}
    for edge, learned in known.edges.items():
        if edge not in found and (what := _differs(data, edge, learned, known)):
            found[edge] = what
    return found


def _drifts(data: GraphData, obj: str, passive: PassiveDynamics, noise: FloatArray) -> str:
    """In which variable an object that nothing acts on changes in another way than is known; empty if in none."""
    now, then = [], []
    for piece in data.pieces:
        quiet = ~np.any([piece.flags[e] for e in data.incoming(obj)], axis=0)
        rows = np.flatnonzero(quiet[:-1] & quiet[1:])
        now.append(piece.states[obj][rows])
        then.append(piece.states[obj][rows + 1])
    before, after = np.vstack(now), np.vstack(then)
    if len(before) < 2 * LEARNING.rows:
        return ""
    off = _rms(passive.space.difference(after, passive.settle(before, passive(before))))
    usual = np.maximum([v.std for v in passive.variables], np.sqrt(2.0) * noise)
    for i, variable in enumerate(passive.variables):
        if variable.kind != "change" and off[i] > LEARNING.clear * usual[i]:
            name = passive.space.names[i]
            return f"left alone, {obj}.{name} changes by {off[i]:.3g} a tick more than is known of it"
    return ""


def _differs(data: GraphData, edge: Interaction, learned: LearnedInteraction, known: KnownParts) -> str:
    truth = data.flag(edge)
    if truth.sum() < 2 * LEARNING.rows:
        return ""
    around = (edge.child, *data.graph.parents(edge.child))
    score = f1(truth, learned.status.decide({n: data.stacked(n) for n in around}) >= 0.0)
    if score < LEARNING.told:
        return f"its status is told with F1 {score:.2f} in the {int(truth.sum())} rows in which it is active here"
    return _other_effect(data, edge, learned, known)


def _other_effect(data: GraphData, edge: Interaction, learned: LearnedInteraction, known: KnownParts) -> str:
    child, about = edge.child, known.objects.get(edge.child)
    if about is None or about.passive is None:
        return ""
    passive, space = about.passive, data.spaces[child]
    incoming = data.incoming(child)
    rest, left = [], []
    for piece in data.pieces:
        on = {e: piece.flags[e] for e in incoming}
        good = on[edge][:-1] & on[edge][1:]
        for e in incoming:
            good = good & ((on[e][:-1] == on[e][1:]) if e in known.edges else ~on[e][:-1] & ~on[e][1:])
        rows = np.flatnonzero(good)
        state, then = piece.states[child][rows], piece.states[child][rows + 1]
        without = passive(state)
        for e in incoming:
            if e != edge and e in known.edges:
                without += on[e][rows + 1][:, None] * _effect(known.edges[e], piece.states[e.parent], rows, state)
        ahead = without + _effect(learned, piece.states[edge.parent], rows, state)
        # Within its bounds: what is empty gives no more, whatever acts on it.
        rest.append(space.difference(then, passive.settle(state, without)))
        left.append(space.difference(then, passive.settle(state, ahead)))
    if sum(map(len, rest)) < 2 * LEARNING.rows:
        return ""
    moved, off = _rms(np.vstack(rest)), _rms(np.vstack(left))
    for effect in learned.effects:
        i = effect.variable
        usual = max(effect.regression.std, np.sqrt(2.0) * float(about.noise[i]))
        if off[i] > LEARNING.clear * usual and off[i] > LEARNING.unexplained * moved[i]:
            return f"what it does to {child}.{space.names[i]} is off by {off[i]:.3g} of {moved[i]:.3g} a tick here"
    return ""


def _effect(learned: LearnedInteraction, parent: FloatArray, rows: NDArray[np.intp], child: FloatArray) -> FloatArray:
    return effects_of(learned, parent[rows], parent[rows + 1], child)


def _rms(rows: FloatArray) -> FloatArray:
    return np.asarray(np.sqrt(np.mean(rows**2, axis=0)))
