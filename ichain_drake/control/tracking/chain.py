"""From learned links to a controller: which method at which level, chosen by validation on the learned graph."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Literal, get_args

import numpy as np

from ichain_drake.control.tracking.levels import InverseLevel, Level, PredictiveLevel, PredictiveWeights
from ichain_drake.control.tracking.move_to import MoveTo, RobotLevel
from ichain_drake.control.tracking.path import PathLimits
from ichain_drake.control.tracking.validation import ValidationCase, make_cases, validation_error
from ichain_drake.errors import InputError
from ichain_drake.learning.chain.chain import LearnedChain, LearnedLink
from ichain_drake.learning.chain.link import Scored
from ichain_drake.state import FloatArray

Method = Literal["predictive", "inverse"]
METHODS: tuple[str, ...] = get_args(Method)


@dataclass(frozen=True)
class ControlCandidates:
    """What validation may choose from.

    Attributes:
        horizons, efforts: of the predictive method, see `PredictiveWeights`.
        along, offset: see `PredictiveWeights`.
        cases, ticks: number and length of the validation runs.
        seed: seed of the validation runs' noise.
    """

    horizons: tuple[int, ...] = (5,)
    efforts: tuple[float, ...] = (0.02, 0.05, 0.1)
    along: float = 0.2
    offset: float = 0.0
    cases: int = 12
    ticks: int = 30
    seed: int = 7


@dataclass(frozen=True)
class Choice:
    """One option for the level of the last object, with its validation error.

    Attributes:
        label: in words.
        error: mean distance to the validation paths, in the target's unit; infinite where a run was lost.
        inverse: the inverse model, for the inverse method.
        weights: for the predictive method.
    """

    label: str
    error: float
    inverse: Scored | None = None
    weights: PredictiveWeights | None = None


@dataclass(frozen=True)
class ChainController:
    """A controller for a learned chain and how it came about.

    Attributes:
        policy: decides every tick.
        method: which way the last object is controlled.
        choice: the option that validation chose.
        options: all options with their validation errors.
    """

    policy: MoveTo
    method: str
    choice: Choice
    options: tuple[Choice, ...] = field(default=())


def _inverse_level(link: LearnedLink, scored: Scored) -> InverseLevel:
    return InverseLevel(scored.model, link.child_limit[list(scored.model.targets)])


def _predictive_level(chain: LearnedChain, link: LearnedLink, weights: PredictiveWeights) -> PredictiveLevel:
    targets = chain.targets if link is chain.links[-1] else tuple(range(len(link.child_scale)))
    # A direction-free scale: the usual step of the whole target, the same for each of its variables of one unit.
    scale = np.full(len(targets), float(np.linalg.norm(link.child_scale[list(targets)])))
    return PredictiveLevel(
        link.forward.model,
        link.forward.model.child_space,
        targets,
        scale,
        link.parent_lower,
        link.parent_upper,
        link.parent_scale,
        weights,
        _parent_step(chain, link),
    )


def _parent_step(chain: LearnedChain, link: LearnedLink) -> FloatArray:
    """Largest change of a link's parent in one tick that the links before it, or the robot, were seen to make."""
    before = [x for x in chain.links if x.interaction.child == link.interaction.parent]
    return before[0].child_limit if before else chain.hand_limit


def _policy(chain: LearnedChain, last: Level, *, command: bool) -> MoveTo:
    lower: list[Level] = []
    for link in chain.links[:-1]:
        if link.is_static:
            lower.append(_inverse_level(link, link.best_inverse))
        else:
            lower.append(_predictive_level(chain, link, PredictiveWeights()))
    robot = RobotLevel(
        chain.graph.objects[chain.names[0]].observable,
        chain.hand_limit,
        chain.command if command else None,
        chain.command_lower if command else chain.links[0].parent_lower,
        chain.command_upper if command else chain.links[0].parent_upper,
        chain.command_origin,
    )
    return MoveTo((*lower, last), robot)


def _options(chain: LearnedChain, method: str, candidates: ControlCandidates) -> list[Choice]:
    if method == "inverse":
        return [Choice(str(s.spec), np.nan, inverse=s) for s in chain.links[-1].inverses]
    weights = [
        PredictiveWeights(horizon=h, effort=e, along=candidates.along, offset=candidates.offset)
        for h, e in itertools.product(candidates.horizons, candidates.efforts)
    ]
    return [Choice(f"horizon {w.horizon}, effort {w.effort:g}", np.nan, weights=w) for w in weights]


def _last_level(chain: LearnedChain, choice: Choice) -> Level:
    link = chain.links[-1]
    if choice.inverse is not None:
        return _inverse_level(link, choice.inverse)
    if choice.weights is None:
        raise InputError("a choice holds neither an inverse model nor weights")
    return _predictive_level(chain, link, choice.weights)


def make_controller(
    chain: LearnedChain,
    method: str,
    limits: PathLimits,
    candidates: ControlCandidates | None = None,
    progress: Callable[[str], None] | None = None,
) -> ChainController:
    """Build the controller of a learned chain.

    What is open at the level of the last object (features, degree and aim of the inverse; horizon and effort of the
    predictive method) is chosen by following validation paths, cut out of the demonstrations, on the learned graph
    with noise as large as the models' residuals. Nothing of the reported paths or of the world is used.

    Args:
        chain: the learned chain.
        method: `predictive` or `inverse` (the paper's).
        limits: how paths are followed.
        candidates: see `ControlCandidates`.
        progress: called with a line before each option.

    Demonstrations too short to cut a validation path from leave the choice to cross-validation scores.

    Raises:
        InputError: on an unknown method.
    """
    if method not in METHODS:
        raise InputError(f"control.method {method!r}: choose {' or '.join(METHODS)}")
    candidates = candidates or ControlCandidates()
    options = _options(chain, method, candidates)
    cases: list[ValidationCase] = []
    if len(options) > 1:
        try:
            cases = make_cases(chain, limits, candidates.cases, candidates.ticks, candidates.seed)
        except InputError as error:
            if progress:
                progress(f"no validation, the options are taken by their scores: {error}")
    if cases:
        options = [_validated(chain, option, cases, candidates.seed, progress) for option in options]
    choice = _best(options)
    return ChainController(_policy(chain, _last_level(chain, choice), command=True), method, choice, tuple(options))


def _best(options: Sequence[Choice]) -> Choice:
    """By validation; without any success in it, by cross-validation score, or the middle one of several weights."""
    valid = [o for o in options if np.isfinite(o.error)]
    if valid:
        return min(valid, key=lambda o: o.error)
    if options[0].inverse is None:
        return options[len(options) // 2]
    return max(options, key=lambda o: o.inverse.score if o.inverse is not None else -np.inf)


def _validated(
    chain: LearnedChain,
    option: Choice,
    cases: Sequence[ValidationCase],
    seed: int,
    progress: Callable[[str], None] | None,
) -> Choice:
    if progress:
        progress(f"validating {option.label}")
    policy = _policy(chain, _last_level(chain, option), command=False)
    error = validation_error(chain, policy, cases, seed)
    return Choice(option.label, error, option.inverse, option.weights)
