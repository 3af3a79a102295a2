"""Status classifiers: whether an interaction is active, from states alone (paper sec. V, (de)activation classifiers).

One memoryless classifier an edge, trained on all rows: an activation is that it becomes true while the interaction is
inactive, a deactivation the reverse. Classifiers of the switching rows alone would have one to eight examples.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ichain_drake.errors import InputError
from ichain_drake.graph import Interaction
from ichain_drake.learning.blocks import interleaved_blocks
from ichain_drake.learning.chain.link import EstimatorSpec
from ichain_drake.learning.data import BoolArray, GraphData
from ichain_drake.learning.effects.alignment import Alignment
from ichain_drake.learning.frozen import FrozenModel, freeze
from ichain_drake.learning.spec import InteractionSpec, make_classifier
from ichain_drake.learning.status.choice import choose_inputs, input_scales
from ichain_drake.learning.status.inputs import (
    DifferenceInput,
    RelativeInput,
    States,
    StatusInput,
    ValueInput,
    candidate_inputs,
)
from ichain_drake.learning.status.scores import event_f1, f1
from ichain_drake.state import FloatArray

_FOLDS = 5
_BLOCKS = (7, 10, 14)  # rows
_MARGINS = (0.0, 0.05, 0.1, 0.2)
_GAIN = 0.005  # of the score, for hysteresis
_CLEARLY = 0.1  # of the score, to prefer a later estimator: less is a few events more or less


@dataclass(frozen=True)
class StatusModel:
    """A classifier of one interaction's status.

    Attributes:
        inputs: what it looks at.
        offset, scale: of the inputs' columns, shape (n_columns,).
        frozen: decision function; >= 0 means active.
        margin: what is known to be active stays so down to a decision value of -margin.
        estimator: name with parameters.
        score: F1 of the status on pieces left out.
        event_score: F1 of switching events within one row, on pieces left out.
        block_score: mean of the two where short blocks of every piece are left out instead: without the only piece
            that shows a border, the border can't be known.
        samples: number of rows.
        positives: number of rows in which the interaction is active.
    """

    inputs: tuple[StatusInput, ...]
    offset: FloatArray
    scale: FloatArray
    frozen: FrozenModel
    margin: float
    estimator: str
    score: float
    event_score: float
    block_score: float
    samples: int
    positives: int

    def columns(self, states: States) -> FloatArray:
        """Scaled inputs, shape (n, n_columns), from states of shape (n, n_variables) per object."""
        return (np.hstack([i(states) for i in self.inputs]) - self.offset) / self.scale

    def decide(self, states: States) -> FloatArray:
        """Decision values, shape (n,)."""
        return self.frozen.batch(self.columns(states))[:, 0]

    def active(self, states: States, previous: BoolArray | None = None) -> BoolArray:
        """Whether it is active, shape (n,); with the previous status the decision has hysteresis."""
        value = self.decide(states)
        if previous is None or self.margin == 0.0:
            return value >= 0.0
        return value >= np.where(previous, -self.margin, 0.0)


def learn_status(
    data: GraphData,
    edge: Interaction,
    alignments: Mapping[Interaction, Alignment | None],
    spec: InteractionSpec,
    noise: Mapping[str, FloatArray],
    affected: Collection[int] = (),
) -> StatusModel:
    """Learn the classifier of one interaction.

    Args:
        data: the pieces.
        edge: the interaction.
        alignments: of all interactions.
        spec: candidate estimators.
        noise: measurement noise per object.
        affected: indices of the child's variables that the interaction changes: what follows from a status does not
            tell it, unless it helps clearly.

    Raises:
        InputError: if no candidate estimator can be fitted and frozen; names the edge and the reason.
    """
    states = {n: data.stacked(n) for n in (edge.child, *data.graph.parents(edge.child))}
    truth, piece = data.flag(edge), data.piece_index()
    ends, others = candidate_inputs(data, edge, alignments)
    values = {id(i): i(states) for i in (*ends, *others)}
    floors = {id(i): input_noise(i, noise) for i in (*ends, *others)}
    fold = interleaved_blocks(piece, _FOLDS)
    # How the rows happen to fall into folds must not choose: several ways of cutting blocks vote.
    cuts = [interleaved_blocks(piece, _FOLDS, length) for length in _BLOCKS]

    def columns(inputs: Sequence[StatusInput]) -> tuple[FloatArray, FloatArray, FloatArray]:
        raw = np.hstack([values[id(i)] for i in inputs])
        offset, scale = input_scales(raw, truth, np.concatenate([floors[id(i)] for i in inputs]))
        return (raw - offset) / scale, offset, scale

    def scored(inputs: Sequence[StatusInput], estimator: EstimatorSpec, folds: Sequence[NDArray[np.intp]]) -> float:
        x = columns(inputs)[0]
        values = [_switching_score(truth, _left_out(estimator, x, truth, f, edge) >= 0.0, piece) for f in folds]
        return float(np.mean(values))

    def score(inputs: Sequence[StatusInput]) -> float:
        return scored(inputs, spec.status_estimators[0], [fold])

    caused = [i for i in ends if isinstance(i, ValueInput) and i.obj == edge.child and i.index in affected]
    causes = [i for i in ends if i not in caused]
    chosen = choose_inputs(causes, [*caused, *others], values, truth, piece, score, floors)
    best, best_score = spec.status_estimators[0], -np.inf
    for candidate in spec.status_estimators:
        value = scored(chosen, candidate, cuts)
        if value > best_score + _CLEARLY:
            best, best_score = candidate, value
    x, offset, scale = columns(chosen)
    frozen = _fit(best, x, truth, edge)
    decisions = _left_out(best, x, truth, _piece_folds(truth, piece), edge)
    by_block = _left_out(best, x, truth, fold, edge)
    margin = _best_margin(by_block, truth, piece)
    held_out = [decisions[piece == k] for k in np.unique(piece)]
    return StatusModel(
        inputs=tuple(chosen),
        offset=offset,
        scale=scale,
        frozen=frozen,
        margin=margin,
        estimator=str(best),
        score=f1(truth, decisions >= 0.0),
        event_score=event_f1([truth[piece == k] for k in np.unique(piece)], [_held(d, margin) for d in held_out]),
        block_score=_switching_score(truth, by_block >= 0.0, piece),
        samples=len(truth),
        positives=int(truth.sum()),
    )


def input_noise(item: StatusInput, noise: Mapping[str, FloatArray]) -> FloatArray:
    """Noise of an input's columns, shape (n_columns,)."""
    if isinstance(item, ValueInput):
        return noise[item.obj][[item.index]]
    if isinstance(item, DifferenceInput):
        return noise[item.child][[item.index[1]]]
    # Along turned axes: the mean over the position's components.
    if isinstance(item, RelativeInput):
        obj, indices, n = item.edge.child, item.alignment.child.indices, len(item.alignment.parent.indices)
    else:
        obj, indices, n = item.obj, item.group.indices, len(item.group.indices)
    return np.full(n, float(np.mean(noise[obj][list(indices)])))


def _fit(estimator: EstimatorSpec, x: FloatArray, y: BoolArray, edge: Interaction) -> FrozenModel:
    try:
        model = freeze(make_classifier(estimator).fit(x, y))
    except (ValueError, TypeError) as error:  # InputError is one
        raise InputError(f"{edge.name}, status: {estimator}: {' '.join(str(error).split())[:300]}") from None
    if model.n_out != 1:
        raise InputError(f"{edge.name}, status: {estimator} gives {model.n_out} decision values; one is needed")
    return model


def _left_out(
    estimator: EstimatorSpec, x: FloatArray, y: BoolArray, fold: NDArray[np.intp], edge: Interaction
) -> FloatArray:
    """Decision value of every row by a classifier that has not seen its fold, shape (n,)."""
    out = np.empty(len(y))
    for k in np.unique(fold):
        test = fold == k
        train = ~test
        if y[train].all() or not y[train].any():
            out[test] = 1.0 if y[train].all() else -1.0
            continue
        out[test] = _fit(estimator, x[train], y[train], edge).batch(x[test])[:, 0]
    return out


def _piece_folds(truth: BoolArray, piece: NDArray[np.intp]) -> NDArray[np.intp]:
    """Folds of whole pieces, positives dealt evenly, shape (n,)."""
    counts = np.bincount(piece, weights=truth)
    loads = np.zeros(min(_FOLDS, len(counts)))
    of_piece = np.zeros(len(counts), dtype=np.intp)
    for rank, k in enumerate(sorted(range(len(counts)), key=lambda k: (-counts[k], k))):
        fold = int(np.argmin(loads)) if counts[k] else rank % len(loads)
        of_piece[k] = fold
        loads[fold] += counts[k]
    return of_piece[piece]


def _switching_score(truth: BoolArray, predicted: BoolArray, piece: NDArray[np.intp]) -> float:
    """Mean of the F1 of the status and that of the events: the status alone flatters, since it rarely changes."""
    parts = np.unique(piece)
    events = event_f1([truth[piece == k] for k in parts], [predicted[piece == k] for k in parts])
    return 0.5 * (f1(truth, predicted) + events)


def _held(decisions: FloatArray, margin: float) -> BoolArray:
    """Status of successive rows with hysteresis, shape (n,)."""
    out = np.empty(len(decisions), dtype=bool)
    on = bool(decisions[0] >= 0.0)
    for k, value in enumerate(decisions):
        on = bool(value >= (-margin if on else 0.0)) if k else on
        out[k] = on
    return out


def _best_margin(decisions: FloatArray, truth: BoolArray, piece: NDArray[np.intp]) -> float:
    parts = np.unique(piece)
    truths = [truth[piece == k] for k in parts]
    scores = [event_f1(truths, [_held(decisions[piece == k], m) for k in parts]) for m in _MARGINS]
    best = int(np.argmax(scores))
    return _MARGINS[best] if scores[best] > scores[0] + _GAIN else 0.0
