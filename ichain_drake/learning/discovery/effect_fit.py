"""The simplest effect on each variable that pays: what roles declare, a constant, or a line in a few columns."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ichain_drake.learning.discovery.features import Features
from ichain_drake.learning.discovery.residual import Residual
from ichain_drake.learning.discovery.settings import DISCOVERY
from ichain_drake.learning.discovery.term import Curve, VariableEffect
from ichain_drake.learning.settings import LEARNING
from ichain_drake.state import BoolArray, FloatArray

_MAD = 1.4826  # standard deviations of a normal in a median of absolute values


def fit_effects(residual: Residual, rows: BoolArray, features: Features) -> tuple[VariableEffect, ...]:
    """Effects on the child's variables in some ticks, shape (n_ticks,); empty where nothing is explained."""
    found = [_fit_variable(residual, rows, features, i) for i in residual.variables]
    return tuple(e for e in found if e is not None)


def explained(
    residual: Residual, effects: tuple[VariableEffect, ...], features: Features
) -> tuple[FloatArray, FloatArray]:
    """Evidence of each tick for effects, shape (n_ticks,), and what they predict, shape (n_ticks, n_variables)."""
    evidence, predicted = np.zeros(len(residual.values)), np.zeros_like(residual.values)
    for e in effects:
        predicted[:, e.variable] = residual.clipped(e.predict(features.values), e.variable)
        evidence += residual.evidence(predicted[:, e.variable], e.variable, e.std)
    clip = DISCOVERY.clip
    return np.clip(evidence, -clip, clip), predicted


def _fit_variable(residual: Residual, rows: BoolArray, features: Features, i: int) -> VariableEffect | None:
    window = residual.window
    noise, left = residual.log.noise[residual.child][i], residual.values[:, i]
    use = rows & residual.telling(i)
    if residual.constants[i] is None and not residual.space.angle_mask[i]:
        # What stands at a bound can't show an effect that pushes it there.
        near, value = LEARNING.clear * noise, residual.state[:, i]
        stuck = (value <= residual.space.lower[i] + near) | (value >= residual.space.upper[i] - near)
        use = use & ~(stuck & (np.abs(left) < 2 * near / window))
    ok = np.flatnonzero(use)
    if len(ok) < LEARNING.rows:
        return None
    declared, best = _declared(residual, features, i, ok)
    most = float(residual.evidence(left, i, float(residual.quiet[i]))[ok].sum())
    if best is not None and declared >= LEARNING.slight * most:
        return best
    fitted = _line(residual, features, i, ok, declared * (DISCOVERY.declared_first if best is not None else 1.0))
    return best if fitted is None else fitted


def _declared(
    residual: Residual, features: Features, i: int, ok: NDArray[np.intp]
) -> tuple[float, VariableEffect | None]:
    """The best of what roles declare, with its evidence, at least some nat."""
    best: tuple[float, VariableEffect | None] = (2.0 * DISCOVERY.declared, None)
    widest = LEARNING.clear * residual.quiet[i] / residual.window
    for k in features.declared.get(i, ()):
        change = residual.clipped(features.values[:, k], i)
        left = (residual.values[:, i] - change)[ok]
        floor = float(np.hypot(residual.quiet[i], np.sqrt(2.0) * features.noise[k])) / residual.window
        acts = np.abs(change[ok]) > residual.quiet[i] / residual.window
        spread = _MAD * np.median(np.abs(left[acts] if acts.sum() >= LEARNING.rows else left))
        std = float(np.clip(spread, floor, max(widest, floor)))
        value = float(residual.evidence(change, i, std)[ok].sum())
        if value + 2.0 * DISCOVERY.declared > best[0]:
            effect = VariableEffect(i, True, (k,), np.array([0.0, 1.0]), std)
            best = value + 2.0 * DISCOVERY.declared, effect
    return best


def _line(residual: Residual, features: Features, i: int, ok: NDArray[np.intp], least: float) -> VariableEffect | None:
    """A constant, then one input after the other while each pays; None if none of them is worth more than `least`.

    What has no memory is a function of what acts on it, from state to state: where a line leaves more than noise, a
    curve is tried. What changes little by little needs none.
    """
    best: VariableEffect | None = None
    most, degrees = least, 1 if residual.constants[i] is None else max(DISCOVERY.most_inputs, 1)
    for degree in range(1, degrees + 1):
        value, fitted = _stepwise(residual, features, i, ok, least, degree)
        if fitted is not None and value > most:
            best, most = fitted, value
        if best is None or best.std < LEARNING.clear * residual.quiet[i] / residual.window:  # noise, or nearly so
            break
    return best


def _stepwise(
    residual: Residual, features: Features, i: int, ok: NDArray[np.intp], least: float, degree: int
) -> tuple[float, VariableEffect | None]:
    """One input after the other, of a polynomial of some degree; with its evidence."""
    usable = [k for k in range(features.values.shape[1]) if np.ptp(features.values[ok, k]) > 1e-9]
    if residual.constants[i] is not None:  # without memory its own past tells only what its parents did then
        usable = [k for k in usable if k != features.own.get(i)]
    chosen: tuple[int, ...] = ()
    best: VariableEffect | None = None
    left = residual.values[ok, i]
    for step in range(DISCOVERY.most_inputs + 1):
        free = [k for k in usable if k not in chosen]
        tried = [chosen] if step == 0 else [(*chosen, k) for k in _likely(features.values[ok], free, left)]
        fits = [
            f for columns in tried if (f := _least_squares(residual, features, i, ok, columns, len(usable), degree))
        ]
        if not fits and not step:  # what is pushed both ways alike is moved by no constant
            continue
        if not fits:
            break
        value, effect = max(fits, key=lambda f: f[0])
        if value < least + (DISCOVERY.more if step else 0.0):
            if step:
                break
            continue
        chosen, best, least = effect.columns, effect, value
        left = residual.values[ok, i] - effect.predict(features.values[ok])
    return least, best


def _likely(values: FloatArray, free: list[int], left: FloatArray) -> list[int]:
    """The few columns that go best with what is left."""
    if len(free) <= DISCOVERY.tried + 1:
        return free
    x = values[:, free] - values[:, free].mean(axis=0)
    y = np.clip(left, *np.quantile(left, [0.03, 0.97]))
    match = np.abs(x.T @ (y - y.mean())) / np.maximum(np.linalg.norm(x, axis=0), 1e-12)
    return [free[k] for k in np.argsort(-match, kind="stable")[: DISCOVERY.tried]]


def _least_squares(
    residual: Residual,
    features: Features,
    i: int,
    ok: NDArray[np.intp],
    columns: tuple[int, ...],
    candidates: int,
    degree: int,
) -> tuple[float, VariableEffect] | None:
    """Trimmed least squares and its evidence less the price of its parameters."""
    quiet = residual.quiet[i] / residual.window
    used = features.values[ok][:, list(columns)]
    curve = Curve.over(used, degree) if degree > 1 and columns else None
    x = np.column_stack([np.ones(len(ok)), used]) if curve is None else curve(used)
    y = residual.values[ok, i]
    if len(ok) <= x.shape[1] + 4:
        return None
    scale = np.maximum(np.abs(x).max(axis=0), 1e-12)
    ends = [np.abs(residual.clipped(np.full(len(ok), far), i, ok) - y) for far in (-np.inf, np.inf)]
    # At a bound a line may go on beyond what the bound leaves of it.
    at_end = (np.min(ends, axis=0) < LEARNING.clear * quiet) & bool(columns)
    keep = ~at_end
    for _ in range(3):
        if keep.sum() <= x.shape[1] + 2:
            keep[:] = True
        coefficients = np.linalg.lstsq(x[keep] / scale, y[keep], rcond=1e-8)[0] / scale
        told = x @ coefficients
        left = np.abs(y - residual.clipped(told, i, ok))
        beyond = at_end & (residual.clipped(told, i, ok) != told)
        keep = (left <= LEARNING.surely * max(_MAD * float(np.median(left)), quiet)) & ~beyond
    std = min(max(_MAD * float(np.median(left)), quiet), LEARNING.clear * quiet)
    effect = VariableEffect(i, False, columns, coefficients, float(std), curve)
    change = residual.clipped(effect.predict(features.values), i)
    # What is less than the noise by which it is judged can't tell when it acts: it is what other effects leave.
    if not features.passive and np.abs(change[ok]).max() < LEARNING.faint * quiet:
        return None
    value = float(residual.evidence(change, i, effect.std)[ok].sum())
    price = 0.5 * len(coefficients) * np.log(len(ok)) + (np.log(candidates + 1.0) + DISCOVERY.constant) * len(columns)
    return value - float(price), effect
