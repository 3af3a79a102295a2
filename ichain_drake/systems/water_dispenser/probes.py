"""States around the borders of the water dispenser's interactions, for the evaluation of classifiers alone."""

from __future__ import annotations

from collections.abc import Mapping
from typing import cast

import numpy as np

from ichain_drake.graph import Interaction
from ichain_drake.objects import Button, Cup
from ichain_drake.scenarios.border_probes import Move, State, drawn
from ichain_drake.scenarios.vessel_probes import VesselProbes
from ichain_drake.systems.water_dispenser.layout import LAYOUT


class DispenserProbes(VesselProbes):
    """Makes the probes of the water dispenser; see `BorderProbes`."""

    def borders(self, edge: Interaction) -> Mapping[str, Move]:
        """See `BorderProbes`."""
        child, parent = self.objects[edge.child], self.objects.get(edge.parent)
        if edge.parent == self.hand:
            return self.beside(edge.child)
        if isinstance(parent, Button):
            return {edge.parent: lambda s, rng: self.press(edge.parent, s, rng)}
        if isinstance(child, Cup):
            region = LAYOUT.catch_region(child.cup.height)
            return {edge.child: lambda s, rng: self.put_down(edge.child, region, LAYOUT.tray.height, s, rng)}
        return {edge.parent: lambda s, rng: self._over_inlet(edge.parent, s, rng)}

    def _over_inlet(self, name: str, state: State, rng: np.random.Generator) -> bool:
        """A cup that is moved over the inlet, as high as it can be without going through the machine."""
        region = LAYOUT.pour_region()
        rim = drawn(region.center, region.half, rng, round=region.round)
        height = cast("Cup", self.objects[name]).cup.height
        if rim[2] - height * max(np.cos(state[name][3]), 0.0) < LAYOUT.head.height:
            return False
        self.carry(name, rim, state)
        return True
