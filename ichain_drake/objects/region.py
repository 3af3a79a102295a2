"""Regions in space with hysteresis: the geometry that switches interactions on and off (paper sec. V)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ichain_drake.objects.placement import Placement
from ichain_drake.state import BoolArray, FloatArray

GATE = "gate"
"""Metadata of a dataclass's field that decides where an interaction begins: neither learning nor a script sees it."""


@dataclass(frozen=True)
class Region:
    """A box along the axes of the robot frame, or an upright cylinder.

    What is outside comes in at the faces; what is inside goes out only `margin` beyond them.

    Attributes:
        center: [m].
        half: half-widths; of a cylinder the radii along x and y, and half its height [m].
        margin: hysteresis [m].
        round: whether it is a cylinder.
        moved: how it is moved and turned from where these say; None for not at all.
    """

    center: tuple[float, float, float]
    half: tuple[float, float, float]
    margin: float = 0.002
    round: bool = False
    moved: Placement | None = None

    def holds(self, point: Sequence[float], inside: bool = False) -> bool:
        """Whether a point counts as inside.

        Args:
            point: x, y, z [m].
            inside: whether it did before.
        """
        slack = self.margin if inside else 0.0
        point = point if self.moved is None else self.moved.point_back(point)
        x, y, z = (abs(p - c) / (h + slack) for p, c, h in zip(point, self.center, self.half, strict=True))
        return (math.hypot(x, y) if self.round else max(x, y)) <= 1.0 and z <= 1.0

    def holds_rows(self, points: FloatArray, inside: BoolArray) -> BoolArray:
        """`holds` of many points.

        Args:
            points: [m], shape (3, n).
            inside: shape (n,).

        Returns:
            Shape (n,).
        """
        slack = np.where(inside, self.margin, 0.0)
        x, y, z = points
        if self.moved is not None:
            x, y = self.moved.back(x, y)
        x, y, z = (np.abs(p - c) / (h + slack) for p, c, h in zip((x, y, z), self.center, self.half, strict=True))
        # Python's own hypotenuse, for numpy's has other last bits.
        out = np.array([math.hypot(a, b) for a, b in zip(x, y, strict=True)]) if self.round else np.maximum(x, y)
        return np.asarray((out <= 1.0) & (z <= 1.0))
