"""From unordered demonstration pieces with active flags to an `InteractionModel`."""

from __future__ import annotations

import time
from collections.abc import Sequence

import numpy as np
from threadpoolctl import threadpool_limits

from ichain_drake.demonstrations import Demonstration
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning.interaction.alignment import learn_alignment
from ichain_drake.learning.interaction.customary import learn_customary
from ichain_drake.learning.interaction.data import GraphData, collect
from ichain_drake.learning.interaction.effects import MOVING, Effect, learn_effects
from ichain_drake.learning.interaction.events import collect_examples
from ichain_drake.learning.interaction.model import InteractionModel
from ichain_drake.learning.interaction.noise import measurement_std
from ichain_drake.learning.interaction.passive import learn_passive
from ichain_drake.learning.interaction.spec import InteractionSpec
from ichain_drake.learning.interaction.status import learn_status
from ichain_drake.learning.interaction.tick import LearnedInteraction
from ichain_drake.state import FloatArray


def learn_interactions(
    pieces: Sequence[Demonstration], graph: InteractionGraph, spec: InteractionSpec | None = None
) -> InteractionModel:
    """Learn everything about a graph (paper sec. V, VI).

    Args:
        pieces: unordered demonstrations; each holds all objects and a flag column per interaction.
        graph: objects with kinds and roles, and the interactions.
        spec: candidate estimators.

    Raises:
        InputError: on data that can't be learned from, in one line that names piece, edge and remedy.
    """
    # One BLAS thread: the same models in every bit for any number of processors, and faster on arrays this small.
    with threadpool_limits(limits=1, user_api="blas"):
        return _learn(pieces, graph, spec or InteractionSpec())


def _learn(pieces: Sequence[Demonstration], graph: InteractionGraph, spec: InteractionSpec) -> InteractionModel:
    started = time.perf_counter()
    data = collect(pieces, graph)
    noise = {n: measurement_std(data, n) for n in data.spaces}
    children = [n for n in graph.objects if n != graph.root]
    alignments = {e: learn_alignment(data, e, noise) for e in data.edges}
    passive = {n: learn_passive(data, n, spec, noise) for n in children}
    effects: dict[Interaction, tuple[Effect, ...]] = {}
    for child in children:
        effects |= learn_effects(data, child, passive[child], alignments, spec, noise)
    edges = {}
    for e in graph.interactions:
        seen = data.stacked(e.parent)[data.flag(e)]
        status = learn_status(data, e, alignments, spec, noise, {f.variable for f in effects[e]})
        edges[e] = LearnedInteraction(
            status,
            learn_customary(data, e, alignments, status, noise),
            effects[e],
            alignments[e],
            collect_examples(data, e),
            seen.min(axis=0),
            seen.max(axis=0),
            _active_step(data, e, noise[e.parent]),
        )
    return InteractionModel(
        graph=graph,
        edges=edges,
        passive=passive,
        low={n: data.stacked(n).min(axis=0) for n in data.spaces},
        high={n: data.stacked(n).max(axis=0) for n in data.spaces},
        step_limit={n: _step_limit(data, n) for n in data.spaces},
        order=data.edges,
        noise=noise,
        pieces=tuple(p.name for p in pieces),
        wall_seconds=time.perf_counter() - started,
    )


def _active_step(data: GraphData, edge: Interaction, noise: FloatArray) -> FloatArray:
    """Largest change of the parent in a tick while an interaction is active, shape (n_parent,); 0 where it is noise."""
    space = data.spaces[edge.parent]
    steps = [
        space.difference(s[1:], s[:-1])[f[1:] & f[:-1]]
        for s, f in ((p.states[edge.parent], p.flags[edge]) for p in data.pieces)
    ]
    changes = np.abs(np.vstack(steps))
    if not len(changes):
        return np.zeros(len(space))
    moves = np.sqrt(np.mean(changes**2, axis=0)) >= MOVING * np.sqrt(2.0) * noise
    return np.where(moves, changes.max(axis=0), 0.0)


def _step_limit(data: GraphData, obj: str) -> FloatArray:
    """Largest change of each variable in a tick, shape (n_variables,); angles the short way round."""
    space = data.spaces[obj]
    steps = [np.abs(space.difference(p.states[obj][1:], p.states[obj][:-1])).max(axis=0) for p in data.pieces]
    return np.max(steps, axis=0)
