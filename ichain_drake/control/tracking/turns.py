"""How sharply the demonstrations turned, whether a path asks for more, and what of it could be followed."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from ichain_drake.control.settings import TRACKING
from ichain_drake.control.tracking.path import TimedPath
from ichain_drake.errors import InputError
from ichain_drake.learning.chain.chain import LearnedChain
from ichain_drake.learning.features import planar_poses
from ichain_drake.learning.settings import LEARNING
from ichain_drake.state import FloatArray, wrap_angle
from ichain_drake.timing import TICK

_STRAIGHT = 1e-6  # turning over the smoothing length that is rounding [rad]
_EVERY = 3  # points of the path from one check to the next


_SLOWER = 0.9  # from one nominal speed that is tried to the next
_WIDER = 1.25  # from one length of smoothing that is tried to the next


@dataclass(frozen=True)
class ShownTurns:
    """How sharply an object turned in its demonstrations.

    Attributes:
        speed: of every transition [unit/s], shape (n,).
        curvature: of the same [1/unit], shape (n,).
    """

    speed: FloatArray
    curvature: FloatArray

    def sharpest(self, speed: float) -> float:
        """The sharpest turn at a speed, or at those nearest to it where it was hardly shown [1/unit].

        A high quantile of what was shown, at the upper end of its interval (by the binomial spread of the number of
        rows beyond a quantile): few rows say little of how sharp the sharpest was.
        """
        away = np.abs(self.speed - speed)
        near = away < TRACKING.band * speed
        if near.sum() < LEARNING.several:
            near = away <= np.sort(away)[min(len(away) - 1, max(LEARNING.several, int(LEARNING.near * len(away))))]
        spread = math.sqrt(TRACKING.quantile * (1.0 - TRACKING.quantile) / near.sum())
        return float(np.quantile(self.curvature[near], min(1.0, TRACKING.quantile + LEARNING.sure * spread)))


def shown_turns(chain: LearnedChain) -> ShownTurns | None:
    """How sharply the chain's last object turned; None for one without a heading, or that never moved."""
    space = chain.graph.objects[chain.names[-1]].observable
    poses = [p for p in planar_poses(space) if set(p[:2]) == set(chain.targets)]
    if not poses:
        return None
    x, y, h = poses[0]
    length = np.concatenate([np.linalg.norm(np.diff(piece[:, [x, y]], axis=0), axis=1) for piece in chain.validation])
    turns = np.concatenate([np.abs(wrap_angle(np.diff(piece[:, h]))) for piece in chain.validation])
    moved = length > 0
    return ShownTurns(length[moved] / TICK, turns[moved] / length[moved]) if moved.any() else None


def sharp_turn(path: TimedPath, shown: ShownTurns) -> tuple[int, float, float] | None:
    """The first place where a path turns more sharply than was shown at its speed.

    Returns:
        Index of the path's point, its curvature, and the sharpest that was shown [1/unit]; None if there is none.
    """
    curvature = np.abs(path.mean_curvature(path.limits.speed * TICK))
    known: dict[float, float] = {}
    for i in range(0, len(curvature), _EVERY):
        speed = round(float(path.speed[i]), 6)
        if speed not in known:
            known[speed] = shown.sharpest(speed)
        if curvature[i] > max(known[speed], _STRAIGHT / path.limits.smoothing):
            return i, float(curvature[i]), known[speed]
    return None


def slower(path: TimedPath, shown: ShownTurns) -> float | None:
    """A nominal speed at which a path turns nowhere too sharply, not below what was shown; None if there is none."""
    speed, least = _SLOWER * path.limits.speed, float(np.quantile(shown.speed, 1.0 - TRACKING.quantile))
    while speed > max(least, 0.0):
        rounded = float(f"{speed:.2g}")
        if sharp_turn(TimedPath(path.points, replace(path.limits, speed=rounded)), shown) is None:
            return rounded
        speed *= _SLOWER
    return None


def check_turns(path: TimedPath, chain: LearnedChain, where: str, unit: str) -> None:
    """Refuse a path that turns more tightly than anything in the demonstrations at that speed.

    Nothing is checked for an object without a heading.

    Args:
        path: the timed path.
        chain: the learned chain, with the demonstrated trajectories of its last object.
        where: what to call the path in the error.
        unit: of its coordinates.

    Raises:
        InputError: naming the point, its radius and the limit, and what would help.
    """
    shown = shown_turns(chain)
    found = None if shown is None else sharp_turn(path, shown)
    if shown is None or found is None:
        return
    i, curvature, sharpest = found
    px, py = path.points[i]
    places = max(0, -math.floor(math.log10(path.limits.spacing)))
    where_to, speed_text = f"({px:.{places}f}, {py:.{places}f})", f"{path.speed[i]:.{places}f}"
    speed = slower(path, shown)
    ways = ["widen the turn", "give --smooth", *([] if speed is None else [f"--set path.speed={speed:g}"])]
    tightest = f"is {1 / sharpest:.1f} {unit}" if sharpest > 0 else "is none: they never turn there"
    raise InputError(
        f"{where}: at {where_to} it turns with a radius of {1 / curvature:.1f} {unit}; the tightest turn in the "
        f"demonstrations at {speed_text} {unit}/s {tightest}; {', '.join(ways[:-1])} or {ways[-1]}"
    )


def smooth_path(path: TimedPath, chain: LearnedChain, where: str, unit: str) -> tuple[TimedPath, float]:
    """A path with its corners rounded just as far as the demonstrations ask for; both ends stay.

    Args:
        path: the timed path.
        chain: the learned chain, with the demonstrated trajectories of its last object.
        where: what to call the path in the error.
        unit: of its coordinates.

    Returns:
        The path, and how far from the original it is at most.

    Raises:
        InputError: if it turns too sharply even where it is averaged over half its length.
    """
    shown = shown_turns(chain)
    if shown is None or sharp_turn(path, shown) is None:
        return path, 0.0
    points = path.points
    length = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
    window = path.limits.speed * TICK  # one tick's way: over less, a path's own points turn it
    while window < length / 2:
        half = max(1, round(window / length * len(points) / 2))
        round_points = _averaged(points, half)
        found = TimedPath(round_points, path.limits)
        if sharp_turn(found, shown) is None:
            return found, float(np.linalg.norm(round_points - points, axis=1).max())
        window *= _WIDER
    raise InputError(f"{where}: it turns too sharply for {length:.3g} {unit} of length, however it is smoothed")


def _averaged(points: FloatArray, half: int) -> FloatArray:
    """Points averaged twice over `half` neighbours to each side; about its ends the path is mirrored, so they stay."""
    for _ in range(2):
        reach = min(half, len(points) - 1)
        before, after = 2 * points[0] - points[reach:0:-1], 2 * points[-1] - points[-2 : -reach - 2 : -1]
        padded = np.concatenate([before, points, after])
        sums = np.concatenate([np.zeros((1, points.shape[1])), np.cumsum(padded, axis=0)])
        points = (sums[2 * reach + 1 :] - sums[: -2 * reach - 1]) / (2 * reach + 1)
    return points
