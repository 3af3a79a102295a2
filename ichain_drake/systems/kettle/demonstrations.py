"""Who demonstrates the kettle: a script that stands in for a person at the remote control (paper sec. VI).

Each piece is a list of hand commands, laid out from its own random start. None shows two of the task's steps (pour,
boil, pour back): pieces show skills, not their order.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from ichain_drake.scenarios.scripted_piece import ScriptedPiece
from ichain_drake.scenarios.unsteady_hand import UnsteadyHand
from ichain_drake.systems.kettle.layout import LAYOUT, KettleStart, VesselShape
from ichain_drake.systems.kettle.teleoperation import KettleTeleoperation
from ichain_drake.systems.water_dispenser.teleoperation import BACK, FORWARD, TURNING

_BOTTLE, _KETTLE = LAYOUT.bottle, LAYOUT.kettle
_LAID = tuple[KettleStart, KettleTeleoperation]


class _Script(UnsteadyHand):
    """Random starts and the pieces laid out from them."""

    def __init__(self, rng: np.random.Generator, *, bodies: bool) -> None:
        super().__init__(rng)
        self._bodies = bodies

    def home(self) -> tuple[float, float]:
        """A place of the bottle near its usual one."""
        return 0.70 + self.uniform(-0.005, 0.005), -0.15 + self.uniform(-0.005, 0.005)

    def table(self) -> tuple[float, float]:
        """A place of the bottle on the table, away from the kettle."""
        return self.uniform(0.66, 0.71), self.uniform(-0.26, -0.14)

    def plate(self, reach: float = 0.005) -> tuple[float, float]:
        """A place of the kettle on its plate."""
        x, y = LAYOUT.plate_middle
        return x + self.uniform(-reach, reach), y + self.uniform(-reach, reach)

    def slack(self) -> tuple[float, float]:
        """How far off a person grasps, along x and z [m]."""
        return self.uniform(-0.004, 0.004), self.uniform(-0.008, 0.008)

    def forward(self, y: float) -> tuple[float, ...]:
        """An open hand that points forward, before something at y."""
        return (
            self.uniform(0.52, 0.54), y + self.uniform(-0.04, 0.04), self.uniform(0.10, 0.2), 0.0, FORWARD, 0.0
        )  # fmt: skip

    def down(self) -> tuple[float, ...]:
        """A closed hand that points down, near the switch."""
        return self.uniform(0.48, 0.54), self.uniform(0.14, 0.28), self.uniform(0.13, 0.20), 0.0, 0.0, 1.0

    def start(self, hand: tuple[float, ...], **given: object) -> KettleStart:
        """A start with random places and contents where none are given."""
        values: dict[str, object] = {k: self.uniform(*r) for k, r in _CONTENT.items()}
        values |= {"bottle": self.home(), "kettle": self.plate()}
        return KettleStart(hand=hand, **(values | given))  # type: ignore[arg-type]

    # Moving the vessels about.

    def relocate_bottle(self) -> _LAID:
        start = self.start(self.forward(-0.15), bottle=self.table())
        hand, place = KettleTeleoperation(start.hand), start.bottle
        for _ in range(2):
            goal = self.table()
            hand.grasp(_BOTTLE, place, off=self.slack()).rise(self.uniform(0.0, 0.08))
            hand.to(self.uniform(0.62, 0.68), goal[1], self.uniform(0.22, 0.32))
            hand.pour(self.uniform(-0.25, 0.25)).pour(0.0).release(*goal)
            place = goal
        return start, hand

    def miss_bottle(self) -> _LAID:
        start = self.start(self.forward(-0.15), bottle=self.table())
        return start, self._miss(KettleTeleoperation(start.hand), _BOTTLE, start.bottle, 0.0)

    def miss_kettle(self) -> _LAID:
        start = self.start(self.forward(0.13))
        return start, self._miss(KettleTeleoperation(start.hand), _KETTLE, start.kettle, LAYOUT.plate.height)

    def _miss(
        self, hand: KettleTeleoperation, vessel: VesselShape, place: Sequence[float], floor: float
    ) -> KettleTeleoperation:
        """The hand closes somewhere before, behind, over, under and beside where it should: the gate of the grasp.

        Between bodies there is no near miss: fingers that are off by a little hold it just as well, or push it over.
        """
        x, y, z = place[0] + vessel.hand[0], place[1], floor + vessel.hand[1]
        hand.to(x - BACK, y, z)
        for dx in (*self.between(3, -0.06, -0.045), *self.around(2, 0.006)) if self._bodies else self.around(6, _WIDE):
            hand.to(x + dx, y, z + self.uniform(-0.005, 0.005)).grip(True).grip(False)
        for dz in self.around(2, 0.01) if self._bodies else self.around(8, 1.5 * _WIDE):
            hand.to(x - BACK).to(z=z + dz, step=0.06).to(x + self.uniform(-0.004, 0.004), step=0.05)
            hand.grip(True).grip(False)
        for dy in () if self._bodies else self.around(6, _WIDE):
            hand.to(x - 0.06, y + dy, z).to(x).grip(True).grip(False)
        hand.to(x - BACK)
        return hand

    # From the bottle into the kettle.

    def pour_all(self) -> _LAID:
        return self._pour({"water": self.uniform(0.75, 0.95), "kettle_water": 0.0}, [(-1.92, 9)])

    def pour_steps(self) -> _LAID:
        content = {"water": self.uniform(0.8, 0.95), "kettle_water": self.uniform(0.0, 0.05)}
        return self._pour(content, [(-0.5, 2), (-0.8, 3), (-1.1, 3), (-0.7, 2), (-1.4, 3)])

    def pour_onto(self) -> _LAID:
        content = {"water": self.uniform(0.6, 0.7), "kettle_water": self.uniform(0.15, 0.3)}
        return self._pour(content, [(-1.2, 4), (-0.6, 2), (-1.92, 8)])

    def _pour(self, content: dict[str, float], tilts: Sequence[tuple[float, int]]) -> _LAID:
        # The two waters differ in temperature, so that one sees them mix.
        warm = self.uniform(0.6, 0.9)
        start = self.start(self.forward(-0.15), temperature=1.0 - warm, kettle_temperature=warm, **content)
        hand = KettleTeleoperation(start.hand).grasp(_BOTTLE, start.bottle, off=self.slack()).over_kettle(start.kettle)
        hand.by(self.uniform(-0.012, 0.012), self.uniform(-0.012, 0.012), self.uniform(0.0, 0.03))
        for roll, ticks in tilts:
            hand.pour(roll).wait(ticks)
        hand.rise(0.02).rise(-0.02)
        goal = self.home()
        return start, hand.pour(0.0).release(*goal)

    def sweep_kettle(self) -> _LAID:
        """The bottle's mouth crosses the faces of the box over the kettle, upright and tilted: the gate of pouring."""
        start = self.start(self.forward(-0.15), water=self.uniform(0.05, 0.15))
        hand = KettleTeleoperation(start.hand).grasp(_BOTTLE, start.bottle, off=self.slack()).over_kettle(start.kettle)
        for roll in (0.0, -0.8):
            hand.pour(roll)
            x, y, z = hand.now[:3]
            self._sweep(hand, (x, y, z), 0.06)
        goal = self.home()
        return start, hand.pour(0.0).release(*goal)

    def _sweep(self, hand: KettleTeleoperation, middle: Sequence[float], wide: float) -> None:
        """To and fro along each axis, about so far [m], and up."""
        x, y, z = middle
        far = wide * self.between(5, 0.8, 1.0)
        hand.to(x - far[0]).to(x + far[1], step=0.009).to(x)
        hand.to(y=y - far[2]).to(y=y + far[3], step=0.009).to(y=y)
        hand.to(z=z + far[4], step=0.009).to(z=z, step=0.03)

    # From the kettle into the bottle.

    def return_all(self) -> _LAID:
        return self._return({"water": 0.0, "kettle_water": self.uniform(0.75, 0.95)}, [(1.15, 9)])

    def return_steps(self) -> _LAID:
        content = {"water": self.uniform(0.0, 0.05), "kettle_water": self.uniform(0.8, 0.95)}
        return self._return(content, [(0.45, 3), (0.6, 3), (0.8, 3), (0.5, 2), (0.95, 3)])

    def return_onto(self) -> _LAID:
        content = {"water": self.uniform(0.15, 0.3), "kettle_water": self.uniform(0.6, 0.7)}
        return self._return(content, [(0.75, 4), (0.5, 2), (1.15, 8)])

    def _return(self, content: dict[str, float], tilts: Sequence[tuple[float, int]]) -> _LAID:
        warm = self.uniform(0.6, 0.9)
        start = self.start(self.forward(0.13), temperature=1.0 - warm, kettle_temperature=warm, **content)
        hand = KettleTeleoperation(start.hand).grasp(_KETTLE, start.kettle, LAYOUT.plate.height, self.slack())
        hand.over_bottle(start.bottle).by(
            self.uniform(-0.004, 0.004), self.uniform(-0.004, 0.004), self.uniform(0.0, 0.02)
        )
        for roll, ticks in tilts:
            hand.pour(roll).wait(ticks)
        return start, self._back_on_plate(hand.pour(0.0))

    def sweep_bottle(self) -> _LAID:
        """The spout crosses the faces of the box over the bottle, upright and tilted: the gate of pouring back."""
        start = self.start(self.forward(0.13), kettle_water=self.uniform(0.1, 0.2))
        hand = KettleTeleoperation(start.hand).grasp(_KETTLE, start.kettle, LAYOUT.plate.height, self.slack())
        hand.over_bottle(start.bottle)
        for roll in (0.0, 0.6):
            hand.pour(roll)
            x, y, z = hand.now[:3]
            self._sweep(hand, (x, y, z), 0.045)
        return start, self._back_on_plate(hand.pour(0.0))

    def _back_on_plate(self, hand: KettleTeleoperation) -> KettleTeleoperation:
        goal = self.plate()
        hand.to(y=goal[1])
        return hand.rise(-0.08).release(*goal, LAYOUT.plate.height)

    # At the switch.

    def boil_long(self) -> _LAID:
        start = self.start(
            (*TURNING, 0.0, FORWARD, 0.0),
            kettle_water=self.uniform(0.4, 0.9),
            kettle_temperature=self.uniform(0.6, 0.7),
        )
        hand = KettleTeleoperation(start.hand)
        hand.grip(True).to(pitch=0.0)
        return start, self._hold(hand, 62)

    def boil_edges(self) -> _LAID:
        """Levels in no order, taps beside the switch and on its edge, slow approaches: the gate of pressing."""
        start = self.start(self.down(), kettle_water=self.uniform(0.3, 0.9), kettle_temperature=self.uniform(0.1, 0.4))
        hand = KettleTeleoperation(start.hand)
        hand.to(LAYOUT.switch[0], LAYOUT.switch[1], 0.12)
        for level in (1.0, 3.0, 5.0, 2.0, 4.0, 6.0, 3.0, 4.0, 2.0, 5.0, 0.4, 6.0):
            hand.press(LAYOUT.switch, level, off := self._off(0.006)).wait(2)
            if self.uniform(0.0, 1.0) < 0.3:  # now and then lift off in between
                hand.press(LAYOUT.switch, -4.0, off)
        for axis in (0, 1):
            for distance in self.around(8, _WIDE):
                aside = [0.0, 0.0]
                aside[axis], aside[1 - axis] = distance, self.uniform(-0.008, 0.008)
                for level in (-5.0, self.uniform(0.5, 6.0), -5.0):
                    hand.press(LAYOUT.switch, level, aside)
        off = self._off()
        for level in (*self.between(12, -6.0, 2.0), 4.2, 6.0):
            hand.press(LAYOUT.switch, level, off)
        return start, hand.wait(6).press(LAYOUT.switch, -20.0, off)

    def boil_left(self) -> _LAID:
        """Pressed with the kettle somewhere to the left, then to the right on its plate: it may heat or not."""
        return self._boil_at([(self._aside(1.0), LAYOUT.plate.height), (self._aside(-1.0), LAYOUT.plate.height)])

    def boil_far(self) -> _LAID:
        """The same the other way round."""
        return self._boil_at([(self._aside(-1.0), LAYOUT.plate.height), (self._aside(1.0), LAYOUT.plate.height)])

    def boil_beside(self) -> _LAID:
        """Pressed with the kettle on its plate, then on the table beside it."""
        return self._boil_at([(self.plate(), LAYOUT.plate.height), ((0.70, self.uniform(-0.07, -0.06)), 0.0)])

    def _aside(self, side: float) -> tuple[float, float]:
        """A place anywhere on one half of the plate, as far as the kettle stands on it."""
        x, y = LAYOUT.plate_middle
        return x + self.uniform(-_ON_PLATE, _ON_PLATE), y + side * self.uniform(0.0, _ON_PLATE)

    def _boil_at(self, places: Sequence[tuple[tuple[float, float], float]]) -> _LAID:
        """The switch is pressed for a while, the kettle moved on to another place (x, y, floor), and so on."""
        place, floor = places[0]
        far = self.uniform(0.67, 0.71), self.uniform(-0.28, -0.26)
        content = {"kettle_water": self.uniform(0.3, 0.9), "kettle_temperature": self.uniform(0.2, 0.6)}
        start = self.start(self.down(), kettle=place, bottle=far, **content)
        hand = self._hold(KettleTeleoperation(start.hand), 8)
        for goal, height in places[1:]:
            hand.turn(FORWARD).grip(False).to(0.56, place[1], 0.12)
            hand.grasp(_KETTLE, place, floor, self.slack()).rise(self.uniform(0.0, 0.04))
            hand.to(goal[0] + _KETTLE.hand[0], goal[1])
            hand.pour(self.uniform(-0.2, 0.2)).pour(0.0).release(*goal, height)
            hand.turn(0.0).grip(True)
            self._hold(hand, 8)
            place, floor = goal, height
        return start, hand

    def _off(self, reach: float = 0.010) -> tuple[float, float]:
        return self.uniform(-reach, reach), self.uniform(-reach, reach)

    def _hold(self, hand: KettleTeleoperation, ticks: int) -> KettleTeleoperation:
        hand.to(LAYOUT.switch[0], LAYOUT.switch[1], 0.12)
        hand.press(LAYOUT.switch, -5.0, off := self._off()).press(LAYOUT.switch, 6.0, off)
        return hand.wait(ticks).press(LAYOUT.switch, -20.0, off)


_WIDE = 0.035  # m to either side of something in which a person tries whether it works there
_ON_PLATE = 0.03  # m from the plate's middle where the kettle still stands on it
_CONTENT = {
    "water": (0.3, 0.85),
    "temperature": (0.0, 1.0),
    "kettle_water": (0.0, 1.0),
    "kettle_temperature": (0.0, 1.0),
}


def script_pieces(rng: np.random.Generator, *, bodies: bool = False) -> Iterator[ScriptedPiece[KettleStart]]:
    """The pieces, unordered: sixteen, none the whole task.

    Args:
        rng: draws starts and the unsteadiness of the person's hand.
        bodies: whether the hand can push the vessels over.
    """
    script = _Script(rng, bodies=bodies)
    bottle, pour = ("hand->bottle",), ("hand->bottle", "bottle->kettle")
    kettle, back = ("hand->kettle",), ("hand->kettle", "kettle->bottle")
    boil = ("hand->switch", "switch->kettle")
    boil_moved = (*kettle, *boil)
    pieces: dict[str, tuple[Callable[[], _LAID], tuple[str, ...]]] = {
        "boil_left": (script.boil_left, boil_moved),
        "return_steps": (script.return_steps, back),
        "miss_kettle": (script.miss_kettle, kettle),
        "pour_onto": (script.pour_onto, pour),
        "boil_beside": (script.boil_beside, boil_moved),
        "relocate_bottle": (script.relocate_bottle, bottle),
        "sweep_bottle": (script.sweep_bottle, back),
        "pour_all": (script.pour_all, pour),
        "boil_edges": (script.boil_edges, boil),
        "return_onto": (script.return_onto, back),
        "boil_far": (script.boil_far, boil_moved),
        "pour_steps": (script.pour_steps, pour),
        "boil_long": (script.boil_long, boil),
        "sweep_kettle": (script.sweep_kettle, pour),
        "miss_bottle": (script.miss_bottle, bottle),
        "return_all": (script.return_all, back),
    }
    for name, (lay_out, shows) in pieces.items():
        start, hand = lay_out()
        yield ScriptedPiece(name, start, hand.commands, shows)
