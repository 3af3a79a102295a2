"""Choice of a status model's inputs: forward selection by what each adds to the likelihood of what was left out.

The evidence for a further input is conditional on what is chosen already: it must tell apart rows of which the chosen
inputs can't say whether the interaction is active. Pieces that are about other conditions then add evidence of zero,
never against. Variables that only differ between pieces (how full a tank happened to be) look discriminative and are
not: a whole piece is left out at a time, and a gain counts by pieces (see `selection.clearly`).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ichain_drake.learning.selection import borne_out, by_part, clearly, least_slip, log_probability
from ichain_drake.learning.settings import LEARNING
from ichain_drake.learning.status.box import BoxClassifier
from ichain_drake.learning.status.inputs import StatusInput
from ichain_drake.state import BoolArray, FloatArray


@dataclass(frozen=True, eq=False)
class Candidate:
    """An input that may be chosen.

    Attributes:
        item: the input.
        values: its columns, shape (n, k).
        noise: standard deviation of a reading of each column, shape (k,).
        caused: whether the interaction itself changes it. It then can't be what switches the interaction on in rows
            after the first: only rows before which it was inactive are evidence, with `values` of the row before.
    """

    item: StatusInput
    values: FloatArray
    noise: FloatArray
    caused: bool = False


class InputChoice:
    """The choice of inputs of one interaction.

    Args:
        truth: status of each row, shape (n,).
        piece: piece of each row, shape (n,).
        fold: rows that are left out together, shape (n,).
        begins: rows before which the interaction was inactive, shape (n,).
    """

    def __init__(self, truth: BoolArray, piece: NDArray[np.intp], fold: NDArray[np.intp], begins: BoolArray) -> None:
        self.truth, self.piece, self.fold, self.begins = truth, piece, fold, begins
        self.slip = least_slip(truth)
        # Two searches, and each step of one, ask about the same inputs again: a box is small, so all are kept.
        self._stays: dict[Candidate, BoolArray] = {}
        self._boxes: dict[tuple[tuple[Candidate, ...], bool, bool], list[tuple[int | None, BoxClassifier]]] = {}

    def choose(self, candidates: Sequence[Candidate]) -> list[Candidate]:
        """Inputs to look at, in the order in which they were found; empty if none tells anything.

        Args:
            candidates: the likelier ones by their roles first: of those that are not clearly worse than the best, the
                first is taken. What the interaction changes comes last, for what is left to be told.
        """
        likely, best = (self._searched(candidates, by_role=by_role) for by_role in (True, False))
        gains = by_part(self.left_out(best) - self.left_out(likely), self.piece)
        return best if clearly(gains, 2) else likely

    def _searched(self, candidates: Sequence[Candidate], *, by_role: bool) -> list[Candidate]:
        """One greedy search, which may end where another does better: by role, or by what adds most at each step.

        What one adds is a sum over the stays of what is looked at. By role each counts by its own; else two are
        compared over the stays of both.
        """
        chosen: list[Candidate] = []
        for caused in (False, True):
            while found := self._further(
                chosen, [c for c in candidates if c.caused == caused and c not in chosen], by_role=by_role
            ):
                chosen += found
        # Where one is told by the others, what goes is what is missed least. That may be another: added to mend some of
        # what this one left, it may tell by chance most of what this one tells.
        while len(chosen) > 1:
            gains = [self._gains([c for c in chosen if c is not item], (item,)) for item in chosen]
            if all(self.clear(g, len(candidates)) for g in gains):
                break
            del chosen[int(np.argmin([g.sum() for g in gains]))]
        return self._exchanged(chosen, candidates, by_role=by_role)

    def _exchanged(
        self, chosen: Sequence[Candidate], candidates: Sequence[Candidate], *, by_role: bool
    ) -> list[Candidate]:
        """Each input that was found before others were known, or what tells more now that they are.

        Where one thing stands may tell pieces about it from pieces about a switch; of the rows in which the switch is
        pressed another thing's place may be what tells.
        """
        out = list(chosen)
        for k, item in enumerate(out[:-1]):
            others = [c for c in out if c is not item]
            free = [c for c in candidates if not c.caused and c not in others]
            found = [] if item.caused else self._further(others, free, by_role=by_role)
            if len(found) == 1 and found[0] is not item:
                other = [*out[:k], *found, *out[k + 1 :]]
                more = (self.left_out(other) - self.left_out(out)) * self._share([*out, *found])
                out = other if more.sum() > 0.0 else out
        return out

    def open(self, chosen: Sequence[Candidate], candidates: Sequence[Candidate]) -> list[Candidate]:
        """What adds more than chance to a choice, though not clearly: boxes can't tell; those that add most first.

        Args:
            chosen: the choice.
            candidates: all of them.
        """
        chance = float(np.log(len(candidates)))
        free = [c for c in candidates if c not in chosen and not c.caused]
        # What hardly adds anything where it was seen is not tried on what was left out, which costs a fit a fold.
        free = [c for c in free if self._gains(chosen, (c,), seen=True).sum() > chance]
        gains = [float(self._gains(chosen, (c,)).sum()) for c in free]
        order = np.argsort(-np.array(gains), kind="stable")
        return [free[k] for k in order if gains[k] > chance]

    def tells(self, candidate: Candidate) -> bool:
        """Whether an input by itself clearly tells some rows in which the interaction is inactive."""
        return clearly(self._gains([], (candidate,)))

    def clear(self, gains: FloatArray, tried: int = 1) -> bool:
        """Whether an input that is one of several clearly adds something: more than one wrong flag would make up.

        Args:
            gains: what it adds to the log-likelihood of each piece, shape (n_pieces,).
            tried: how many inputs it was picked from.
        """
        return borne_out(gains, tried) and self._pays(float(gains.sum()))

    def _pays(self, gain: float) -> bool:
        """Whether a gain is more than one wrong flag would make up."""
        return gain > -np.log(self.slip)

    def _further(self, chosen: Sequence[Candidate], free: Sequence[Candidate], *, by_role: bool) -> list[Candidate]:
        """The next input, if one clearly adds something; two, if only both together do; else none.

        Of two conditions that only differ where both do, each alone may leave a piece unlike all others. That what is
        seen tells more than what is left out shows it.
        """
        bounds = [float(self._gains(chosen, (c,), seen=True).sum()) for c in free]
        one = self._best(chosen, [(c,) for c in free], bounds, len(free), by_role=by_role)
        if one or any(c.caused for c in free):
            return one
        pairs = list(itertools.combinations([c for c, b in zip(free, bounds, strict=True) if self._pays(b)], 2))
        bounds = [float(self._gains(chosen, pair, seen=True).sum()) for pair in pairs]
        return self._best(chosen, pairs, bounds, math.comb(len(free), 2), by_role=by_role)

    def _best(
        self,
        chosen: Sequence[Candidate],
        free: Sequence[tuple[Candidate, ...]],
        bounds: Sequence[float],
        tried: int,
        *,
        by_role: bool,
    ) -> list[Candidate]:
        """Of inputs that clearly add something, the ones that add most or are the likeliest by their roles; or none."""
        # What a fit adds on the rows that it has seen bounds what it adds on others.
        gains = {k: self._gains(chosen, free[k]) for k, bound in enumerate(bounds) if self._pays(bound)}
        clear = [k for k in gains if self.clear(gains[k], tried)]
        if not clear:
            return []
        if by_role:
            top = max(clear, key=lambda k: gains[k].sum())
            return list(free[next(k for k in clear if k == top or not clearly(gains[top] - gains[k]))])
        top = clear[0]
        for k in clear[1:]:
            top = k if self._more(chosen, free[k], free[top]).sum() > 0.0 else top
        return list(free[top])

    def _more(self, chosen: Sequence[Candidate], one: Sequence[Candidate], other: Sequence[Candidate]) -> FloatArray:
        """What some inputs add to the log-likelihood of each piece more than others, over the stays of both."""
        onset = one[0].caused
        more, less = (self._likelihood((*chosen, *c), onset=onset, seen=False) for c in (one, other))
        rows = self._rows(onset=onset)
        return by_part((more - less) * self._share((*chosen, *one, *other))[rows], self.piece[rows])

    def _gains(self, chosen: Sequence[Candidate], further: Sequence[Candidate], *, seen: bool = False) -> FloatArray:
        """What further inputs add to the log-likelihood of each piece, shape (n_pieces,), left out or seen."""
        onset = further[0].caused
        gain = self._likelihood((*chosen, *further), onset=onset, seen=seen) - self._likelihood(
            tuple(chosen), onset=onset, seen=seen
        )
        rows = self._rows(onset=onset)
        return by_part(gain * self._share((*chosen, *further))[rows], self.piece[rows])

    def _share(self, looked: Sequence[Candidate]) -> FloatArray:
        """What each row counts, shape (n,): readings of one state, again and again, are one observation of its flag."""
        begins = np.any([self._moved(c) for c in looked], axis=0)
        stay = np.cumsum(begins) - 1
        return np.asarray(1.0 / np.bincount(stay)[stay])

    def _moved(self, candidate: Candidate) -> BoolArray:
        """Whether an input, or the flag, or the piece is another one than where the row's stay began, shape (n,)."""
        if candidate not in self._stays:
            near = LEARNING.clear * np.sqrt(2.0) * candidate.noise
            out = np.ones(len(self.truth), dtype=bool)
            out[1:] = (self.truth[1:] != self.truth[:-1]) | (self.piece[1:] != self.piece[:-1])
            starts = np.flatnonzero(out)
            spread = np.maximum.reduceat(candidate.values, starts) - np.minimum.reduceat(candidate.values, starts)
            ends = np.append(starts[1:], len(out))
            limits = near.tolist()
            wide = (spread > near).any(axis=1)  # all else stays as it is
            for start, end in zip(starts[wide].tolist(), ends[wide].tolist(), strict=True):
                rows = candidate.values[start:end].tolist()
                first = rows[0]
                for i, value in enumerate(rows):
                    if any(abs(a - b) > n for a, b, n in zip(value, first, limits, strict=True)):
                        first, out[start + i] = value, True
            self._stays[candidate] = out
        return self._stays[candidate]

    def left_out(self, chosen: Sequence[Candidate]) -> FloatArray:
        """Log-likelihood of each row's flag, shape (n,), by a box that has not seen its fold."""
        return self._likelihood(tuple(chosen), onset=False, seen=False)

    def _rows(self, *, onset: bool) -> NDArray[np.intp]:
        """Rows that are evidence: all, or those before which the interaction was inactive."""
        return np.flatnonzero(self.begins) if onset else np.arange(len(self.truth))

    def _likelihood(self, chosen: tuple[Candidate, ...], *, onset: bool, seen: bool) -> FloatArray:
        """Log-likelihood of rows by a box that has not seen their fold, or has seen all, shape (n_rows,)."""
        rows = self._rows(onset=onset)
        truth = self.truth[rows]
        out = log_probability(truth, np.ones(len(rows)), self.slip)
        if not chosen:
            return out
        x = np.hstack([c.values[rows] for c in chosen])
        if (chosen, onset, seen) not in self._boxes:
            self._boxes[chosen, onset, seen] = list(self._fitted(chosen, x, rows, seen=seen))
        for test, box in self._boxes[chosen, onset, seen]:
            of = slice(None) if test is None else self.fold[rows] == test
            out[of] = box.log_likelihood(x[of], truth[of], self.slip)
        return out

    def _fitted(
        self, chosen: tuple[Candidate, ...], x: FloatArray, rows: NDArray[np.intp], *, seen: bool
    ) -> Iterator[tuple[int | None, BoxClassifier]]:
        """Boxes, each with the fold that it has not seen, if any."""
        truth, fold = self.truth[rows], self.fold[rows]
        noise = np.concatenate([c.noise for c in chosen])
        for test in (None,) if seen else np.unique(fold).tolist():
            train = np.ones(len(rows), dtype=bool) if test is None else fold != test
            if truth[train].any() and not truth[train].all():
                yield test, BoxClassifier(noise=noise, partial=True).fit_flags(x[train], truth[train])


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
