"""Timed paths: how fast to go where, and how far along one is."""

from __future__ import annotations

import copy
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from ichain_drake.demonstrations.columns import as_numbers
from ichain_drake.demonstrations.csv_text import read_csv
from ichain_drake.errors import InputError
from ichain_drake.state import FloatArray, IntArray
from ichain_drake.units import convert, split_unit

_MIN_POINTS = 2
_MOST_POINTS = 10**6  # 16 MB; a path of more is in another unit than its spacing


def read_path(file: str | Path, columns: tuple[str, ...], unit: str = "") -> FloatArray:
    """Read a path from a CSV file with one column a coordinate, in any dialect (see `read_csv`).

    Args:
        file: the CSV file; units in brackets behind a column's name are allowed.
        columns: the wanted columns.
        unit: of the points; a column that names another is converted, or refused where that can't be. Empty: whatever
            they are in.

    Returns:
        Points, shape (n, n_columns).

    Raises:
        InputError: if it can't be read, a column is missing or there twice, a value is not a number, a unit does not
            fit, or there are under two points.
    """
    file = Path(file)
    text = read_csv(file, "the path", ", ".join(columns))
    split = [split_unit(str(c)) for c in text.table.columns]
    names = [name for name, _ in split]
    values = []
    for column in columns:
        if names.count(column) != 1:
            what = "is missing" if column not in names else "appears twice"
            raise InputError(f"{file}: column {column} {what}; a path has columns {', '.join(columns)}")
        place = names.index(column)
        coordinate = as_numbers(text.table.iloc[:, place])
        given = split[place][1]
        try:
            values.append(convert(coordinate, given, unit) if given and unit else coordinate)
        except InputError as error:
            raise InputError(f"{file}: column {column} is in {given}, a path here in {unit}, and {error}") from None
    points = np.stack(values, axis=1)
    check_points(points, str(file), columns, text.first_line)
    return points


def check_points(points: FloatArray, where: str, columns: tuple[str, ...] = ("x", "y"), first_line: int = 2) -> None:
    """Refuse a path that is no path.

    Args:
        points: shape (n, n_columns).
        where: what to call it in errors.
        columns: names of its columns.
        first_line: line of its file in which the first point is.

    Raises:
        InputError: on NaN (with its line), fewer than two points, or a length of zero.
    """
    bad = ~np.isfinite(points)
    if bad.any():
        row, col = (int(i) for i in np.argwhere(bad)[0])
        raise InputError(
            f"{where}: line {first_line + row}, column {columns[col]}: not a finite number; remove or mend the point"
        )
    if len(points) < _MIN_POINTS:
        raise InputError(f"{where}: {len(points)} point(s); a path needs at least {_MIN_POINTS}")
    if not np.abs(np.diff(points, axis=0)).sum() > 0:
        raise InputError(f"{where}: all points are the same; a path needs a length")


def resample(points: FloatArray, spacing: float) -> FloatArray:
    """Points at equal spacing along a polyline, shape (m, d) from (n, d), first and last kept.

    Raises:
        InputError: if that would be over a million points.
    """
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    if not steps.sum() / spacing <= _MOST_POINTS:
        raise InputError(
            f"{steps.sum():.4g} at a spacing of {spacing:g} are over {_MOST_POINTS} points; give a larger spacing, or "
            "mend what is in another unit"
        )
    points = np.concatenate([points[:1], points[1:][steps > 0]])
    length = np.concatenate([[0.0], np.cumsum(steps[steps > 0])])
    count = max(_MIN_POINTS, int(np.ceil(length[-1] / spacing)) + 1)
    at = np.linspace(0.0, length[-1], count)
    return np.stack([np.interp(at, length, c) for c in points.T], axis=1)


@dataclass(frozen=True)
class PathLimits:
    """What a scenario gives about following paths, in the path's units.

    Attributes:
        speed: nominal speed [unit/s].
        turn_rate: speed is lowered where the path's curvature would need a higher one [rad/s].
        spacing: spacing of the sampled path [unit].
        smoothing: length over which curvature is averaged [unit].
        tolerance: the end counts as reached within this distance of it [unit].
        corridor: a point of the path counts as passed within this distance of it [unit]; a run that has not passed all
            of them has not followed the path.
    """

    speed: float
    turn_rate: float = 1.1
    spacing: float = 1.0
    smoothing: float = 40.0
    tolerance: float = 3.0
    corridor: float = 10.0


def _mean_curvature(points: FloatArray, spacing: float, half: int) -> FloatArray:
    """Curvature at points, shape (n,), as a mean over `half` neighbours to each side; over fewer near the ends."""
    heading = np.unwrap(np.arctan2(*np.diff(points, axis=0).T[::-1]))
    inside = np.diff(heading) / spacing
    turning = np.pad(inside, 1, mode="edge") if len(inside) else np.zeros(len(points))
    sums = np.concatenate([[0.0], np.cumsum(turning)])
    at = np.arange(len(points))
    first, end = np.maximum(at - half, 0), np.minimum(at + half + 1, len(points))
    return (sums[end] - sums[first]) / (end - first)


@dataclass(frozen=True)
class TimedPath:
    """A path in the plane with a time for each of its points.

    Attributes:
        points: shape (n, 2), at `limits.spacing`.
        limits: see `PathLimits`.
    """

    points: FloatArray
    limits: PathLimits
    direction: FloatArray = field(init=False)
    curvature: FloatArray = field(init=False)
    speed: FloatArray = field(init=False)
    time: FloatArray = field(init=False)
    _spacing: float = field(init=False, repr=False)

    def __post_init__(self) -> None:
        points = resample(np.asarray(self.points, dtype=float), self.limits.spacing)
        # The mean, not the first: a corner within the first step makes that one shorter.
        spacing = float(np.linalg.norm(np.diff(points, axis=0), axis=1).mean())
        tangent = np.gradient(points, axis=0)
        direction = np.unwrap(np.arctan2(tangent[:, 1], tangent[:, 0]))
        object.__setattr__(self, "points", points)
        object.__setattr__(self, "_spacing", spacing)
        curvature = self.mean_curvature(self.limits.smoothing)
        nominal = self.limits.speed
        speed = nominal / np.sqrt(1.0 + (nominal * np.abs(curvature) / self.limits.turn_rate) ** 2)
        time = np.concatenate([[0.0], np.cumsum(2.0 * spacing / (speed[1:] + speed[:-1]))])
        values = {"direction": direction, "curvature": curvature, "speed": speed, "time": time}
        for name, value in values.items():
            object.__setattr__(self, name, value)

    def mean_curvature(self, window: float) -> FloatArray:
        """Curvature at the path's points, averaged over a window of a length [unit], shape (n,) [1/unit]."""
        return _mean_curvature(self.points, self._spacing, max(1, round(window / self._spacing / 2)))

    def shifted(self, offset: FloatArray) -> TimedPath:
        """The same path elsewhere, at the same times; `offset` has shape (2,)."""
        other = copy.copy(self)
        object.__setattr__(other, "points", self.points + np.asarray(offset, dtype=float))
        return other

    def at_time(self, time: FloatArray) -> FloatArray:
        """Points at times [s], shape (..., 2); beyond the end straight on at the last speed."""
        time = np.asarray(time, dtype=float)
        index = np.interp(time, self.time, np.arange(len(self.time)))
        over = np.maximum(0.0, time - self.time[-1])[..., None] * self.speed[-1]
        end = np.array([np.cos(self.direction[-1]), np.sin(self.direction[-1])])
        grid = np.arange(len(self.time))
        return np.stack([np.interp(index, grid, c) for c in self.points.T], axis=-1) + over * end

    def advance(self, position: FloatArray, progress: int, seconds: float) -> int:
        """Index of the path's point nearest to a position, looking only forward.

        Args:
            position: shape (2,).
            progress: the last index.
            seconds: how far ahead to look, as a time at nominal speed [s].
        """
        ahead = max(2, int(np.ceil(seconds * self.limits.speed / self._spacing)))
        window = self.points[progress : progress + ahead + 1]
        return progress + int(np.argmin(np.sum((window - position) ** 2, axis=1)))

    def advance_rows(self, positions: FloatArray, progress: IntArray, seconds: float) -> IntArray:
        """`advance` of several followers at once.

        Args:
            positions: where they are, shape (n, 2).
            progress: index of each, shape (n,).
            seconds: how far ahead is looked [s].

        Returns:
            New indices, shape (n,).
        """
        ahead = max(2, int(np.ceil(seconds * self.limits.speed / self._spacing)))
        window = np.minimum(progress[:, None] + np.arange(ahead + 1), len(self.points) - 1)
        away = np.sum((self.points[window] - positions[:, None]) ** 2, axis=2)
        return progress + np.argmin(away, axis=1)

    def near_end(self, progress: int) -> bool:
        """Whether an index is within the tolerance of the end, along the path; see `Arrival` too."""
        return progress >= len(self.points) - 1 - self.limits.tolerance / self._spacing


def path_error(executed: FloatArray, path: TimedPath) -> float:
    """Mean distance of all executed positions to the sampled path, in its unit."""
    return float(cKDTree(path.points).query(executed)[0].mean())


def paper_path_error(
    executed: FloatArray, waypoints: FloatArray, rng: np.random.Generator, samples: int = 500
) -> float:
    """The paper's metric (sec. IV): random executed points to the nearest point of the discretised commanded path.

    Args:
        executed: executed positions, shape (n, 2).
        waypoints: the commanded path as it is discretised for control, one point a tick, shape (m, 2).
        rng: draws the executed points.
        samples: how many.

    Returns:
        Mean distance. A perfect follower still has about a quarter of the waypoints' spacing.
    """
    chosen: NDArray[np.intp] = rng.integers(0, len(executed), samples)
    return float(cKDTree(waypoints).query(executed[chosen])[0].mean())
