"""Where the things of the microwave oven are, and the state that a run or a demonstration starts from."""

from __future__ import annotations

from dataclasses import dataclass

from ichain_drake.objects.camera import CameraFrame
from ichain_drake.objects.parts.food import FoodSettings, OvenSettings
from ichain_drake.objects.parts.oven_part import PartMount
from ichain_drake.objects.region import Region
from ichain_drake.objects.vessels.cup_settings import Surface

Point = tuple[float, float, float]


@dataclass(frozen=True)
class MicrowaveLayout:
    """Where things are, in the robot's frame [m]: given geometry, the same as in the models of the arm's plant.

    The oven's front is a plane across x. Its door slides along y: at 0 it shuts the cavity, at its travel it is fully
    open. Button and knob are on a panel beside it; the button is pushed in and pulled out along x.

    Attributes:
        front: the front's x.
        cavity: lower and upper corner of the space inside.
        door, button, knob: see `PartMount`.
        boxes: lower and upper corners of the oven's fixed parts, for the playback.
    """

    front: float = 0.672
    cavity: tuple[float, ...] = (0.672, -0.06, 0.03, 0.872, 0.145, 0.22)
    door: PartMount = PartMount((0.61, -0.01, 0.14), 0.20, "y", (0.015, 0.015, 0.03))
    button: PartMount = PartMount((0.640, -0.13, 0.085), 0.012, "x", (0.012, 0.012, 0.016))
    knob: PartMount = PartMount((0.650, -0.13, 0.17), 1.75, "x", (0.014, 0.014, 0.016))
    boxes: tuple[tuple[float, ...], ...] = (
        (0.672, -0.20, 0.0, 0.872, 0.155, 0.03),
        (0.672, -0.20, 0.22, 0.872, 0.155, 0.24),
        (0.872, -0.20, 0.0, 0.882, 0.155, 0.24),
        (0.672, 0.145, 0.03, 0.872, 0.155, 0.22),
        (0.672, -0.20, 0.03, 0.872, -0.06, 0.22),
    )

    def food_settings(self, camera: CameraFrame) -> FoodSettings:
        """What food meets here: the oven's floor, and the door that bars a doorway."""
        x0, y0, z0, x1, y1, z1 = self.cavity
        half, tall = FoodSettings.width / 2, FoodSettings.height
        middle = ((x0 + x1) / 2, (y0 + y1) / 2, (z0 + z1) / 2)
        cavity = Region(middle, ((x1 - x0) / 2 - half, (y1 - y0) / 2 - half, (z1 - z0) / 2))
        reach = self.front - 0.022 - half  # the door's face, less half a block
        doorway = Region(((reach + x1) / 2, middle[1], z1 / 2), ((x1 - reach) / 2, (y1 - y0) / 2, z1 / 2 + tall))
        floor = Surface((x0 - half, x1), (y0, y1), z0)
        return FoodSettings(surfaces=(floor,), camera=camera, oven=OvenSettings(cavity=cavity, doorway=doorway))


LAYOUT = MicrowaveLayout()


@dataclass(frozen=True)
class MicrowaveStart:
    """The state that a world starts from.

    Attributes:
        food: place of the food's middle, x, y in the robot's frame [m].
        temperature: of the food.
        door, button: coordinates [m].
        knob: angle [rad].
        hand: the hand's exposed state: x, y, z [m], roll [rad], grip.
    """

    food: tuple[float, float]
    temperature: float
    door: float = 0.0
    button: float = 0.0
    knob: float = 0.0
    hand: tuple[float, ...] = (0.54, -0.08, 0.20, 0.0, 0.0)

    @property
    def inside(self) -> bool:
        """Whether the food is in the cavity, and stands on its floor."""
        x0, y0, _, _, y1, _ = LAYOUT.cavity
        return self.food[0] > x0 and y0 < self.food[1] < y1
