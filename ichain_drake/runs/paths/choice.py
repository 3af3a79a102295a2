"""The paths of a run: a scenario's own or a user's, checked before any work starts."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ichain_drake.control.tracking.path import PathLimits, TimedPath, check_points, read_path
from ichain_drake.errors import InputError
from ichain_drake.files import shown
from ichain_drake.scenarios.base import PathScenario
from ichain_drake.state import FloatArray


def choose_paths(
    scenario: PathScenario, names: str | Sequence[str] = (), file: str | Path | Sequence[str | Path] | None = None
) -> dict[str, TimedPath]:
    """The paths of a run: reference paths by name (default all), or those in CSV files, each named after its file.

    Args:
        scenario: whose target follows.
        names: of reference paths, one or several.
        file: a CSV file, or several.

    Raises:
        InputError: on an unknown name, a bad file, two files of one name, or a point outside the plane.
    """
    limits = scenario.path_limits()
    files = [] if file is None else [Path(file)] if isinstance(file, str | Path) else [Path(f) for f in file]
    if files:
        found: dict[str, TimedPath] = {}
        for one in files:
            points, name = read_path(one, scenario.target_variables, scenario.unit), shown(Path(one.stem))
            _check_inside(points, scenario, str(one))
            _check_length(points, limits, str(one), scenario.unit)
            if name in found:
                raise InputError(f"{one}: another path is called {name}, too; rename one of the files")
            found[name] = timed(points, limits, str(one))
        return found
    known = scenario.reference_paths()
    names = [names] if isinstance(names, str) else names
    for name in names:
        if name not in known:
            raise InputError(f"{scenario.name} has no path {name!r}; it has {', '.join(known)}")
    chosen = {n: known[n] for n in (names or known)}
    for name, points in chosen.items():
        check_points(points, f"path {name}", scenario.target_variables)
        _check_length(points, limits, f"path {name}", scenario.unit)
    return {n: timed(p, limits, f"path {n}") for n, p in chosen.items()}


def timed(points: FloatArray, limits: PathLimits, where: str) -> TimedPath:
    """A timed path; what is wrong with it names it.

    Raises:
        InputError: if its spacing would make too many points.
    """
    try:
        return TimedPath(points, limits)
    except InputError as error:
        raise InputError(f"{where}: {error}") from None


def _check_inside(points: FloatArray, scenario: PathScenario, where: str) -> None:
    outside = ((points < 0) | (points > np.array(scenario.size))).any(axis=1)
    if outside.any():
        row = int(np.argmax(outside))
        x, y = points[row]
        raise InputError(
            f"{where}: line {row + 2}: ({x:g}, {y:g}) {scenario.unit} is outside the screen of "
            f"{scenario.size[0]:g} x {scenario.size[1]:g} {scenario.unit}"
        )


def _check_length(points: FloatArray, limits: PathLimits, where: str, unit: str) -> None:
    length = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
    if length <= limits.tolerance:
        raise InputError(
            f"{where}: it is {length:.3g} {unit} long; an end counts as reached within {limits.tolerance:g} {unit}, so "
            "give a longer path"
        )
