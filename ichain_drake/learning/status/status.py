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
from ichain_drake.learning.data import BoolArray, GraphData
from ichain_drake.learning.effects.alignment import Alignment
from ichain_drake.learning.frozen import FrozenModel, InputScaling, freeze
from ichain_drake.learning.selection import by_part, calibrated, calibration_error, clearly, least_slip
from ichain_drake.learning.spec import InteractionSpec, make_classifier
from ichain_drake.learning.status.box import Box
from ichain_drake.learning.status.choice import Candidate, InputChoice, input_scales
from ichain_drake.learning.status.inputs import (
    DifferenceInput,
    PlaceInput,
    RelativeInput,
    States,
    StatusInput,
    ValueInput,
    candidate_inputs,
    objects_of,
)
from ichain_drake.learning.status.scores import event_f1, f1
from ichain_drake.state import FloatArray

_FOLDS = 5
_MARGINS = (0.0, 0.05, 0.1, 0.2)
_SURE = 2.0  # standard errors by which the place of something must say more than its place relative to the other
_AROUND = 4  # rows to either side that the mean of what stands still is taken over: a third of its noise is left
_STILL = 4.0  # noises from their median, within which all of them are of something that stands still


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
    chosen = _relative_if_as_good(choice, choice.choose(candidates), candidates) or _of_ends(candidates, edge)
    raw = np.hstack([c.item(_states(data, edge)) for c in chosen])
    floor = np.concatenate([c.noise for c in chosen])
    offset, scale = input_scales(raw, truth, floor)
    x, floor = (raw - offset) / scale, floor / scale
    fold = left_out_folds(truth, piece)
    best, *others = spec.status_estimators
    decisions = _left_out(best, x, floor, truth, fold, edge)
    slip = least_slip(truth)
    likelihood = calibrated(decisions, truth, slip)[2]
    for other in others:
        theirs = _left_out(other, x, floor, truth, fold, edge)
        rows = calibrated(theirs, truth, slip)[2]
        if clearly(by_part(rows - likelihood, piece), len(others)):
            best, decisions, likelihood = other, theirs, rows
    before = np.concatenate([[False], truth[:-1] & (piece[1:] == piece[:-1])])
    margin, spread, slip, rows = _with_memory(decisions, truth, before, piece)
    held = decisions + margin * before
    return StatusModel(
        inputs=tuple(c.item for c in chosen),
        offset=offset,
        scale=scale,
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


def _relative_if_as_good(
    choice: InputChoice, chosen: Sequence[Candidate], candidates: Sequence[Candidate]
) -> list[Candidate]:
    """The place of one end relative to the other in place of its place, where it is not surely worse.

    What is beside the other wherever that is can't be told from what is at a place while the other stays there: the
    roles say which of the two holds elsewhere.
    """
    out = list(chosen)
    for relative in candidates:
        if not isinstance(relative.item, RelativeInput):
            continue
        ends = objects_of(relative.item)
        for k, c in enumerate(out):
            if relative in out or not _is_place(c, ends):
                continue
            other = [*out[:k], relative, *out[k + 1 :]]
            gains = by_part(choice.left_out(out) - choice.left_out(other), choice.piece)
            out = out if gains.sum() > _SURE * np.sqrt(np.sum(gains**2)) else other
        if relative in out and not relative.item.alignment.rows and any(_is_place(c, ends) for c in out):
            # Beside it a place of an end would say once more, along other axes, what was shown while the other stood.
            fewer = [c for c in candidates if not _is_place(c, ends)]
            return choice.choose(fewer)
    return out


def _is_place(candidate: Candidate, objects: Sequence[str]) -> bool:
    return isinstance(candidate.item, PlaceInput) and candidate.item.obj in objects


def _of_ends(candidates: Sequence[Candidate], edge: Interaction) -> list[Candidate]:
    """All that looks at nothing but the two ends of an interaction, where nothing is told apart."""
    return [c for c in candidates if set(objects_of(c.item)) <= {edge.parent, edge.child}]


def _states(data: GraphData, edge: Interaction) -> dict[str, FloatArray]:
    return {n: data.stacked(n) for n in (edge.child, *data.graph.parents(edge.child))}


def status_candidates(
    data: GraphData,
    edge: Interaction,
    alignments: Mapping[Interaction, Alignment | None],
    noise: Mapping[str, FloatArray],
    affected: Collection[int] = (),
) -> list[Candidate]:
    """Everything that the status of an interaction may depend on, the likelier by its role first.

    Args:
        data, edge, alignments, noise, affected: as for `learn_status`.
    """
    states, truth, piece = _states(data, edge), data.flag(edge), data.piece_index()
    ends, others = candidate_inputs(data, edge, alignments)
    # Before an activation the child is as it was one row earlier: what follows from a status doesn't tell it.
    first = np.concatenate([[True], piece[1:] != piece[:-1]])
    earlier = np.where(first | np.concatenate([[False], truth[:-1]]), np.arange(len(truth)), np.arange(len(truth)) - 1)
    lagged = states | {edge.child: states[edge.child][earlier]}
    out = []
    for item in (*ends, *others):
        caused = _is_caused(item, edge, affected)
        seen, floor = lagged if caused else states, input_noise(item, noise)
        if isinstance(item, RelativeInput) and not item.alignment.rows:
            # The one stands while the other passes: its noise would count against what is relative to it.
            seen = {n: _rested(states[n], piece, noise[n]) for n in objects_of(item)}
        out.append(Candidate(item, item(seen), floor, caused))
    return out


def _rested(values: FloatArray, piece: NDArray[np.intp], noise: FloatArray) -> FloatArray:
    """Readings, shape (n, n_variables), with their mean over the rows around each in place of what stands still."""
    out = values.copy()
    for k in np.unique(piece):
        rows = np.flatnonzero(piece == k)
        index = rows[np.clip(np.arange(len(rows))[:, None] + np.arange(-_AROUND, _AROUND + 1), 0, len(rows) - 1)]
        near = values[index]
        still = (np.abs(near - np.median(near, axis=1, keepdims=True)) <= _STILL * noise).all(axis=1)
        out[rows] = np.where(still, near.mean(axis=1), values[rows])
    return out


def input_choice(data: GraphData, edge: Interaction) -> InputChoice:
    """The choice of an interaction's inputs on some pieces."""
    truth, piece = data.flag(edge), data.piece_index()
    begins = np.concatenate([[True], ~truth[:-1] | (piece[1:] != piece[:-1])])
    return InputChoice(truth, piece, left_out_folds(truth, piece), begins)


def _is_caused(item: StatusInput, edge: Interaction, affected: Collection[int]) -> bool:
    """Whether an interaction changes what an input looks at; where child is relative to parent goes along."""
    if isinstance(item, ValueInput):
        return item.obj == edge.child and item.index in affected
    return isinstance(item, PlaceInput) and item.obj == edge.child and not set(item.group.indices).isdisjoint(affected)


def input_noise(item: StatusInput, noise: Mapping[str, FloatArray]) -> FloatArray:
    """Noise of an input's columns, shape (n_columns,)."""
    if isinstance(item, ValueInput):
        return noise[item.obj][[item.index]]
    if isinstance(item, DifferenceInput):
        return np.hypot(noise[item.parent][[item.index[0]]], noise[item.child][[item.index[1]]])
    # Along turned axes: the mean over the position's components.
    if isinstance(item, RelativeInput):
        two = item.alignment
        parent = float(np.mean(noise[item.edge.parent][list(two.parent.indices)]))
        child = float(np.mean(noise[item.edge.child][list(two.child.indices)]))
        return np.full(len(two.parent.indices), np.hypot(parent, child))
    return np.full(len(item.group.indices), float(np.mean(noise[item.obj][list(item.group.indices)])))


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
    if np.sum(counts > 0) < _FOLDS:
        return interleaved_blocks(piece, _FOLDS)
    loads = np.zeros(min(_FOLDS, len(counts)))
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
    for margin in _MARGINS[1:]:
        rows = calibrated(decisions + margin * before, truth, slip)[2]
        if clearly(by_part(rows - best, piece), len(_MARGINS)):
            chosen, best = margin, rows
    # What readings leave open beside a switch must not choose; but it is known of this row, or it isn't.
    return (chosen, *calibrated(decisions + chosen * before, truth, 1.0 / (2.0 + len(truth))))
