"""A place relative to another object in place of a place: the prior of roles where demonstrations can't tell."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np
from numpy.typing import NDArray

from ichain_drake.learning.selection import by_part
from ichain_drake.learning.settings import LEARNING
from ichain_drake.learning.status.choice import Candidate, InputChoice
from ichain_drake.learning.status.inputs import PlaceInput, RelativeInput, objects_of
from ichain_drake.state import FloatArray


def relative_if_as_good(
    choice: InputChoice, chosen: Sequence[Candidate], candidates: Sequence[Candidate]
) -> tuple[list[Candidate], list[Candidate]]:
    """The place of one end relative to the other in place of its place, where it is not surely worse.

    What is beside the other wherever that is can't be told from what is at a place while the other stays there: the
    roles say which of the two holds elsewhere. Beside a relative place of what doesn't move along, a place of an end
    would say once more, along other axes, what was shown while the other stood: it is left out, unless it clearly tells
    more.

    Args:
        choice: of the inputs.
        chosen: inputs so far.
        candidates: all of them.

    Returns:
        The inputs, and the candidates that are left.
    """
    out = list(chosen)
    if any(isinstance(c.item, RelativeInput) for c in out):
        # Taken first, a relative place may leave each end too little to tell by itself, where both tell more.
        places = choice.choose([c for c in candidates if not isinstance(c.item, RelativeInput)])
        if choice.clear(by_part(choice.left_out(places) - choice.left_out(out), choice.piece)):
            out = places
    for relative in candidates:
        if not isinstance(relative.item, RelativeInput):
            continue
        ends = objects_of(relative.item)
        others = [[*out[:k], relative, *out[k + 1 :]] for k, c in enumerate(out) if _is_place(c, ends)]
        if others and relative not in out:
            other = max(others, key=lambda inputs: float(choice.left_out(inputs).sum()))  # in place of either end's
            gains = by_part(choice.left_out(out) - choice.left_out(other), choice.piece)
            out = out if gains.sum() > LEARNING.sure * np.sqrt(np.sum(gains**2)) else other
        if relative in out and not relative.item.alignment.rows and any(_is_place(c, ends) for c in out):
            fewer = beside_relative([relative], candidates)
            found = choice.choose(fewer)
            if not choice.clear(by_part(choice.left_out(out) - choice.left_out(found), choice.piece)):
                return found, fewer
    return out, list(candidates)


def beside_relative(chosen: Sequence[Candidate], candidates: Sequence[Candidate]) -> list[Candidate]:
    """Candidates that are no place of an end of a chosen relative place, where the one doesn't move along."""
    found = [c.item for c in chosen if isinstance(c.item, RelativeInput) and not c.item.alignment.rows]
    ends = {name for item in found for name in objects_of(item)}
    return [c for c in candidates if not _is_place(c, ends)]


def _is_place(candidate: Candidate, objects: Collection[str]) -> bool:
    return isinstance(candidate.item, PlaceInput) and candidate.item.obj in objects


def rested(values: FloatArray, piece: NDArray[np.intp], noise: FloatArray) -> FloatArray:
    """Readings, shape (n, n_variables), with their mean over the rows around each in place of what stands still.

    Args:
        values: readings, shape (n, n_variables).
        piece: piece of each row, shape (n,).
        noise: standard deviation of a reading, shape (n_variables,).
    """
    out = values.copy()
    for k in np.unique(piece):
        rows = np.flatnonzero(piece == k)
        around = np.arange(-LEARNING.look, LEARNING.look + 1)
        index = rows[np.clip(np.arange(len(rows))[:, None] + around, 0, len(rows) - 1)]
        near = values[index]
        still = (np.abs(near - np.median(near, axis=1, keepdims=True)) <= LEARNING.surely * noise).all(axis=1)
        out[rows] = np.where(still, near.mean(axis=1), values[rows])
    return out
