"""How likely a log was reset between two rows: several objects are at once where their own motion doesn't bring them.

Either everything goes on: each object changes as it does in this log, by noise, or by one of its usual motions. Or the
scene was set up anew: objects are anywhere within their ranges, whatever they were before. Both are fitted to the same
rows in turns (EM), so that what an object does often counts as its motion, however far it goes.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import expit

from ichain_drake.learning.discovery.inputs import is_change
from ichain_drake.learning.discovery.settings import DISCOVERY
from ichain_drake.learning.noise import HALF_NORMAL, change_noise
from ichain_drake.learning.settings import LEARNING
from ichain_drake.state import BoolArray, FloatArray, StateSpace, wrap_angle

_PLACES = ("position", "orientation", "amount")


@dataclass(frozen=True, eq=False)
class Resets:
    """What was found in the ticks of one stretch of a log.

    Attributes:
        probability: that the log was reset within a tick, shape (n_rows - 1,).
        jumped: per object whether it is likelier to have been set anew than to have gone on, shape (n_rows - 1,).
    """

    probability: FloatArray
    jumped: Mapping[str, BoolArray]


def find_resets(stretches: Sequence[Mapping[str, FloatArray]], spaces: Mapping[str, StateSpace]) -> list[Resets]:
    """Resets within stretches of logs, by the motions of each object in all of them.

    Args:
        stretches: per object states at successive ticks, shape (n_rows, n_variables); each holds some of the objects.
        spaces: observable state space per object.
    """
    ticks = [max(len(next(iter(s.values()))) - 1, 0) for s in stretches]
    ends = np.cumsum([0, *ticks])
    motions: list[tuple[_Motion, FloatArray]] = []
    for name, space in spaces.items():
        having = [k for k, s in enumerate(stretches) if name in s and ticks[k]]
        motion = _Motion(name, space, [stretches[k][name] for k in having]) if having else None
        if motion is not None and motion.variables:
            motions.append((motion, np.concatenate([np.arange(ends[k], ends[k + 1]) for k in having])))
    probability = np.zeros(ends[-1])
    share = DISCOVERY.outliers
    settled = not motions
    for _ in range(LEARNING.sweeps):
        if settled:
            break
        total = np.full(ends[-1], np.log(share / (1.0 - share)))
        for motion, at in motions:
            total[at] += motion.ratio()
        before, probability = probability, expit(total)
        for motion, at in motions:
            motion.count(probability[at])
            motion.fit(1.0 - probability[at])
        share = float((probability.sum() + 1.0) / (len(probability) + 1.0 / DISCOVERY.outliers))
        if np.abs(probability - before).max() < LEARNING.surprise:
            settled = not any([motion.settle() for motion, _ in motions])
    jumped = {m.name: np.zeros(ends[-1], dtype=bool) for m, _ in motions}
    for motion, at in motions:
        jumped[motion.name][at] = motion.ratio() > 0
    return [
        Resets(probability[a:b], {n: j[a:b] for n, j in jumped.items()})
        for a, b in zip(ends[:-1], ends[1:], strict=True)
    ]


class _Motion:
    """Changes of one object within a tick: a mixture of normals about none, each with some variables that move.

    Some objects jump anywhere by themselves, as a stick that is thrown about: that is a kind of change, too, and no
    reset. It is one if several do so at once that otherwise don't.

    Args:
        name: of the object.
        space: its observable state space.
        parts: states, one array a stretch.

    Attributes:
        variables: indices of those that are looked at. What switches does so without a reset, and tells nothing.
    """

    def __init__(self, name: str, space: StateSpace, parts: Sequence[FloatArray]) -> None:
        self.name = name
        every = np.vstack(parts)
        before, after = np.vstack([p[:-1] for p in parts]), np.vstack([p[1:] for p in parts])
        span = np.ptp(every, axis=0)
        self.variables = [i for i in range(len(space)) if span[i] > 0 and _tells(space, i)]
        noise = change_noise(space, parts)
        self._change = space.difference(after, before)[:, self.variables]
        self._quiet = 2.0 * noise[self.variables] ** 2
        self._telling = _telling(space, noise, before, after)[:, self.variables]
        self._span = span[self.variables]
        self._uniform = -(self._telling @ np.log(self._span))
        self._loud = (self._change**2 > LEARNING.surely**2 * self._quiet) & self._telling
        self._home = self._returns(after[:, self.variables], space.angle_mask[self.variables])
        self._anew = np.logaddexp(self._uniform, self._home) - np.log(2.0)
        self._variance, self._weight = self._start()
        self._never = np.zeros(len(self._weight), dtype=bool)  # kinds of change that it turned out not to have
        self._jumps = 0.5  # in a reset an object is rather set anew than not, whatever was seen
        self._goes_on = np.logaddexp.reduce(self._log_density(), axis=1)

    def _returns(self, after: FloatArray, angle: BoolArray) -> FloatArray:
        """Log-density of coming back at once to where it came before, shape (n_ticks,): a spring, a latch, a lid."""
        out = np.full(len(after), -np.inf)
        jumps = np.flatnonzero((np.abs(self._change) > LEARNING.reach * self._span).any(axis=1))[: LEARNING.most_rows]
        for k in jumps if len(jumps) > LEARNING.few else ():
            away = after[jumps[jumps != k]] - after[k]
            away = np.where(angle, wrap_angle(away), away)
            each = -0.5 * (away**2 / self._quiet + np.log(2.0 * np.pi * self._quiet))
            out[k] = np.logaddexp.reduce((each * self._telling[k]).sum(axis=1)) - np.log(len(away))
        return out

    def _start(self) -> tuple[FloatArray, FloatArray]:
        """Variances of each kind of change, shape (n_kinds, n_variables): rest, usual motions, any motion; weights.

        The last two weights, of returns and of jumps anywhere, have no variance.
        """
        square, kinds, counts = self._change**2, [self._quiet], [1.0]
        for pattern, count in Counter(map(tuple, self._loud.tolist())).most_common(DISCOVERY.most_terms):
            rows = (self._loud == np.array(pattern)).all(axis=1)
            kinds.append(np.median(square[rows], axis=0) / HALF_NORMAL**2)
            counts.append(float(count))
        weight = np.r_[counts, 1.0] / sum(counts, 1.0)
        every = np.maximum(np.array([*kinds, self._quiet]), self._quiet)
        return every, np.r_[weight * (1.0 - 2.0 * DISCOVERY.outliers), DISCOVERY.outliers, DISCOVERY.outliers]

    def fit(self, keep: FloatArray) -> None:
        """Fit the motions to ticks that are so likely to go on, shape (n_ticks,)."""
        loud = self._loud * keep[:, None]
        square, quiet = self._change**2, self._quiet
        # Any motion: a variable may move as far as it does elsewhere, whichever others move with it.
        self._variance[-1] = np.maximum((loud * square).sum(axis=0) / np.maximum(loud.sum(axis=0), 1e-9), quiet)
        each = self._log_density()
        part = np.exp(each - np.logaddexp.reduce(each, axis=1)[:, None]) * keep[:, None]
        self._weight = np.maximum(part.sum(axis=0), np.finfo(float).tiny) / max(float(part.sum()), 1.0)
        self._weight[self._never] = DISCOVERY.outliers**2
        part = part[:, : len(self._variance) - 1]
        moved = part.T @ (square * self._telling) + self._variance[:-1]
        self._variance[:-1] = np.maximum(moved / (part.T @ self._telling + 1.0), quiet)
        self._goes_on = np.logaddexp.reduce(self._log_density(), axis=1)

    def settle(self) -> bool:
        """Whether it turns out only now that it never jumps by itself: who does it at all does so often."""
        far = np.sqrt(self._variance) > LEARNING.reach * self._span
        often = self._weight + LEARNING.few / len(self._change)  # as far as so many ticks can tell
        rare = np.r_[far.any(axis=1), False, True] & (often < LEARNING.near)
        found = bool((rare & ~self._never).any())
        self._never |= rare
        self._weight[rare] = DISCOVERY.outliers**2
        self._goes_on = np.logaddexp.reduce(self._log_density(), axis=1)
        return found

    def _log_density(self) -> FloatArray:
        """Of each tick under each kind of change, with its weight, shape (n_ticks, n_kinds)."""
        out = np.empty((len(self._change), len(self._weight)))
        out[:, -2], out[:, -1] = self._home, self._uniform
        for k, variance in enumerate(self._variance):
            each = -0.5 * (self._change**2 / variance + np.log(2.0 * np.pi * variance))
            out[:, k] = (each * self._telling).sum(axis=1)
        return out + np.log(self._weight)

    def ratio(self) -> FloatArray:
        """Log-likelihood of each tick if the log was reset in it less that if it went on, shape (n_ticks,)."""
        return np.logaddexp(np.log(self._jumps) + self._anew - self._goes_on, np.log(1.0 - self._jumps))

    def count(self, reset: FloatArray) -> None:
        """How often it is set anew in a reset, from the probability of one in each tick; at least every other time."""
        anew = np.exp(np.log(self._jumps) + self._anew - self._goes_on - self.ratio())
        self._jumps = max(0.5, float((reset @ anew + 1.0) / (reset.sum() + 2.0)))


def _tells(space: StateSpace, i: int) -> bool:
    variable = space.variables[i]
    placed = variable.role is not None and variable.role.kind in _PLACES
    return (variable.kind in ("real", "angle") or placed) and not is_change(space, i)


def _telling(space: StateSpace, noise: FloatArray, before: FloatArray, after: FloatArray) -> BoolArray:
    """Whether a change says something, shape (n_ticks, n_variables): not of what is dissolved in next to nothing."""
    out = np.ones(before.shape, dtype=bool)
    for i, variable in enumerate(space.variables):
        if variable.role is not None and variable.role.kind == "intensive":
            k = space.index(variable.role.of)
            out[:, i] = np.minimum(before[:, k], after[:, k]) >= LEARNING.empty * noise[k]
    return out
