"""Learning every link of a chain from demonstrations, each among the candidates that a scenario declares."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ichain_drake.demonstrations.table import Demonstration
from ichain_drake.demonstrations.transitions import Transitions, collect_commands, collect_transitions
from ichain_drake.errors import InputError
from ichain_drake.graph import Interaction, InteractionGraph, Origin
from ichain_drake.learning.chain.command import LearnedCommand, learn_command
from ichain_drake.learning.chain.link import (
    EstimatorSpec,
    ForwardSpec,
    InverseSpec,
    Scored,
    best_by_score,
    fit_forward,
    fit_inverse,
    specs_of,
)
from ichain_drake.learning.chain.models import ActionKind, ForwardModel, InverseModel
from ichain_drake.learning.enough import enough, thinning_told
from ichain_drake.learning.estimators.warned import collected_warnings
from ichain_drake.learning.features import FeatureKind, planar_poses
from ichain_drake.learning.frozen import FrozenModel
from ichain_drake.learning.settings import LEARNING
from ichain_drake.state import FloatArray

DEMONSTRATIONS = "demonstrations"
"""Source of what was learned in this run, from demonstrations."""


@dataclass(frozen=True)
class LinkCandidates:
    """What may be tried for one link; the choice is made by scores and validation.

    Attributes:
        forward: estimators for Tr.
        inverse: estimators for Tr^-1.
        features: what a regression may see of the child; kinds that the child's variables don't allow are left out.
        forward_actions: action conventions for Tr.
        aims: how many ticks ahead Tr^-1 may aim.
        screening: estimator with which features and action convention of Tr are chosen, where trying all with the
            candidates themselves would take long; None to try all.
        action: action convention of Tr^-1, and of Tr where it is not `next`.
        samples: transitions to use; 0 for all.

    Estimators may be given as `EstimatorSpec`, as text such as `polynomial(degree=3)`, or as scikit-learn objects.

    Raises:
        InputError: on what is no estimator, or an object that can't be fitted or frozen.
    """

    forward: tuple[EstimatorSpec, ...] = (EstimatorSpec("polynomial", {"degree": 2}),)
    inverse: tuple[EstimatorSpec, ...] = (EstimatorSpec("polynomial", {"degree": 3}),)
    features: tuple[FeatureKind, ...] = ("none", "raw", "body")
    forward_actions: tuple[ActionKind, ...] = ("next", "both")
    aims: tuple[int, ...] = (1,)
    screening: EstimatorSpec | None = None
    action: ActionKind = "next"
    samples: int = 0

    def __post_init__(self) -> None:
        object.__setattr__(self, "forward", specs_of(self.forward))
        object.__setattr__(self, "inverse", specs_of(self.inverse))
        if self.screening is not None:
            object.__setattr__(self, "screening", specs_of(self.screening)[0])


@dataclass(frozen=True)
class LearnedLink:
    """One learned interaction.

    Attributes:
        interaction: the edge.
        forward: Tr, the best candidate by cross-validation.
        inverses: Tr^-1, all candidates in declared order; which one is used, control decides.
        child_limit: largest change of each child variable in one tick in the demonstrations, shape (n_child,).
        child_scale: median absolute change in one tick, shape (n_child,).
        parent_lower, parent_upper: range of the parent's states, shape (n_parent,).
        parent_scale: standard deviation of the parent's states, shape (n_parent,).
        robot_seconds: simulated time that recording the samples took of the robot [s].
        source: where it came from: `demonstrations` or the name of a library.
    """

    interaction: Interaction
    forward: Scored[ForwardModel, ForwardSpec]
    inverses: tuple[Scored[InverseModel, InverseSpec], ...]
    child_limit: FloatArray
    child_scale: FloatArray
    parent_lower: FloatArray
    parent_upper: FloatArray
    parent_scale: FloatArray
    robot_seconds: float = 0.0
    source: str = DEMONSTRATIONS

    @property
    def is_static(self) -> bool:
        """Whether the child only mirrors its parent: what it was before doesn't help to predict it."""
        return self.forward.spec.features == "none"

    @property
    def best_inverse(self) -> Scored[InverseModel, InverseSpec]:
        """The inverse with the best cross-validation score."""
        return best_by_score(self.inverses)


@dataclass(frozen=True)
class LearnedChain:
    """All links of a chain, robot first.

    Attributes:
        graph: the interaction graph.
        links: one per interaction along the chain.
        targets: indices of the last object's variables that a goal names.
        command: learned map from a wanted hand state to the command that reaches it, or None where the hand goes
            where it is told as far as the demonstrations show.
        command_lower, command_upper: range of the commands, shape (n_hand,).
        hand_limit: largest change of the hand in one tick, shape (n_hand,).
        validation: measured states of the last object, one array a piece, for validation only.
        command_origin: what positions are relative to in `command`; see `LearnedCommand`.
    """

    graph: InteractionGraph
    links: tuple[LearnedLink, ...]
    targets: tuple[int, ...]
    command: FrozenModel | None
    command_lower: FloatArray
    command_upper: FloatArray
    hand_limit: FloatArray
    validation: tuple[FloatArray, ...] = field(default=(), repr=False)
    command_origin: Origin | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """Objects along the chain, robot first."""
        return (self.links[0].interaction.parent, *(link.interaction.child for link in self.links))

    def advance(self, now: Mapping[str, FloatArray], after: dict[str, FloatArray]) -> None:
        """One tick of all objects behind the robot.

        Args:
            now: states at t, shape (n, n_variables).
            after: has the robot's at t + 1; is given the others'.
        """
        for link in self.links:
            parent, child = link.interaction.parent, link.interaction.child
            after[child] = link.forward.model.predict(now[child], now[parent], after[parent])


def _usable_features(data: Transitions, kinds: Sequence[FeatureKind]) -> list[FeatureKind]:
    return [k for k in kinds if k != "body" or planar_poses(data.child_space)]


def _fit_forwards(
    data: Transitions, options: Iterable[ForwardSpec], edge: Interaction, origin: Origin | None
) -> list[Scored[ForwardModel, ForwardSpec]]:
    fitted, refused = [], None
    for spec in options:
        try:
            fitted.append(fit_forward(data, spec, edge, origin))
        except InputError as error:
            refused = error
    if not fitted:
        raise refused or InputError(f"{edge.name}: no candidate for the forward model is declared")
    return fitted


def _most_likely(fitted: Sequence[Scored[ForwardModel, ForwardSpec]]) -> Scored[ForwardModel, ForwardSpec]:
    """The candidate under which left-out transitions are most likely; the earlier, simpler one of near equals.

    For Gaussian residuals that is the least mean logarithm of their standard deviations, a figure that units don't
    change, so that one badly predictable variable does not drown the others.
    """
    surprise = [float(np.mean(np.log(np.maximum(f.residual_std, 1e-12)))) for f in fitted]
    least = min(surprise)
    return next(f for f, s in zip(fitted, surprise, strict=True) if s <= least + LEARNING.surprise)


def _best_forward(
    data: Transitions, candidates: LinkCandidates, edge: Interaction, origin: Origin | None
) -> Scored[ForwardModel, ForwardSpec]:
    actions = candidates.forward_actions if candidates.action == "next" else (candidates.action,)
    views = list(itertools.product(_usable_features(data, candidates.features), actions))
    if candidates.screening is not None and len(views) > 1:
        screened = _fit_forwards(data, (ForwardSpec(candidates.screening, k, a) for k, a in views), edge, origin)
        best = _most_likely(screened).spec
        views = [(best.features, best.action)]
    specs = (ForwardSpec(e, k, a) for (k, a), e in itertools.product(views, candidates.forward))
    return _most_likely(_fit_forwards(data, specs, edge, origin))


def learn_link(
    pieces: Iterable[Demonstration],
    graph: InteractionGraph,
    edge: Interaction,
    candidates: LinkCandidates,
    targets: Sequence[int],
    robot_seconds: float = 0.0,
) -> LearnedLink:
    """Learn one interaction (paper sec. III, IV), in positions relative to the child's origin where one is declared.

    Args:
        pieces: checked demonstrations.
        graph: the interaction graph.
        edge: the interaction.
        candidates: what may be tried.
        targets: the child's variables that wanted states will name.
        robot_seconds: for the report.

    Raises:
        InputError: if no piece shows the interaction, or the samples are too few for every candidate.
    """
    data = collect_transitions(list(pieces), graph, edge, candidates.samples or None)
    origin = graph.origin_for(edge)
    forward = _best_forward(data, candidates, edge, origin)
    kinds = ["none"] if forward.spec.features == "none" else _usable_features(data, candidates.features)
    inverses, refused = [], None
    for kind, aim, estimator in itertools.product(kinds, candidates.aims, candidates.inverse):
        if kind == "none" and forward.spec.features != "none":
            continue
        try:
            inverse = InverseSpec(estimator, kind, aim, candidates.action)  # type: ignore[arg-type]
            inverses.append(fit_inverse(data, inverse, targets, edge, origin))
        except InputError as error:
            refused = error
    if not inverses:
        raise refused or InputError(f"{edge.name}: no candidate for the inverse model is declared")
    change = np.abs(data.child_space.difference(data.child_next, data.child))
    return LearnedLink(
        edge,
        forward,
        tuple(inverses),
        np.maximum(change.max(axis=0), 1e-9),
        np.maximum(np.median(change, axis=0), 1e-9),
        data.parent_next.min(axis=0),
        data.parent_next.max(axis=0),
        np.maximum(data.parent_next.std(axis=0), 1e-9),
        robot_seconds,
    )


def _learn_robot(pieces: Sequence[Demonstration], graph: InteractionGraph, first: LearnedLink) -> LearnedCommand:
    """What the pieces say about commanding the hand; without recorded commands, that it goes where it is told."""
    data = collect_commands(pieces, graph)
    origin = graph.origin_for(first.interaction)
    if data is None:
        reach = np.maximum(first.parent_upper - first.parent_lower, 1e-9)
        return LearnedCommand(None, first.parent_lower, first.parent_upper, reach, origin)
    commands, states = data
    limit = np.maximum(_largest_step(pieces, graph), 1e-9)
    offset = None if origin is None else origin.offset(first.forward.model.parent_space)
    relative = data if offset is None else (commands - offset, states - offset)
    return LearnedCommand(learn_command(*relative), commands.min(axis=0), commands.max(axis=0), limit, origin)


def _largest_step(pieces: Sequence[Demonstration], graph: InteractionGraph) -> FloatArray:
    """Largest change of the hand in one tick, shape (n_hand,); not across pieces, angles the short way round."""
    space = graph.objects[graph.root].observable
    states = [p.states(graph.root, space) for p in pieces if p.has(graph.root, space)]
    return np.concatenate([np.abs(space.difference(s[1:], s[:-1])) for s in states]).max(axis=0)


def learn_chain(
    pieces: Iterable[Demonstration],
    graph: InteractionGraph,
    target: str,
    targets: Sequence[str],
    candidates: Mapping[str, LinkCandidates],
    robot_seconds: Mapping[str, float] | None = None,
    progress: Callable[[str], None] | None = None,
    known: Mapping[str, LearnedLink] | None = None,
    known_command: LearnedCommand | None = None,
) -> LearnedChain:
    """Learn all links of the chain from the robot to an object.

    Args:
        pieces: checked demonstrations.
        graph: the interaction graph.
        target: the object whose goal will be asked for.
        targets: its variables that goals name.
        candidates: per interaction name; `*` for those not named.
        robot_seconds: simulated robot time per interaction name, for the report.
        progress: called with a line before each link.
        known: links that are taken as they are (from a library), by interaction name.
        known_command: what was learned about commanding the hand, where the first link is known.

    Raises:
        InputError: if a link can't be learned, naming it, or the graph has several robots.
    """
    graph.only_root("a chain that follows paths")
    given = list(pieces)
    pieces = enough(given, graph)
    for line in thinning_told(given, pieces) if progress else ():
        progress(line)  # type: ignore[misc]
    names = graph.chain(target)
    if len(names) == 1:
        raise InputError(f"{target} is the robot itself: there is no link to learn; name an object that it acts on")
    links = []
    with collected_warnings(progress):
        for parent, child in itertools.pairwise(names):
            edge = Interaction(parent, child)
            space = graph.objects[child].observable
            indices = space.indices(targets) if child == target else np.arange(len(space))
            if known and edge.name in known:
                links.append(known[edge.name])
                continue
            if progress:
                progress(f"learning {edge.name}")
            chosen = candidates.get(edge.name, candidates.get("*", LinkCandidates()))
            seconds = (robot_seconds or {}).get(edge.name, 0.0)
            links.append(learn_link(pieces, graph, edge, chosen, [int(i) for i in indices], seconds))
    command = known_command or _learn_robot(pieces, graph, links[0])
    space = graph.objects[target].observable
    seen = tuple(p.states(target, space) for p in pieces if p.has(target, space))
    return LearnedChain(
        graph,
        tuple(links),
        tuple(int(i) for i in graph.objects[target].observable.indices(targets)),
        command.map,
        command.lower,
        command.upper,
        command.hand_limit,
        seen,
        command.origin,
    )


def replace_samples(candidates: Mapping[str, LinkCandidates], samples: int) -> dict[str, LinkCandidates]:
    """The same candidates on another number of transitions."""
    return {name: replace(c, samples=samples) for name, c in candidates.items()}
