"""Ticks that a search for a gated effect begins with."""

from __future__ import annotations

import numpy as np

from ichain_drake.learning.discovery.inputs import GateInputs
from ichain_drake.learning.discovery.residual import Residual
from ichain_drake.learning.discovery.settings import DISCOVERY
from ichain_drake.learning.settings import LEARNING
from ichain_drake.state import BoolArray


def starts(residual: Residual, inputs: GateInputs, train: BoolArray) -> list[BoolArray]:
    """Sets of ticks, shape (n_ticks,) each: what is perturbed, and intervals of one input with the largest mean.

    Args:
        residual: what is left of the child's motion.
        inputs: of the gate.
        train: ticks that may be used, shape (n_ticks,).
    """
    window = residual.window
    loud = {
        i: np.abs(residual.values[:, i]) > LEARNING.surely * residual.spread[:, i] / window for i in residual.variables
    }
    perturbed = np.any(list(loud.values()), axis=0)
    out: list[BoolArray] = []
    if perturbed.sum() >= LEARNING.rows:
        out.append(perturbed & train)
    out += [rows & train for rows in loud.values() if LEARNING.rows <= rows.sum() < 0.9 * perturbed.sum()]
    order = np.argsort(inputs.values, axis=0, kind="stable")
    count = np.cumsum(train[order], axis=0)
    found: list[tuple[float, int, int, int, int]] = []
    for i in residual.variables:
        most = LEARNING.plain * residual.quiet[i] / window
        value = np.clip(residual.values[:, i], -most, most) * residual.quiet[i] / residual.spread[:, i] * train
        total = np.cumsum(np.where(residual.telling(i), value, 0.0)[order], axis=0)
        for sums, counts, side in ((total, count, 1), (total[-1] - total, count[-1] - count, -1)):
            explained = np.where(counts > DISCOVERY.mean, sums**2 / np.maximum(counts, 1), 0.0) * window
            explained = explained / (2.0 * residual.quiet[i] ** 2)
            found += [(float(explained[k, j]), i, j, int(k), side) for j, k in enumerate(explained.argmax(axis=0))]
    found.sort(key=lambda f: -f[0])
    for mean, i, j, k, side in found[: DISCOVERY.intervals]:
        if mean < DISCOVERY.mean:
            break
        cut = inputs.values[order[k, j], j]
        rows = ((inputs.values[:, j] <= cut) if side > 0 else (inputs.values[:, j] > cut)) & train
        if rows.sum() < LEARNING.rows:
            continue
        out.append(rows)
        loudest = LEARNING.plain * residual.quiet[i]
        value = residual.values[:, i] * np.sign(np.sum(np.clip(residual.values[rows, i], -loudest, loudest)))
        upper = rows & (value > DISCOVERY.close * np.quantile(value[rows], 0.9))
        if upper.sum() >= LEARNING.rows:
            out.append(upper)
    return out
