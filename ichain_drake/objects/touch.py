"""Contact forces with hysteresis: what switches a mechanical interaction on and off where a plant holds the body."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class TouchRule:
    """When the force between gripper and body counts as a touch.

    Attributes:
        on: above this, what was not touched is [N].
        off: above this, what was touched still is [N].
    """

    on: float
    off: float

    def holds(self, force: float, touched: bool) -> bool:
        """Whether a force [N] counts as a touch, given whether it did before."""
        return force > (self.off if touched else self.on)
