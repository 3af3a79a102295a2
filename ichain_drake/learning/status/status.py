"""Status models: how probable it is that an interaction is active, from states alone (paper sec. V, classifiers).

One memoryless model an edge, learned from all rows: an activation is that it becomes active while the interaction is
inactive, a deactivation the reverse. Classifiers of the switching rows alone would have one to eight examples.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from ichain_drake.errors import InputError
from ichain_drake.graph import Interaction
from ichain_drake.learning.blocks import interleaved_blocks
from ichain_drake.learning.chain.link import EstimatorSpec
from ichain_drake.learning.data import GraphData
from ichain_drake.learning.effects.alignment import Alignment
from ichain_drake.learning.frozen import FrozenModel, InputScaling, freeze
from ichain_drake.learning.selection import borne_out, by_part, calibrated, calibration_error, clearly, least_slip
from ichain_drake.learning.settings import LEARNING
from ichain_drake.learning.spec import InteractionSpec, make_classifier
from ichain_drake.learning.status.box import Box
from ichain_drake.learning.status.candidates import states_around, status_candidates
from ichain_drake.learning.status.choice import Candidate, InputChoice, input_scales
from ichain_drake.learning.status.inputs import (
    States,
    StatusInput,
    objects_of,
)
from ichain_drake.learning.status.relative import beside_relative, relative_if_as_good
from ichain_drake.learning.status.scores import event_f1, f1
from ichain_drake.state import BoolArray, FloatArray


@dataclass(frozen=True)
class StatusModel:
    """A model of one interaction's status: `P(active) = slip + (1 - 2 slip) Phi((decision + margin) / spread)`.

    Attributes:
        inputs: what it looks at; none where the interaction is always active.
        offset, scale: of the inputs' columns, shape (n_columns,).
        frozen: decision function; >= 0 means active.
        margin: what is known to be active stays so down to a decision value of -margin.
        spread: of decision values, by the noise of readings and what isn't known of the border.
        slip: probability that a status is not what the states say.
        estimator: name with parameters.
        score: F1 of the status on rows left out.
        event_score: F1 of switching events within one row, on rows left out.
        likelihood: mean log-likelihood of a row left out [nat].
        calibration_error: expected calibration error on rows left out.
        samples: number of rows.
        positives: number of rows in which the interaction is active.
    """

    inputs: tuple[StatusInput, ...]
    offset: FloatArray
    scale: FloatArray
    frozen: FrozenModel
    margin: float
    spread: float
    slip: float
    estimator: str
    score: float
    event_score: float
    likelihood: float
    calibration_error: float
    samples: int
    positives: int

    def columns(self, states: States) -> FloatArray:
        """Scaled inputs, shape (n, n_columns), from states of shape (n, n_variables) per object."""
        rows = len(next(iter(states.values())))
        return (np.hstack([np.empty((rows, 0)), *(i(states) for i in self.inputs)]) - self.offset) / self.scale

    def decide(self, states: States) -> FloatArray:
        """Decision values, shape (n,)."""
        return self.frozen.batch(self.columns(states))[:, 0]

    def active(self, states: States, previous: BoolArray | None = None) -> BoolArray:
        """Whether it is active, shape (n,); with the previous status the decision has hysteresis."""
        value = self.decide(states)
        if previous is None or self.margin == 0.0:
            return value >= 0.0
        return value >= np.where(previous, -self.margin, 0.0)

    def probability(self, states: States, previous: BoolArray | None = None) -> FloatArray:
        """Probability that it is active, shape (n,), calibrated on rows left out; `previous` as for `active`."""
        value = self.decide(states) + self.margin * (0.0 if previous is None else previous)
        return np.asarray(self.slip + (1.0 - 2.0 * self.slip) * ndtr(value / self.spread))


def always_active(samples: int) -> StatusModel:
    """The status of a permanent coupling, which was never seen inactive in so many rows."""
    none = np.zeros(0)
    box = Box(inputs=InputScaling.identity(0), middle=none, half=none, gain=np.ones(1), offset=np.zeros(1))
    slip = 1.0 / (2.0 + samples)
    return StatusModel((), none, none, box, 0.0, 1.0, slip, "always", 1.0, 1.0, float(np.log1p(-slip)), slip, samples,
                       samples)  # fmt: skip


def learn_status(
    data: GraphData,
    edge: Interaction,
    alignments: Mapping[Interaction, Alignment | None],
    spec: InteractionSpec,
    noise: Mapping[str, FloatArray],
    affected: Collection[int] = (),
) -> StatusModel:
    """Learn the status model of one interaction.

    Args:
        data: the pieces.
        edge: the interaction.
        alignments: of all interactions.
        spec: candidate estimators.
        noise: measurement noise per object.
        affected: indices of the child's variables that the interaction changes; see `Candidate.caused`.

    Raises:
        InputError: if no candidate estimator can be fitted and frozen; names the edge and the reason.
    """
    truth, piece = data.flag(edge), data.piece_index()
    if truth.all():
        return always_active(len(truth))
    candidates = status_candidates(data, edge, alignments, noise, affected)
    choice = input_choice(data, edge)
    chosen, candidates = relative_if_as_good(choice, choice.choose(candidates), candidates)
    trial = _Trial.of(data, edge, chosen or _of_ends(candidates, edge), spec)
    trial = _told_by_classifiers(trial, choice, candidates, data, edge, spec)
    best, decisions, slip, x, floor = trial.best, trial.decisions, least_slip(truth), trial.x, trial.floor
    before = np.concatenate([[False], truth[:-1] & (piece[1:] == piece[:-1])])
    margin, spread, slip, rows = _with_memory(decisions, truth, before, piece)
    held = decisions + margin * before
    return StatusModel(
        inputs=tuple(c.item for c in trial.chosen),
        offset=trial.offset,
        scale=trial.scale,
        frozen=_fit(best, x, floor, truth, edge),
        margin=margin,
        spread=spread,
        slip=slip,
        estimator=str(best),
        score=f1(truth, decisions >= 0.0),
        event_score=event_f1(
            [truth[piece == k] for k in np.unique(piece)],
            [_held(decisions[piece == k], margin) for k in np.unique(piece)],
        ),
        likelihood=float(rows.mean()),
        calibration_error=calibration_error(slip + (1.0 - 2.0 * slip) * ndtr(held / spread), truth),
        samples=len(truth),
        positives=int(truth.sum()),
    )


@dataclass(frozen=True)
class _Trial:
    """Some inputs with the estimator that is likeliest on rows left out.

    Attributes:
        chosen: the inputs.
        offset, scale: of their columns.
        x, floor: their scaled columns, shape (n, n_columns), and the noise of each.
        best: the estimator.
        decisions: of each row, by a fit that has not seen its fold, shape (n,).
        likelihood: of each row's flag, shape (n,).
    """

    chosen: list[Candidate]
    offset: FloatArray
    scale: FloatArray
    x: FloatArray
    floor: FloatArray
    best: EstimatorSpec
    decisions: FloatArray
    likelihood: FloatArray

    @staticmethod
    def of(data: GraphData, edge: Interaction, chosen: list[Candidate], spec: InteractionSpec) -> _Trial:
        truth, piece = data.flag(edge), data.piece_index()
        raw = np.hstack([c.item(states_around(data, edge)) for c in chosen])
        floor = np.concatenate([c.noise for c in chosen])
        offset, scale = input_scales(raw, truth, floor)
        x, floor = (raw - offset) / scale, floor / scale
        fold, slip = left_out_folds(truth, piece), least_slip(truth)
        best, *others = spec.status_estimators
        decisions = _left_out(best, x, floor, truth, fold, edge)
        likelihood = calibrated(decisions, truth, slip)[2]
        for other in others:
            theirs = _left_out(other, x, floor, truth, fold, edge)
            rows = calibrated(theirs, truth, slip)[2]
            if clearly(by_part(rows - likelihood, piece), len(others)):
                best, decisions, likelihood = other, theirs, rows
        return _Trial(chosen, offset, scale, x, floor, best, decisions, likelihood)

    def beats(self, other: _Trial, piece: NDArray[np.intp], tried: int = 1) -> bool:
        """Whether it is clearly likelier, and not by one piece alone."""
        return borne_out(by_part(self.likelihood - other.likelihood, piece), tried)


def _told_by_classifiers(
    trial: _Trial,
    choice: InputChoice,
    candidates: Sequence[Candidate],
    data: GraphData,
    edge: Interaction,
    spec: InteractionSpec,
) -> _Trial:
    """Inputs of which boxes can't tell whether they add something, put to the estimators; then what they make idle.

    A region with a round or slanted border is no box: what is wrong at its corners may hide what an input tells. Beside
    a relative place no place of an end is asked about: it has less noise and says the same while the other end stands.
    """
    piece, likely = data.piece_index(), [c for c in trial.chosen if not c.caused]
    left = choice.open(likely, [c for c in beside_relative(likely, candidates) if c not in trial.chosen])
    # What the interaction itself changes comes last: it is for what all others leave to be told.
    alone = likely and left and len(likely) < len(trial.chosen)
    found = first = _Trial.of(data, edge, likely, spec) if alone else trial
    for candidate in left:
        more = _Trial.of(data, edge, [*likely, candidate], spec)
        if not more.beats(found, piece, len(candidates)):  # any of them might have been left
            continue
        found = more
        for item in more.chosen[:-1]:
            fewer = _Trial.of(data, edge, [c for c in found.chosen if c is not item], spec)
            if not found.beats(fewer, piece, len(candidates)):
                found = fewer
        likely = found.chosen
    return trial if found is first or trial.beats(found, piece) else found


def _of_ends(candidates: Sequence[Candidate], edge: Interaction) -> list[Candidate]:
    """All that looks at nothing but the two ends of an interaction, where nothing is told apart."""
    return [c for c in candidates if set(objects_of(c.item)) <= {edge.parent, edge.child}]


def input_choice(data: GraphData, edge: Interaction) -> InputChoice:
    """The choice of an interaction's inputs on some pieces."""
    truth, piece = data.flag(edge), data.piece_index()
    begins = np.concatenate([[True], ~truth[:-1] | (piece[1:] != piece[:-1])])
    return InputChoice(truth, piece, left_out_folds(truth, piece), begins)


def _fit(estimator: EstimatorSpec, x: FloatArray, noise: FloatArray, y: BoolArray, edge: Interaction) -> FrozenModel:
    try:
        model = freeze(make_classifier(estimator, noise).fit(x, y))
    except (ValueError, TypeError) as error:  # InputError is one
        raise InputError(f"{edge.name}, status: {estimator}: {' '.join(str(error).split())[:300]}") from None
    if model.n_out != 1:
        raise InputError(f"{edge.name}, status: {estimator} gives {model.n_out} decision values; one is needed")
    return model


def _left_out(
    estimator: EstimatorSpec,
    x: FloatArray,
    noise: FloatArray,
    y: BoolArray,
    fold: NDArray[np.intp],
    edge: Interaction,
) -> FloatArray:
    """Decision value of every row by a classifier that has not seen its fold, shape (n,)."""
    out = np.empty(len(y))
    for k in np.unique(fold):
        test = fold == k
        train = ~test
        if y[train].all() or not y[train].any():
            out[test] = 1.0 if y[train].all() else -1.0
            continue
        out[test] = _fit(estimator, x[train], noise, y[train], edge).batch(x[test])[:, 0]
    return out


def left_out_folds(truth: BoolArray, piece: NDArray[np.intp]) -> NDArray[np.intp]:
    """Rows that are left out together, shape (n,): whole pieces, positives dealt evenly; blocks where few show any."""
    counts = np.bincount(piece, weights=truth)
    if np.sum(counts > 0) < LEARNING.folds:
        return interleaved_blocks(piece, LEARNING.folds)
    loads = np.zeros(min(LEARNING.folds, len(counts)))
    of_piece = np.zeros(len(counts), dtype=np.intp)
    for rank, k in enumerate(sorted(range(len(counts)), key=lambda k: (-counts[k], k))):
        fold = int(np.argmin(loads)) if counts[k] else rank % len(loads)
        of_piece[k] = fold
        loads[fold] += counts[k]
    return of_piece[piece]


def _held(decisions: FloatArray, margin: float) -> BoolArray:
    """Status of successive rows with hysteresis, shape (n,)."""
    out = np.empty(len(decisions), dtype=bool)
    on = bool(decisions[0] >= 0.0)
    for k, value in enumerate(decisions):
        on = bool(value >= (-margin if on else 0.0)) if k else on
        out[k] = on
    return out


def _with_memory(
    decisions: FloatArray, truth: BoolArray, before: BoolArray, piece: NDArray[np.intp]
) -> tuple[float, float, float, FloatArray]:
    """Hysteresis, spread and slip under which left-out rows are likeliest, and the log-likelihood of each row."""
    slip, chosen = least_slip(truth), 0.0
    best = calibrated(decisions, truth, slip)[2]
    for margin in LEARNING.margins[1:]:
        rows = calibrated(decisions + margin * before, truth, slip)[2]
        if clearly(by_part(rows - best, piece), len(LEARNING.margins)):
            chosen, best = margin, rows
    # What readings leave open beside a switch must not choose; but it is known of this row, or it isn't.
    return (chosen, *calibrated(decisions + chosen * before, truth, 1.0 / (2.0 + len(truth))))
