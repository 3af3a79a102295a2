"""How the frames of two objects that move together are turned, from displacements of single ticks whose rows vary.

`learn_alignment` needs flags: displacements over several ticks of one activation. Here which ticks belong together is
what is looked for, so that each tick stands for itself, and frames are taken as not turned where nothing tells.
"""

from __future__ import annotations

import numpy as np

from ichain_drake.learning.discovery.log import Log
from ichain_drake.learning.discovery.settings import DISCOVERY
from ichain_drake.learning.effects.alignment import Alignment, position_groups
from ichain_drake.learning.settings import LEARNING
from ichain_drake.state import BoolArray, FloatArray


def tick_alignment(log: Log, parent: str, child: str, on: BoolArray) -> Alignment | None:
    """The alignment of two objects in some ticks, shape (n_ticks,), or None where they don't move together."""
    groups = position_groups(log.spaces[parent])[0], position_groups(log.spaces[child])[0]
    (p, ip), (c, ic) = ((g, list(g.indices)) for g in groups)
    before, after = log.states[parent][log.t], log.states[parent][log.t + 1]
    moved_p = (after - before)[:, ip]
    moved_c = (log.states[child][log.t + 1] - log.states[child][log.t])[:, ic]
    angles = tuple(np.flatnonzero(log.spaces[parent].angle_mask).tolist())
    turned = _circular(after, angles) - _circular(before, angles)
    least = LEARNING.surely * np.sqrt(2.0) * float(np.linalg.norm(log.noise[parent][ip]))
    rows = on & (np.linalg.norm(moved_p, axis=1) > least)
    if rows.sum() < LEARNING.rows:
        return None
    still = rows & (np.abs(turned).sum(axis=1) < LEARNING.near)
    fit = still if still.sum() >= LEARNING.rows else rows
    same_axes = p.axes == c.axes
    turn = np.eye(len(ic)) if p.frame == c.frame and same_axes else _turn(moved_p[fit], moved_c[fit], rigid=same_axes)
    sway = np.zeros((len(ic), 2 * len(angles)))
    if angles:
        gram = turned[rows].T @ turned[rows] + DISCOVERY.sway * np.eye(turned.shape[1])
        sway = np.linalg.solve(gram, turned[rows].T @ (moved_c - moved_p @ turn.T)[rows]).T
    left = (moved_c - moved_p @ turn.T - turned @ sway.T)[rows]
    share = _smaller(left) / max(_smaller(moved_c[rows]), 1e-12)
    if share > LEARNING.unexplained:
        return None
    place = log.states[parent][log.t][:, ip] @ turn.T + _circular(before, angles) @ sway.T
    shift = np.median((log.states[child][log.t][:, ic] - place)[rows], axis=0)
    return Alignment(p, c, angles, turn, sway, shift, int(rows.sum()), float(share))


def _turn(moved_p: FloatArray, moved_c: FloatArray, *, rigid: bool) -> FloatArray:
    keep = np.ones(len(moved_p), dtype=bool)
    for _ in range(4):
        if rigid:
            cross = moved_c[keep].T @ moved_p[keep]
            prior = DISCOVERY.unturned * np.trace(moved_p[keep].T @ moved_p[keep]) / len(cross) * np.eye(len(cross))
            u, _, vt = np.linalg.svd(cross + prior)
            sign = np.ones(len(u))
            sign[-1] = np.sign(np.linalg.det(u @ vt))
            turn = np.asarray((u * sign) @ vt)
        else:
            turn = np.asarray(np.linalg.lstsq(moved_p[keep], moved_c[keep], rcond=None)[0].T)
        residual = np.linalg.norm(moved_c - moved_p @ turn.T, axis=1)
        kept = residual <= LEARNING.clear * max(float(np.median(residual)), 1e-9)
        if kept.sum() < 4:
            break
        keep = kept
    return turn


def _circular(states: FloatArray, angles: tuple[int, ...]) -> FloatArray:
    values = states[:, list(angles)]
    return np.concatenate([np.cos(values), np.sin(values)], axis=1)


def _smaller(rows: FloatArray) -> float:
    squares = np.sort((rows**2).sum(axis=1))
    return float(squares[: int(LEARNING.kept * len(squares))].sum())
