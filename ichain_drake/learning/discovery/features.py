"""Columns of an effect in all ticks, with dead bands: a reading's noise is no motion and no flow."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ichain_drake.graph import Interaction
from ichain_drake.learning.discovery.residual import Residual
from ichain_drake.learning.effects.alignment import Alignment
from ichain_drake.learning.effects.columns import Column, candidate_columns
from ichain_drake.learning.settings import LEARNING
from ichain_drake.state import BoolArray, FloatArray


@dataclass(frozen=True, eq=False)
class Features:
    """Columns that an effect may use.

    Attributes:
        values: shape (n_ticks, n_columns).
        labels: of the columns.
        declared: per variable of the child the columns that the roles declare for it.
        own: per variable the column that is that variable itself, -1 where there is none.
        foreign: whether a column says something of the parent, shape (n_columns,).
        noise: of one reading behind each column, shape (n_columns,); 0 where it isn't known.
        passive: whether they are the child's own: of what it does by itself.
    """

    values: FloatArray
    labels: tuple[str, ...]
    declared: dict[int, tuple[int, ...]]
    own: dict[int, int]
    foreign: BoolArray
    noise: FloatArray
    passive: bool = False


def features(residual: Residual, parent: str, alignment: Alignment | None) -> Features:
    """Columns of a parent's effects on a child; of the child itself where it is its own parent."""
    if parent == residual.child:
        return _own(residual)
    log = residual.log
    edge = Interaction(parent, residual.child)
    columns = candidate_columns(log.data, edge, alignment, log.noise)
    before, after = log.states[parent][log.t], log.states[parent][log.t + 1]
    values = np.stack([c(before, after, residual.lagged) for c in columns], axis=1)
    noise = np.array([_noise(residual, parent, c) for c in columns])
    for k, c in enumerate(columns):
        if c.source in ("received", "mixing"):  # nothing flows back
            left = before[:, c.index] - after[:, c.index]
            values[:, k] = np.where(_alive(residual, left, c.floor) & (left > 0), values[:, k], 0.0)
        elif c.source in ("aligned_change", "parent_change"):
            floor = float(noise[k]) * np.sqrt(2.0)
            values[:, k] = np.where(_alive(residual, values[:, k], floor), values[:, k], 0.0)
    declared = {v: tuple(k for k, c in enumerate(columns) if c.declares(v)) for v in residual.variables}
    plain = {c.index: k for k, c in enumerate(columns) if (c.source, c.view) == ("child", "plain")}
    own = {v: plain.get(v, -1) for v in residual.variables}
    return Features(
        values, tuple(c.label for c in columns), declared, own, np.array([c.source != "child" for c in columns]), noise
    )


def _own(residual: Residual) -> Features:
    columns, labels, own = [], [], {}
    for i in residual.variables:
        name, value = residual.space.names[i], residual.lagged[:, i]
        if residual.space.angle_mask[i]:
            columns += [np.cos(value), np.sin(value)]
            labels += [f"cos({name})", f"sin({name})"]
        else:
            own[i] = len(columns)
            columns.append(value)
            labels.append(name)
    return Features(
        np.array(columns).T, tuple(labels), {}, own, np.zeros(len(columns), dtype=bool), np.zeros(len(columns)), True
    )


def _noise(residual: Residual, parent: str, column: Column) -> float:
    noise = residual.log.noise[parent]
    if column.source == "aligned_change":
        assert column.alignment is not None
        return float(np.mean(noise[list(column.alignment.parent.indices)]))
    return float(noise[column.index]) if column.source in ("received", "parent_change") else 0.0


def _alive(residual: Residual, change: FloatArray, floor: float) -> BoolArray:
    """Whether a measured change is one: with those of the ticks beside it, or clearly by itself, shape (n_ticks,)."""
    piece, band = residual.log.tick_piece, LEARNING.faint * floor
    same = np.r_[False, piece[1:] == piece[:-1]]
    left = np.where(same, np.r_[0.0, change[:-1]], 0.0)
    right = np.where(np.r_[same[1:], False], np.r_[change[1:], 0.0], 0.0)
    beside = np.abs(change + left + right) > 3.5 * band  # a sum of three telescopes to one difference
    return np.asarray((beside & (np.abs(change) > band)) | (np.abs(change) > 4.5 * band))
