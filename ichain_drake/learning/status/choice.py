"""Choice of a status classifier's inputs.

Variables that only differ between pieces (how full a tank happened to be) look discriminative and are not. So an input
counts as evidence where it separates active from inactive rows *within* single pieces. Inputs that are narrow while
active are all taken: they keep the classifier from extrapolating.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from ichain_drake.learning.data import BoolArray
from ichain_drake.learning.status.inputs import PlaceInput, RelativeInput, StatusInput
from ichain_drake.state import FloatArray

_QUANTILES = (0.03, 0.97)
_LEAST = 3  # rows of each sort for a piece to say anything
_NOISES = 3.0
_OUTSIDE = 0.15  # share of a piece's inactive rows that an input must put outside the range of the active ones
_PIECES = 0.6  # share of the pieces in which it must
_NARROW = 0.5  # range while active, as a share of the whole range
_ENOUGH = 0.01  # difference of the score that counts
_WORTH = 0.1  # gain of the score for an input that is not narrow: a few events more or less are no evidence
_MOST_EXTRA = 3


def input_scales(raw: FloatArray, truth: BoolArray, floor: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Offset and scale of columns: the middle of the active rows, and between their spread and that of all.

    Args:
        raw: shape (n, n_columns).
        truth: status, shape (n,).
        floor: noise of each column, shape (n_columns,).
    """
    offset = np.median(raw[truth], axis=0)
    everywhere = np.maximum(raw.std(axis=0), 1e-9)
    inside = np.maximum(raw[truth].std(axis=0), 2.0 * floor)
    inside = np.where(inside > 1e-6 * everywhere, inside, everywhere)
    return offset, np.sqrt(inside * np.maximum(everywhere, inside))


def choose_inputs(
    ends: Sequence[StatusInput],
    others: Sequence[StatusInput],
    values: Mapping[int, FloatArray],
    truth: BoolArray,
    piece: NDArray[np.intp],
    score: Callable[[Sequence[StatusInput]], float],
    floors: Mapping[int, FloatArray],
) -> list[StatusInput]:
    """Choose inputs.

    Args:
        ends: inputs from the two ends of the interaction.
        others: further inputs, such as of the child's other parents; taken only if they help.
        values: columns of each input by `id`, shape (n, k).
        truth: status of each row, shape (n,).
        piece: piece of each row, shape (n,).
        score: cross-validated score of a set of inputs, higher is better.
        floors: noise of the columns of each input by `id`, shape (k,).
    """
    evidence = [i for i in ends if separates(values[id(i)], truth, piece, floors[id(i)])]
    chosen = [i for i in evidence if is_narrow(values[id(i)], truth)]
    best = score(chosen) if chosen else -np.inf
    if any(isinstance(i, RelativeInput) for i in chosen):
        # Where two things must be relative to each other, where both happen to be is a matter of the demonstrations.
        without: list[StatusInput] = [i for i in chosen if not isinstance(i, PlaceInput)]
        if len(without) < len(chosen):
            value = score(without)
            if value > best - _ENOUGH:
                chosen, best = without, value
    further = [i for i in evidence if i not in chosen]
    further += [i for i in others if separates(values[id(i)], truth, piece, floors[id(i)])]
    if not chosen and not further:
        further = [*ends, *others]
    for _ in range(_MOST_EXTRA):
        if best >= 1.0 - _ENOUGH or not further:
            break
        scores = [score([*chosen, i]) for i in further]
        k = int(np.argmax(scores))
        if scores[k] < best + _WORTH:
            break
        chosen, best = [*chosen, further.pop(k)], scores[k]
    return chosen


def separates(columns: FloatArray, truth: BoolArray, piece: NDArray[np.intp], floor: FloatArray) -> bool:
    """Whether an input tells active from inactive rows, by more than noise, within most pieces that show both."""
    total = hits = 0
    for k in np.unique(piece):
        on, off = columns[(piece == k) & truth], columns[(piece == k) & ~truth]
        if len(on) < _LEAST or len(off) < _LEAST:
            continue
        total += 1
        low, high = np.quantile(on, _QUANTILES, axis=0)
        slack = 1e-9 + 0.05 * (high - low) + _NOISES * floor
        outside = ((off < low - slack) | (off > high + slack)).any(axis=1).mean()
        hits += bool(outside > _OUTSIDE)
    return total > 0 and hits >= max(1.0, _PIECES * total)


def is_narrow(columns: FloatArray, truth: BoolArray) -> bool:
    """Whether the range while active is small against the whole range, on average over the columns."""
    inside = np.diff(np.quantile(columns[truth], _QUANTILES, axis=0), axis=0)[0]
    whole = np.maximum(np.diff(np.quantile(columns, _QUANTILES, axis=0), axis=0)[0], 1e-12)
    return float(np.exp(np.mean(np.log(np.maximum(inside / whole, 1e-3))))) < _NARROW
