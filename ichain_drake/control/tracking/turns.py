"""How sharply the demonstrations turned, and whether a path asks for more."""

from __future__ import annotations

import math

import numpy as np

from ichain_drake.control.tracking.path import TimedPath
from ichain_drake.errors import InputError
from ichain_drake.learning.chain.chain import LearnedChain
from ichain_drake.learning.features import planar_poses
from ichain_drake.state import wrap_angle
from ichain_drake.timing import TICK

_SPEED_BAND = 0.3  # transitions within this fraction of a speed count as that speed
_QUANTILE = 0.98  # the sharpest few are noise
_WINDOW = 1.0  # length over which a path's turn is measured, in ticks at nominal speed
_FEWEST = 8
_STRAIGHT = 1e-6  # turning over the smoothing length that is rounding [rad]
_EVERY = 3  # points of the path from one check to the next


def check_turns(path: TimedPath, chain: LearnedChain, where: str, unit: str) -> None:
    """Refuse a path that turns more tightly than anything in the demonstrations at that speed.

    Nothing is checked for an object without a heading, or at speeds that the demonstrations hardly show.

    Args:
        path: the timed path.
        chain: the learned chain, with the demonstrated trajectories of its last object.
        where: what to call the path in the error.
        unit: of its coordinates.

    Raises:
        InputError: naming the point, its radius and the limit.
    """
    space = chain.graph.objects[chain.names[-1]].observable
    poses = [p for p in planar_poses(space) if set(p[:2]) == set(chain.targets)]
    if not poses:
        return
    x, y, h = poses[0]
    moves = np.concatenate([np.diff(piece[:, [x, y]], axis=0) for piece in chain.validation])
    turns = np.concatenate([wrap_angle(np.diff(piece[:, h])) for piece in chain.validation])
    length = np.linalg.norm(moves, axis=1)
    speed = length / TICK
    curvature = np.abs(path.mean_curvature(_WINDOW * path.limits.speed * TICK))
    for i in range(0, len(curvature), _EVERY):
        near = np.abs(speed - path.speed[i]) < _SPEED_BAND * path.speed[i]
        if near.sum() < _FEWEST or curvature[i] <= 0:
            continue
        sharpest = float(np.quantile(np.abs(turns[near]) / length[near], _QUANTILE))
        if curvature[i] > max(sharpest, _STRAIGHT / path.limits.smoothing):
            px, py = path.points[i]
            places = max(0, -math.floor(math.log10(path.limits.spacing)))
            where_to, speed_text = f"({px:.{places}f}, {py:.{places}f})", f"{path.speed[i]:.{places}f}"
            shown = f"is {1 / sharpest:.1f} {unit}" if sharpest > 0 else "is none: they never turn there"
            raise InputError(
                f"{where}: at {where_to} it turns with a radius of {1 / curvature[i]:.1f} {unit}; the "
                f"tightest turn in the demonstrations at {speed_text} {unit}/s {shown}; "
                "widen the turn, or lower path.speed"
            )
