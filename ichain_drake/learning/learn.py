"""From unordered demonstration pieces with active flags to an `InteractionModel`."""

from __future__ import annotations

import time
from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from ichain_drake.demonstrations import Demonstration, data_hash
from ichain_drake.errors import InputError
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning.agreement import disagreements
from ichain_drake.learning.blas import one_blas_thread
from ichain_drake.learning.checks import check_pieces
from ichain_drake.learning.data import GraphData, collect
from ichain_drake.learning.discovery.labels import label_pieces
from ichain_drake.learning.effects.alignment import learn_alignment
from ichain_drake.learning.effects.effects import learn_effects
from ichain_drake.learning.enough import enough, thinning_told
from ichain_drake.learning.estimators.warned import collected_warnings
from ichain_drake.learning.findings import findings_in
from ichain_drake.learning.known import KnownObject, KnownParts, joined_examples, typical_row
from ichain_drake.learning.model import InteractionModel
from ichain_drake.learning.noise import measurement_std
from ichain_drake.learning.passive import PassiveDynamics, learn_passive
from ichain_drake.learning.settings import LEARNING
from ichain_drake.learning.spec import InteractionSpec
from ichain_drake.learning.status.customary import learn_customary
from ichain_drake.learning.status.events import collect_examples, collect_windows
from ichain_drake.learning.status.status import learn_status
from ichain_drake.learning.tick import LearnedInteraction
from ichain_drake.state import FloatArray
from ichain_drake.timing import TICK


def learn_interactions(
    pieces: Iterable[Demonstration],
    graph: InteractionGraph,
    spec: InteractionSpec | None = None,
    known: KnownParts | None = None,
    *,
    unlabelled: bool = False,
) -> InteractionModel:
    """Learn everything about a graph (paper sec. V, VI), or what is not known yet.

    Args:
        pieces: unordered demonstrations; each holds all objects and a flag column per interaction. What is known need
            not be shown in any; where nothing is left to be learned there may be none.
        graph: objects with kinds and roles, and the interactions.
        spec: candidate estimators.
        known: what is taken as it is (paper sec. IV, its end: one link is swapped, the others stay).
        unlabelled: whether flags may be missing or NaN, and are inferred (see `label_pieces`); interactions that
            nothing shows are left out of the model's graph.

    Of more rows than `LEARNING.most_learned` stretches are learned from, and a finding says so; see `enough`.

    Raises:
        InputError: on data that can't be learned from, in one line that names piece, edge and remedy.
    """
    # One BLAS thread: the same models in every bit for any number of processors, and faster on arrays this small.
    pieces = list(pieces)
    with one_blas_thread(), collected_warnings():
        known = known or KnownParts()
        given, pieces = pieces, enough(pieces, graph)
        if unlabelled:
            check_pieces(pieces, graph, unlabelled=True)
            labels = label_pieces(pieces, graph)
            pieces, graph = list(labels.pieces), labels.graph
        if not pieces and known.is_whole(graph):
            model = _assembled(graph, known)
        else:
            model = _learn(pieces, graph, spec or InteractionSpec(), known)
        shown = collect_windows(pieces, graph)
        before = (known.activations, known.deactivations)
        on, off = ({e: (*w, *was.get(e, ())) for e, w in part.items()} for part, was in zip(shown, before, strict=True))
        return replace(
            model,
            activations=on,
            deactivations=off,
            robot_seconds=sum((len(p) - 1) * TICK for p in given),
            demonstrations_sha256=data_hash(pieces),
            findings=(*thinning_told(given, pieces), *model.findings),
            known=known,
        )


def contradicted(pieces: Sequence[Demonstration], graph: InteractionGraph, known: KnownParts) -> dict[Interaction, str]:
    """Known interactions that demonstrations contradict, with what differs in words; see `disagreements`.

    Raises:
        InputError: on pieces that can't be read as the graph's.
    """
    return disagreements(collect(enough(pieces, graph), graph, known.edges), known) if pieces else {}


def _assembled(graph: InteractionGraph, known: KnownParts) -> InteractionModel:
    """A model of known parts alone."""
    about = {n: known.objects[n] for n in graph.objects}
    typical = {n: o.typical for n, o in about.items()}
    return InteractionModel(
        graph=graph,
        edges={
            e: replace(
                known.edges[e], examples=joined_examples(known.edges[e].examples, None, typical, elsewhere=False)
            )
            for e in graph.interactions
        },
        passive={n: o.passive for n, o in about.items() if o.passive is not None},
        low={n: o.low for n, o in about.items()},
        high={n: o.high for n, o in about.items()},
        step_limit={n: o.step_limit for n, o in about.items()},
        order=graph.interactions,
        noise={n: o.noise for n, o in about.items()},
        pieces=(),
    )


def _learn(
    pieces: Sequence[Demonstration], graph: InteractionGraph, spec: InteractionSpec, known: KnownParts
) -> InteractionModel:
    started = time.perf_counter()
    data = collect(pieces, graph, known.edges)
    about, taken = known.objects, known.edges
    noise = {n: about[n].noise if n in about else measurement_std(data, n) for n in data.spaces}
    children = [n for n in graph.objects if n not in graph.roots]
    alignments = {e: taken[e].alignment if e in taken else learn_alignment(data, e, noise) for e in data.edges}
    passive = {n: _passive(known, n) or learn_passive(data, n, spec, noise) for n in children}
    effects = {e: learned.effects for e, learned in taken.items()}
    for child in children:
        theirs = {e: learned.effects for e, learned in taken.items() if e.child == child}
        effects |= learn_effects(data, child, passive[child], alignments, spec, noise, theirs)
    typical = {n: typical_row(data.stacked(n)) for n in data.spaces}
    edges = {}
    for e in graph.interactions:
        if e in taken:
            shown = joined_examples(
                taken[e].examples, collect_examples(data, e), typical, elsewhere=e in known.elsewhere
            )
            edges[e] = replace(taken[e], examples=shown)
            continue
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
    model = InteractionModel(
        graph=graph,
        edges=edges,
        passive=passive,
        low={n: np.min([data.stacked(n).min(axis=0), *(o.low for o in _of(known, n))], axis=0) for n in data.spaces},
        high={n: np.max([data.stacked(n).max(axis=0), *(o.high for o in _of(known, n))], axis=0) for n in data.spaces},
        step_limit={
            n: np.max([_step_limit(data, n), *(o.step_limit for o in _of(known, n))], axis=0) for n in data.spaces
        },
        order=data.edges,
        noise=noise,
        pieces=tuple(p.name for p in pieces),
    )
    found = findings_in(data, model)
    for finding in found:
        if finding.fatal:
            raise InputError(finding.text)
    return replace(model, findings=tuple(f.text for f in found), wall_seconds=time.perf_counter() - started)


def _of(known: KnownParts, obj: str) -> list[KnownObject]:
    """What is known of an object: one entry or none."""
    return [known.objects[obj]] if obj in known.objects else []


def _passive(known: KnownParts, obj: str) -> PassiveDynamics | None:
    return known.objects[obj].passive if obj in known.objects else None


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
    moves = np.sqrt(np.mean(changes**2, axis=0)) >= LEARNING.moving * np.sqrt(2.0) * noise
    return np.where(moves, changes.max(axis=0), 0.0)


def _step_limit(data: GraphData, obj: str) -> FloatArray:
    """Largest change of each variable in a tick, shape (n_variables,); angles the short way round."""
    space = data.spaces[obj]
    steps = [np.abs(space.difference(p.states[obj][1:], p.states[obj][:-1])).max(axis=0) for p in data.pieces]
    return np.max(steps, axis=0)
