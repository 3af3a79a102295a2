"""Where the things of the lidded pot are, and the state that a run or a demonstration starts from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from ichain_drake.objects import JugSettings, LidMount, PotSettings

LEFT, RIGHT, LID, JUG, POT = "left_hand", "right_hand", "lid", "jug", "pot"
HANDS = (LEFT, RIGHT)


@dataclass(frozen=True)
class PotLayout:
    """Where things are, in the robot's frame [m]: given geometry.

    Attributes:
        lid: its handle, when it is shut and how far it opens.
        jug: the jug, which may stand on the shut lid.
        pot: the pot under the lid.
        radius: of the pot.
        beyond: how far from the hands' plane things stand, along x.
    """

    lid: LidMount = LidMount()
    jug: JugSettings = JugSettings(blocks=((-0.1, 0.1, 0.18),))
    pot: PotSettings = PotSettings(lid=LID)
    radius: float = 0.09
    beyond: float = 0.06


LAYOUT = PotLayout()


@dataclass(frozen=True)
class PotStart:
    """The state that a world starts from.

    Attributes:
        hands: exposed state of each hand: y, z [m], roll [rad], grip.
        jug: place of the jug's rim along y [m].
        water, pot_water: what jug and pot hold.
        lid: place of the lid's handle along y [m].
        held: hand that holds the jug; none if empty. It is where that hand is then.
    """

    hands: Mapping[str, tuple[float, ...]]
    jug: float
    water: float
    pot_water: float = 0.0
    lid: float = LAYOUT.lid.shut[0]
    held: str = ""
