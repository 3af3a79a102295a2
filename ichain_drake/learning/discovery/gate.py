"""Gates: the box on some inputs within which the summed evidence for an effect is largest, less a price per face."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ichain_drake.learning.discovery.inputs import GateInputs
from ichain_drake.learning.discovery.settings import DISCOVERY
from ichain_drake.learning.settings import LEARNING
from ichain_drake.state import BoolArray, FloatArray


@dataclass(frozen=True, eq=False)
class Gate:
    """`low <= inputs <= high`; infinite where there is no face, shape (n_inputs,)."""

    low: FloatArray
    high: FloatArray

    def holds(self, values: FloatArray) -> BoolArray:
        """Rows inside, shape (n,), of values of shape (n, n_inputs)."""
        return np.asarray(((values >= self.low) & (values <= self.high)).all(axis=1))

    @property
    def used(self) -> BoolArray:
        """Inputs with a face, shape (n_inputs,)."""
        return np.asarray(np.isfinite(self.low) | np.isfinite(self.high))

    @property
    def faces(self) -> int:
        """How many there are."""
        return int(np.isfinite(self.low).sum() + np.isfinite(self.high).sum())


@dataclass(frozen=True)
class _Move:
    """New bounds of one input as positions in its sorted values; None for no face."""

    value: float
    index: int
    low: int | None
    high: int | None


class GateSearch:
    """Coordinate ascent over boxes: each step gives one input the interval that is best with all other faces kept.

    The best interval of one input is the maximum subarray of the evidence sorted by it, in one pass (Kadane); all
    inputs are tried at once.

    Args:
        inputs: of the gate.
        free: objects that cost nothing.
        other_object: price of any other [nat].
    """

    def __init__(self, inputs: GateInputs, free: Collection[str], other_object: float) -> None:
        self._values = inputs.values
        self._price = np.array([i.price for i in inputs.items])
        self._owner = [i.owner for i in inputs.items]
        self._free, self._other = set(free), other_object
        self._order: NDArray[np.intp] = np.argsort(inputs.values, axis=0, kind="stable").T
        self._sorted = np.take_along_axis(inputs.values.T, self._order, 1)
        last = np.ones((len(self._sorted), 1), dtype=bool)
        self._cut = np.concatenate([self._sorted[:, 1:] > self._sorted[:, :-1], last], axis=1)

    def __call__(self, evidence: FloatArray, usable: BoolArray) -> tuple[Gate, float]:
        """The best gate and its value [nat].

        Args:
            evidence: of each row for being inside, shape (n,) [nat].
            usable: inputs that may have faces, shape (n_inputs,).
        """
        n = len(usable)
        open_gate = Gate(np.full(n, -np.inf), np.full(n, np.inf))
        if evidence.max(initial=0.0) <= 0 or not usable.any():
            return open_gate, float(evidence.sum())
        gate, value, ranked = self._ascend(evidence, usable, None)
        results = [(gate, value)]
        seen: set[int] = set()
        for move in ranked:
            if move.value <= 0 or len(seen) >= DISCOVERY.starts:
                break
            if move.index not in seen:
                seen.add(move.index)
                results.append(self._ascend(evidence, usable, move)[:2])
        return max(results, key=lambda r: r[1])

    def _ascend(self, evidence: FloatArray, usable: BoolArray, first: _Move | None) -> tuple[Gate, float, list[_Move]]:
        n = len(usable)
        low, high = np.full(n, -np.inf), np.full(n, np.inf)
        best, ranked = float(evidence.sum()), None
        for _ in range(LEARNING.sweeps):
            moves, weights = self._moves(evidence, usable, low, high)
            if ranked is None:
                faced = [m for m in moves if m.low is not None or m.high is not None]
                ranked = sorted(faced, key=lambda m: -m.value)
                if first is not None:
                    ours = (first.index, first.low, first.high)
                    moves = [m for m in moves if (m.index, m.low, m.high) == ours]
            move = max(moves, key=lambda m: m.value)
            if move.value <= best + 1e-6 and (first is None or np.isfinite([low, high]).any()):
                break
            best, j = move.value, move.index
            low[j] = -np.inf if move.low is None else _lower_face(self._sorted[j], weights[j], move.low)
            high[j] = np.inf if move.high is None else _upper_face(self._sorted[j], weights[j], move.high)
        return Gate(low, high), best, ranked or []

    def _moves(
        self, evidence: FloatArray, usable: BoolArray, low: FloatArray, high: FloatArray
    ) -> tuple[list[_Move], FloatArray]:
        inside = (self._values >= low) & (self._values <= high)
        outside = (~inside).sum(axis=1)
        others = outside[:, None] == ~inside  # inside all other faces
        weights = np.take_along_axis(np.where(others, evidence[:, None], 0.0).T, self._order, 1)
        total = np.cumsum(weights, axis=1)
        start = np.zeros((len(total), 1))
        before = np.concatenate([start, np.where(self._cut[:, :-1], total[:, :-1], np.inf)], axis=1)
        both = np.where(self._cut, total - np.minimum.accumulate(before, axis=1), -np.inf)
        upper = np.where(self._cut, total, -np.inf)
        lower = np.where(np.isfinite(before), total[:, -1:] - before, -np.inf)
        ends = upper.argmax(axis=1), lower.argmax(axis=1), both.argmax(axis=1)
        faces = np.isfinite(low).astype(int) + np.isfinite(high)
        paid = float((self._price * faces).sum())
        moves = []
        for j in np.flatnonzero(usable):
            looked_at = {self._owner[k] for k in np.flatnonzero(faces) if k != j} - self._free
            base = paid - self._price[j] * faces[j]
            without = base + self._other * len(looked_at)
            with_it = base + self._other * len(looked_at | ({self._owner[j]} - self._free))
            face = float(self._price[j])
            up, down, top = (int(k[j]) for k in ends)
            bottom = int(np.argmin(before[j, : top + 1]))
            moves += [
                _Move(float(total[j, -1]) - without, int(j), None, None),
                _Move(float(upper[j, up]) - with_it - face, int(j), None, up),
                _Move(float(lower[j, down]) - with_it - face, int(j), down, None),
                _Move(float(both[j, top]) - with_it - 2 * face, int(j), bottom, top),
            ]
        return moves, weights


def _upper_face(values: FloatArray, evidence: FloatArray, k: int) -> float:
    """Into the middle between the last row that speaks for it and the next that speaks against, not far into a gap."""
    speaking = np.flatnonzero(evidence[: k + 1] > DISCOVERY.speaks)
    a, first = (values[speaking[-1]], values[speaking[0]]) if len(speaking) else (values[k], values[k])
    against = np.flatnonzero(evidence[k + 1 :] < -DISCOVERY.speaks)
    b = values[k + 1 + against[0]] if len(against) else values[min(k + 1, len(values) - 1)]
    return _within(float(a), float(b), float(first))


def _lower_face(values: FloatArray, evidence: FloatArray, k: int) -> float:
    speaking = k + np.flatnonzero(evidence[k:] > DISCOVERY.speaks)
    a, first = (values[speaking[0]], values[speaking[-1]]) if len(speaking) else (values[k], values[k])
    against = np.flatnonzero(evidence[:k] < -DISCOVERY.speaks)
    b = values[against[-1]] if len(against) else values[max(k - 1, 0)]
    return _within(float(a), float(b), float(first))


def _within(a: float, b: float, first: float) -> float:
    reach = LEARNING.reach * abs(a - first) if a != first else np.inf
    return float(a + np.clip(0.5 * (b - a), -reach, reach))
