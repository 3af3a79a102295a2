"""Demonstrations that somebody hands in for following paths, checked against the plane that the paths are in."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ichain_drake.demonstrations import Demonstration
from ichain_drake.demonstrations.columns import column
from ichain_drake.errors import InputError
from ichain_drake.scenarios.base import PathScenario


def check_moves(pieces: Sequence[Demonstration], scenario: PathScenario) -> None:
    """Refuse demonstrations in which what follows paths never moves along one of their axes.

    Raises:
        InputError: names the column.
    """
    for variable in scenario.target_variables:
        name = column(scenario.target, variable)
        shown = [p.table[name].to_numpy(dtype=float) for p in pieces if name in p.table]
        if shown and np.ptp(np.concatenate(shown)) == 0:
            raise InputError(
                f"{name} is {shown[0][0]:g} {scenario.unit} in every row of every piece, so that nothing about moving "
                f"{scenario.target} can be learned; record pieces in which it changes"
            )


def check_in_plane(pieces: Sequence[Demonstration], scenario: PathScenario) -> None:
    """Refuse positions further outside the plane than it is wide: they are in another unit, or no positions.

    Raises:
        InputError: names the piece, the line, the column and the extent.
    """
    for piece in pieces:
        for variable, extent in zip(scenario.target_variables, scenario.size, strict=True):
            name = column(scenario.target, variable)
            if name not in piece.table:
                continue
            values = piece.table[name].to_numpy(dtype=float)
            outside = (values < -extent) | (values > 2.0 * extent)
            if outside.any():
                row = int(np.argmax(outside))
                raise InputError(
                    f"{piece.name}: line {piece.first_line + row}, column {name}: {values[row]:.6g} {scenario.unit} is "
                    f"far outside the plane of {scenario.size[0]:g} x {scenario.size[1]:g} {scenario.unit}; mend or "
                    "convert it"
                )
