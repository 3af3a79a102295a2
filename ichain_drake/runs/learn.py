"""From demonstrations to the one learned thing, for a chain that follows paths and for a graph with a goal alike."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from typing import Any

from threadpoolctl import threadpool_limits

from ichain_drake.demonstrations import Demonstration
from ichain_drake.errors import InputError
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning import InteractionModel, InteractionSpec, KnownParts, contradicted, learn_interactions
from ichain_drake.learning.chain.chain import LinkCandidates, learn_chain
from ichain_drake.learning.estimators.warned import collected_warnings
from ichain_drake.learning.spec import spec_of
from ichain_drake.runs.goals.settings import graph_spec
from ichain_drake.scenarios.base import PathScenario, Progress
from ichain_drake.timing import TICK

Known = InteractionModel | KnownParts
"""What was learned before: all of a graph, or parts of it (see `load`)."""


def learn(
    what: Any,
    demonstrations: Iterable[Demonstration],
    *,
    known: Known | None = None,
    spec: InteractionSpec | Mapping[str, LinkCandidates] | None = None,
    estimators: Any = None,
    target: str = "",
    target_variables: Sequence[str] = ("x", "y"),
    progress: Progress | None = None,
) -> InteractionModel:
    """Learn the interactions of a graph.

    A scenario that follows paths, and a graph with a `target`, is learned as a chain whose interactions are always
    active: forward and inverse models of each link, from pieces that may show a part of the chain each, without flags.
    Everything else is learned from unordered pieces with flags: effects, passive dynamics, and when each interaction is
    active.

    Args:
        what: a scenario, whose settings are obeyed, or an `InteractionGraph`.
        demonstrations: pieces.
        known: what was learned before (see `load`): the pieces need not show it.
        spec: what may be tried: `InteractionSpec`, or for a chain `LinkCandidates` by interaction name.
        estimators: the same in short, for every interaction: scikit-learn objects, pipelines or names, as in
            `estimators=[make_pipeline(StandardScaler(), Ridge())]`. Regressors are for what happens, classifiers for
            when; of a chain, which has no statuses, they are the candidates for its forward models.
        target: the object that will follow paths, the last of a chain; for a graph.
        target_variables: its position variables.
        progress: called with a line at each step.

    Raises:
        InputError: on demonstrations that can't be learned from; names piece, edge and remedy. On estimators that
            can't be used; says which can.
    """
    spec = _asked(spec, estimators, chain=isinstance(what, PathScenario) or bool(target))
    if isinstance(known, InteractionModel):
        return known
    parts, pieces = known or KnownParts(), list(demonstrations)
    graph: InteractionGraph = what if isinstance(what, InteractionGraph) else what.graph
    if isinstance(what, PathScenario):
        target, target_variables = what.target, what.target_variables
        spec = spec or what.config.learning.candidates()
    with threadpool_limits(limits=1):  # the same models in every bit, for any number of processors
        if not target:
            if spec is None and graph is not what:
                spec = graph_spec(what.config)
            return learn_interactions(pieces, graph, spec, parts)  # type: ignore[arg-type]
        chain = learn_chain(
            pieces, graph, target, target_variables, spec or {},  # type: ignore[arg-type]
            recorded_seconds(pieces, graph), progress, parts.links, parts.command,
        )  # fmt: skip
    return InteractionModel.of_chain(chain, pieces, parts)


def _asked(spec: Any, estimators: Any, *, chain: bool) -> Any:
    """What may be tried, None for the usual; what is of another type is refused before any work."""
    if estimators is not None:
        if spec is not None:
            raise InputError("learn: estimators are given twice, as spec and as estimators; give one of them")
        if chain:
            return {"*": LinkCandidates(forward=estimators)}
        return spec_of(estimators)
    wanted: Any = Mapping if chain else InteractionSpec
    if spec is not None and not isinstance(spec, wanted):
        form = "LinkCandidates by interaction name" if chain else "an InteractionSpec"
        raise InputError(f"learn: spec is of type {type(spec).__name__}, {form} needed; a list goes into estimators")
    return spec


def learn_rest(
    show: Callable[[Collection[Interaction]], Sequence[Demonstration]],
    graph: InteractionGraph,
    known: Known | None = None,
    spec: InteractionSpec | None = None,
    say: Progress | None = None,
) -> InteractionModel:
    """Learn what isn't known yet of a graph.

    Known interactions that the demonstrations contradict are learned anew; their pieces are asked for, too.

    Args:
        show: gives the pieces that show all but some known interactions; is called anew with fewer of those where the
            pieces contradict one.
        graph: the interaction graph.
        known: from before; all of it, and nothing is shown.
        spec: candidate estimators.
        say: called with a line at each step.

    Raises:
        InputError: as `learn`.
    """
    if isinstance(known, InteractionModel):
        return known.for_goals()
    parts = known or KnownParts()
    say = say or (lambda line: None)
    if not parts.is_whole(graph):
        for edge, why in parts.reasons.items():
            say(f"{edge.name} is learned: {why}")
    while True:
        pieces = [] if parts.is_whole(graph) else show(list(parts.edges))
        against = contradicted(pieces, graph, parts)
        if not against:
            break
        for edge, why in against.items():
            say(f"{edge.name} is learned anew: {why}")
        parts = parts.without(against)
    say(f"learning from {len(pieces)} pieces" if pieces else "everything is known; nothing is learned")
    with collected_warnings(say):
        model = learn(graph, pieces, known=parts, spec=spec)
    for finding in model.findings:
        say(finding)
    return model


def recorded_seconds(pieces: Sequence[Demonstration], graph: InteractionGraph) -> dict[str, float]:
    """Simulated robot time that went into demonstrations, per interaction name [s].

    A piece in which the robot was recorded took its time; one without it (somebody else moved the parent) did not.
    """
    out = {edge.name: 0.0 for edge in graph.interactions}
    for piece in pieces:
        if not piece.has(graph.root, graph.objects[graph.root]):
            continue
        for edge in graph.interactions:
            if all(piece.has(end, graph.objects[end]) for end in (edge.parent, edge.child)):
                out[edge.name] += (len(piece) - 1) * TICK
    return out
