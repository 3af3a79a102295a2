"""What is left of an object's motion, and how much more probable an effect makes it: evidence tick by tick."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from ichain_drake.learning.discovery.inputs import is_change
from ichain_drake.learning.discovery.log import Log
from ichain_drake.learning.discovery.settings import DISCOVERY
from ichain_drake.learning.discovery.term import Term
from ichain_drake.learning.settings import LEARNING
from ichain_drake.state import BoolArray, FloatArray, wrap_angle


class Residual:
    """Changes of one object beyond its passive dynamics, tick by tick, and what terms leave of them.

    Args:
        log: the ticks.
        child: the object.
        constants: value to which each variable goes back within a tick, None where it keeps its own.

    Attributes:
        variables: indices of the variables that are explained (a change of an amount follows from it).
        state: at the start of each tick, shape (n_ticks, n_variables).
        lagged: one reading earlier, the same shape.
        values: what is left, the same shape.
        spread: of what is left where nothing acts, the same shape.
        window: length of the means that `values` are [ticks].
    """

    def __init__(self, log: Log, child: str, constants: Mapping[int, float | None]) -> None:
        self.log, self.child, self.constants = log, child, dict(constants)
        space = self.space = log.spaces[child]
        before, after = log.states[child][log.t], log.states[child][log.t + 1]
        self.variables = [i for i in range(len(space)) if i in self.constants]
        self.state, self.lagged = before, log.states[child][log.back]
        change = space.difference(after, before)
        for i, value in self.constants.items():
            if value is not None:
                away = after[:, i] - value
                change[:, i] = wrap_angle(away) if space.angle_mask[i] else away
        noise = log.noise[child]
        readings = np.array([1.0 if self.constants.get(i) is not None else 2.0 for i in range(len(space))])
        self.quiet = np.maximum(noise * np.sqrt(readings), 1e-9)
        span = np.ptp(log.states[child], axis=0)
        self.span = np.maximum(span, 20.0 * self.quiet)  # a range within which an outlier may be
        self.spread = np.tile(self.quiet, (len(log.t), 1))
        self.values = self._first = change
        self.window = 1
        self._silent = self._meaningless(before, after)

    def _meaningless(self, before: FloatArray, after: FloatArray) -> dict[int, BoolArray]:
        """Ticks in which a variable says nothing: an intensive property of what is all but empty."""
        out = {}
        for i in self.variables:
            role = self.space.variables[i].role
            if role is not None and role.kind == "intensive":
                amount = self.space.index(role.of)
                least = LEARNING.empty * self.log.noise[self.child][amount]
                out[i] = (after[:, amount] < least) | (before[:, amount] < least)
        return out

    def telling(self, i: int) -> BoolArray:
        """Ticks in which a variable says something, shape (n_ticks,)."""
        return ~self._silent[i] if i in self._silent else np.ones(len(self.values), dtype=bool)

    def leave(self, terms: Sequence[Term], window: int) -> None:
        """Take away what terms explain, then means over a window of ticks where it is longer than one."""
        left = self._first.copy()
        self.spread = np.tile(self.quiet, (len(left), 1))
        for term in terms:
            left -= term.on[:, None] * term.predicted
            for e in term.effects if term.window == 1 else ():
                acts = term.on & (term.predicted[:, e.variable] != 0)
                self.spread[acts, e.variable] = np.maximum(self.spread[acts, e.variable], e.std)
        self.window = window
        self.values = left if window == 1 else self._means(left, window)

    def _means(self, left: FloatArray, window: int) -> FloatArray:
        """Means over ticks of a piece: the sum of differences of readings over k ticks has one tick's noise."""
        out = np.zeros_like(left)
        piece = self.log.tick_piece
        starts = np.flatnonzero(np.r_[True, piece[1:] != piece[:-1]])
        for a, b in zip(starts, [*starts[1:], len(piece)], strict=True):
            total = np.concatenate([np.zeros((1, left.shape[1])), np.cumsum(left[a:b], axis=0)])
            i = np.arange(b - a)
            low, high = np.maximum(i - window // 2, 0), np.minimum(i + window - window // 2, b - a)
            out[a:b] = (total[high] - total[low]) / (high - low)[:, None]
        for v in self.variables:  # what moves at once needs no means, and what has no memory has none
            role = self.space.variables[v].role
            at_once = role is not None and role.kind in ("position", "orientation", "level")
            if at_once or self.constants[v] is not None:
                out[:, v] = 0.0
        return out

    def clipped(self, change: FloatArray, i: int, ticks: NDArray[np.intp] | slice = slice(None)) -> FloatArray:
        """What bounds leave of a predicted change of a variable, shape (n,), in all ticks or those named."""
        if self.space.angle_mask[i]:
            return change
        low, high = self.space.lower[i], self.space.upper[i]
        value = self.constants[i]
        if value is not None:
            return np.clip(change, low - value, high - value)
        # A reading within its noise of a bound stands there: what is left of the way would be that reading's own noise.
        below, above = (w * (np.abs(w) > LEARNING.clear * self.quiet[i]) for w in self._ways(low, high, i, ticks))
        return np.clip(change, below, above)

    def _ways(self, low: float, high: float, i: int, ticks: NDArray[np.intp] | slice) -> tuple[FloatArray, FloatArray]:
        """How far a variable may go down and up, shape (n,) each."""
        now = self.state[ticks, i]
        most = np.full(len(now), np.finfo(float).max)
        down = np.minimum(low - now, 0.0) if np.isfinite(low) else -most
        return down, np.maximum(high - now, 0.0) if np.isfinite(high) else most

    def evidence(self, change: FloatArray, i: int, std: float) -> FloatArray:
        """Log-likelihood ratio of a predicted change of a variable in each tick, clipped, shape (n_ticks,) [nat].

        Args:
            change: predicted, shape (n_ticks,).
            i: index of the variable.
            std: of what it leaves.
        """
        quiet, span = self.spread[:, i] / self.window, self.span[i] / self.window
        left = self.values[:, i]
        # Of means, whose spread is not read but follows from one tick's, the same spread for both: an effect has to
        # predict them better, and not merely to be vaguer.
        acting = np.where(change == 0, quiet, np.maximum(std, quiet))
        ratio = np.log(_density(left - change, acting, span, DISCOVERY.outliers))
        ratio -= np.log(_density(left, quiet if self.window == 1 else acting, span, DISCOVERY.outliers))
        ratio = np.where(self.telling(i), ratio / self.window, 0.0)
        return np.asarray(np.clip(ratio, -DISCOVERY.clip, DISCOVERY.clip))

    def log_likelihood(self, i: int) -> float:
        """Of a variable's residuals if nothing acts [nat]."""
        density = _density(self.values[:, i], self.quiet[i], self.span[i], DISCOVERY.outliers)
        return float(np.log(density).sum())


def _density(left: FloatArray, std: FloatArray | float, span: float, outliers: float) -> FloatArray:
    """Of a residual: normal, or anywhere within the range once in a while."""
    normal = np.exp(-0.5 * (left / std) ** 2) / (std * np.sqrt(2.0 * np.pi))
    return np.asarray((1.0 - outliers) * normal + outliers / span)


def observed(log: Log, child: str) -> list[int]:
    """Indices of the variables whose changes have to be explained."""
    return [i for i in range(len(log.spaces[child])) if not is_change(log.spaces[child], i)]
