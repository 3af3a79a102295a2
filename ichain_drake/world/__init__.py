"""The ground truth: a Diagram whose systems and connections mirror the interaction graph."""

from ichain_drake.world.reference import WorldReference
from ichain_drake.world.world import World

__all__ = ["World", "WorldReference"]
