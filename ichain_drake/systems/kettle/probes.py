"""States around the borders of the interactions of bottle and kettle, for the evaluation of classifiers alone."""

from __future__ import annotations

from collections.abc import Mapping
from typing import cast

import numpy as np

from ichain_drake.graph import Interaction
from ichain_drake.objects import Button, Cup, Kettle
from ichain_drake.scenarios.border_probes import Move, State, drawn
from ichain_drake.scenarios.vessel_probes import VesselProbes
from ichain_drake.systems.kettle.layout import LAYOUT

_EDGE = (0.03, -LAYOUT.kettle.height)  # from the spout's tip to the nearest edge of the bottom, along y and z [m]


class KettleProbes(VesselProbes):
    """Makes the probes of bottle and kettle; see `BorderProbes`."""

    def borders(self, edge: Interaction) -> Mapping[str, Move]:
        """See `BorderProbes`."""
        child, parent = self.objects[edge.child], self.objects.get(edge.parent)
        if edge.parent == self.hand:
            return self.beside(edge.child)
        if isinstance(parent, Button):
            return {
                edge.parent: lambda s, rng: self.press(edge.parent, s, rng),
                edge.child: lambda s, rng: self.put_down(
                    edge.child, LAYOUT.plate_region(), LAYOUT.plate.height, s, rng
                ),
            }
        pours = self._into_kettle if isinstance(child, Kettle) else self._into_bottle
        return {edge.parent: lambda s, rng: pours(edge, s, rng)}

    def _over(self, edge: Interaction, state: State, rng: np.random.Generator) -> np.ndarray:
        """Bring the parent's mouth over the child's, and around; relative to that, shape (3,) [m]."""
        region = cast("Cup", self.objects[edge.child]).cup.inlets[edge.parent]
        apart = drawn(region.center, region.half, rng, round=region.round)
        self.carry(edge.parent, self.camera.to_robot(state[edge.child][:3]) + apart, state)
        return apart

    def _into_kettle(self, edge: Interaction, state: State, rng: np.random.Generator) -> bool:
        """A bottle over the kettle's opening, whose bottom does not go through the kettle."""
        bottle = cast("Cup", self.objects[edge.parent]).cup
        below = bottle.height * max(np.cos(state[edge.parent][3]), 0.0)
        return bool(self._over(edge, state, rng)[2] - below >= LAYOUT.opening[2])

    def _into_bottle(self, edge: Interaction, state: State, rng: np.random.Generator) -> bool:
        """A spout over the bottle's mouth, whose kettle does not go through the bottle."""
        _, y, z = self._over(edge, state, rng)
        c, s = np.cos(state[edge.parent][3]), np.sin(state[edge.parent][3])
        across, up = y + c * _EDGE[0] - s * _EDGE[1], z + s * _EDGE[0] + c * _EDGE[1]
        return bool(z >= 0.0 and (up >= 0.0 or across >= LAYOUT.bottle.radius))
