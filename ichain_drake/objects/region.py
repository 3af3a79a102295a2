"""Boxes in space with hysteresis: the geometry that switches interactions on and off (paper sec. V)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Region:
    """A box along the axes of the robot frame.

    What is outside comes in at the box's faces; what is inside goes out only `margin` beyond them.

    Attributes:
        center: [m].
        half: half-widths [m].
        margin: hysteresis [m].
    """

    center: tuple[float, float, float]
    half: tuple[float, float, float]
    margin: float = 0.002

    def holds(self, point: Sequence[float], inside: bool = False) -> bool:
        """Whether a point counts as inside.

        Args:
            point: x, y, z [m].
            inside: whether it did before.
        """
        slack = self.margin if inside else 0.0
        return all(abs(p - c) <= h + slack for p, c, h in zip(point, self.center, self.half, strict=True))
