"""Where the things of the kettle scenario are, and the state that a run or a demonstration starts from."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from ichain_drake.objects import Region, Surface
from ichain_drake.objects.region import GATE
from ichain_drake.state import FloatArray


@dataclass(frozen=True)
class VesselShape:
    """A vessel as a hand that points forward holds it.

    Attributes:
        height: of the mouth above the bottom [m].
        radius: of the body [m].
        mouth: from the middle of the bottom to below the mouth, along x and y [m].
        hand: from the middle of the bottom to the hand that holds it, along x and z [m].
        room: half-widths of the places around there where a hand that closes holds it [m].
    """

    height: float
    radius: float
    mouth: tuple[float, float]
    hand: tuple[float, float]
    room: tuple[float, float, float] = field(metadata={GATE: True})

    def arm(self, off: tuple[float, float] = (0.0, 0.0)) -> tuple[float, float, float]:
        """From the hand to the mouth of an upright vessel [m]; `off`: how far off it is held, along x and z [m]."""
        return self.mouth[0] - self.hand[0] - off[0], self.mouth[1], self.height - self.hand[1] - off[1]

    def grasp(self) -> Region:
        """Where the hand must be relative to the mouth when it closes."""
        x, y, z = self.arm()
        return Region((-x, -y, -z), self.room)

    def in_hand(self, place: tuple[float, float], floor: float = 0.0) -> FloatArray:
        """The full hand state in which a hand that points forward holds it where it stands upright, shape (7,)."""
        return np.array([place[0] + self.hand[0], place[1], floor + self.hand[1], 0.0, math.pi / 2, 0.0, 1.0])

    def mouth_at(self, place: tuple[float, float], floor: float = 0.0) -> tuple[float, float, float]:
        """The mouth of a vessel that stands somewhere [m]."""
        return place[0] + self.mouth[0], place[1] + self.mouth[1], floor + self.height


@dataclass(frozen=True)
class KettleLayout:
    """Where things are, in the robot's frame [m]: given geometry, the same as in the models of the arm's plant.

    Attributes:
        bottle, kettle: the two vessels; the kettle's mouth is the tip of its spout.
        opening: from the spout's tip to the middle of the kettle's open top.
        plate: what the kettle stands on while it heats.
        console: what the switch stands on.
        switch: middle of the switch's top at rest.
    """

    bottle: VesselShape = VesselShape(0.18, 0.028, (0.0, 0.0), (0.0, 0.125), (0.015, 0.015, 0.030))
    kettle: VesselShape = VesselShape(0.115, 0.055, (0.0, -0.085), (-0.084, 0.075), (0.015, 0.015, 0.025))
    opening: tuple[float, float, float] = (0.0, 0.085, 0.015)
    plate: Surface = Surface((0.675, 0.795), (0.07, 0.19), 0.02)
    console: Surface = Surface((0.485, 0.555), (0.215, 0.285), 0.0305)
    switch: tuple[float, float, float] = (0.52, 0.25, 0.06)

    @property
    def plate_middle(self) -> tuple[float, float]:
        """Where the kettle stands best."""
        return math.fsum(self.plate.x) / 2, math.fsum(self.plate.y) / 2

    def pour_region(self) -> Region:
        """Where the bottle's mouth must be relative to the spout's tip: over the kettle's open top."""
        x, y, z = self.opening
        return Region((x, y, z + 0.13), (0.04, 0.04, 0.12), round=True)

    def return_region(self) -> Region:
        """Where the spout's tip must be relative to the bottle's mouth."""
        return Region((0.0, 0.0, 0.085), (0.026, 0.026, 0.08), round=True)

    def plate_region(self) -> Region:
        """Where the spout's tip is while the kettle stands on the plate."""
        return Region(self.kettle.mouth_at(self.plate_middle, self.plate.height), (0.02, 0.02, 0.01), round=True)


LAYOUT = KettleLayout()


@dataclass(frozen=True)
class KettleStart:
    """The state that a world starts from.

    Attributes:
        bottle: place of the bottle, x, y in the robot's frame [m]; it stands on the table.
        kettle: place of the kettle; it stands on the plate, or on the table beside it.
        water, temperature: the bottle's content.
        kettle_water, kettle_temperature: the kettle's content.
        hand: the hand's exposed state: x, y, z [m], roll, pitch [rad], grip.
    """

    bottle: tuple[float, float]
    kettle: tuple[float, float]
    water: float
    temperature: float
    kettle_water: float = 0.0
    kettle_temperature: float = 0.1
    hand: tuple[float, ...] = (0.56, -0.08, 0.25, 0.0, 1.5707963267948966, 0.0)

    @property
    def kettle_floor(self) -> float:
        """Height of what the kettle stands on [m]."""
        x, y = self.kettle
        (x0, x1), (y0, y1) = LAYOUT.plate.x, LAYOUT.plate.y
        return LAYOUT.plate.height if x0 <= x <= x1 and y0 <= y <= y1 else 0.0
