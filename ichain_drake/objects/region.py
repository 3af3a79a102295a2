"""Regions in space with hysteresis: the geometry that switches interactions on and off (paper sec. V)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from ichain_drake.objects.placement import Placement

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
