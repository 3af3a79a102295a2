"""Where the things of the water dispenser are, and the state that a run or a demonstration starts from."""

from __future__ import annotations

from dataclasses import dataclass

from ichain_drake.objects import Region, Surface
from ichain_drake.objects.placement import Placement


@dataclass(frozen=True)
class DispenserLayout:
    """Where things are, in the robot's frame [m]: given geometry, the same as in the models of the arm's plant.

    Attributes:
        outlet: lower end of the spout.
        inlet: middle of the inlet, at the height of its rim.
        tray, head, console: surfaces that a cup can stand on.
        power, dispense: middles of the buttons' tops.
        boxes: lower and upper corners of the machine's parts, for the playback.
    """

    outlet: tuple[float, float, float] = (0.68, 0.06, 0.141)
    inlet: tuple[float, float, float] = (0.68, 0.06, 0.29)
    tray: Surface = Surface((0.635, 0.74), (0.01, 0.11), 0.01)
    head: Surface = Surface((0.64, 0.82), (-0.02, 0.14), 0.27)
    console: Surface = Surface((0.465, 0.535), (0.145, 0.295), 0.0305)
    power: tuple[float, float, float] = (0.50, 0.18, 0.06)
    dispense: tuple[float, float, float] = (0.50, 0.26, 0.06)
    boxes: tuple[tuple[float, ...], ...] = (
        (0.74, -0.02, 0.0, 0.82, 0.14, 0.155),
        (0.64, -0.02, 0.155, 0.82, 0.14, 0.27),
        (0.635, 0.01, 0.0, 0.74, 0.11, 0.01),
        (0.465, 0.145, 0.0, 0.535, 0.295, 0.0305),
        (0.626, 0.006, 0.27, 0.63, 0.114, 0.29),
        (0.73, 0.006, 0.27, 0.734, 0.114, 0.29),
        (0.626, 0.006, 0.27, 0.734, 0.01, 0.29),
        (0.626, 0.11, 0.27, 0.734, 0.114, 0.29),
    )

    def pour_region(self, moved: Placement | None = None) -> Region:
        """Where the rim of a pouring cup must be: over the inlet, up to 15 cm above it."""
        x, y, z = self.inlet
        return Region((x, y, z + 0.08), (0.04, 0.04, 0.07), moved=moved)

    def catch_region(self, height: float, moved: Placement | None = None) -> Region:
        """Where the rim of a cup of this height [m] must be to catch the water: standing on the tray."""
        x, y, _ = self.outlet
        return Region((x, y, self.tray.height + height), (0.02, 0.02, 0.015), round=True, moved=moved)


LAYOUT = DispenserLayout()

MIDDLE = (0.73, 0.06)
"""Middle of the machine's body, about which it is turned, x and y in the robot's frame [m]."""


@dataclass(frozen=True)
class DispenserStart:
    """The state that a world starts from.

    Attributes:
        cup: place of the cup, x, y in the robot's frame [m].
        water, temperature: its content.
        tank_amount, tank_temperature: the tank's content.
        hand: the hand's exposed state: x, y, z [m], roll, pitch [rad], grip.
        on_tray: whether the cup stands on the dispenser's tray rather than on the table.
        stands: how the machine, but for its buttons' console, stands other than the layout says; None for as it does.
    """

    cup: tuple[float, float]
    water: float
    temperature: float
    tank_amount: float = 0.0
    tank_temperature: float = 0.1
    hand: tuple[float, ...] = (0.56, -0.08, 0.25, 0.0, 1.5707963267948966, 0.0)
    on_tray: bool = False
    stands: Placement | None = None
