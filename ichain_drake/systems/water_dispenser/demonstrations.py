"""Who demonstrates the water dispenser: a script that stands in for a person at the remote control (paper sec. VI).

Each piece is a list of hand commands, laid out from its own random start. No piece holds two consecutive steps of the
task: pieces show skills, not their order.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from ichain_drake.scenarios.scripted_piece import ScriptedPiece
from ichain_drake.scenarios.unsteady_hand import UnsteadyHand
from ichain_drake.systems.water_dispenser.layout import LAYOUT, DispenserStart
from ichain_drake.systems.water_dispenser.teleoperation import BACK, FORWARD, GRASP, TURNING, Teleoperation


class _Script(UnsteadyHand):
    """Random starts and the pieces laid out from them."""

    def __init__(self, rng: np.random.Generator, *, bodies: bool, dip: float) -> None:
        super().__init__(rng)
        self._bodies, self._dip = bodies, dip

    def table(self) -> tuple[float, float]:
        """A place on the table, away from the machine."""
        return self.uniform(0.65, 0.71), self.uniform(-0.25, -0.11)

    def tray(self) -> tuple[float, float]:
        """A place under the outlet."""
        return LAYOUT.outlet[0] + self.uniform(-0.006, 0.006), LAYOUT.outlet[1] + self.uniform(-0.006, 0.006)

    def slack(self) -> tuple[float, float]:
        """How far off a person grasps, along x and z [m]."""
        return self.uniform(-0.004, 0.004), self.uniform(-0.008, 0.008)

    def forward(self) -> tuple[float, ...]:
        """An open hand that points forward, before the table's cups."""
        return self.uniform(0.55, 0.58), self.uniform(-0.20, -0.08), self.uniform(0.10, 0.25), 0.0, FORWARD, 0.0

    def before_tray(self) -> tuple[float, ...]:
        """An open hand that points forward, before the machine."""
        return self.uniform(0.55, 0.58), self.uniform(0.04, 0.08), self.uniform(0.07, 0.12), 0.0, FORWARD, 0.0

    def down(self) -> tuple[float, ...]:
        """A closed hand that points down, near the buttons."""
        return self.uniform(0.47, 0.53), self.uniform(0.12, 0.28), self.uniform(0.13, 0.20), 0.0, 0.0, 1.0

    def start(self, hand: tuple[float, ...], on_tray: bool = False, **content: float) -> DispenserStart:
        """A start with random contents where none are given."""
        values = {k: self.uniform(*r) for k, r in _CONTENT.items()} | content
        return DispenserStart(self.tray() if on_tray else self.table(), hand=hand, on_tray=on_tray, **values)  # type: ignore[arg-type]

    # Moving the cup about.

    def relocate(self) -> tuple[DispenserStart, Teleoperation]:
        start = self.start(self.forward())
        hand, place = Teleoperation(start.hand), start.cup
        for _ in range(2):
            off, goal = self.slack(), self.table()
            hand.fetch(place, 0.0, off).by(z=self.uniform(0.05, 0.12))
            hand.to(self.uniform(0.62, 0.68), goal[1], self.uniform(0.15, 0.30)).tilt(self.uniform(-0.25, 0.25), off)
            hand.tilt(0.0, off).put(*goal, off=off)
            place = goal
        return start, hand

    def miss_grasps(self) -> tuple[DispenserStart, Teleoperation]:
        """The hand closes somewhere before, behind, over, under and beside where it should: the gate of the grasp.

        Between bodies there is no near miss: fingers that are off by a little push the cup over, and those that close
        on its upper or lower end hold it just as well. There it stays well away, or comes close.
        """
        start = self.start(self.forward())
        hand, (x, y) = Teleoperation(start.hand), start.cup
        hand.to(x - BACK, y, GRASP)
        ahead, high, aside = (list(self.around(n, _WIDE)) for n in (10, 8, 8))
        if self._bodies:
            ahead = [*self.between(4, -0.06, -0.045), *self.around(2, 0.006)]
            high, aside = [*self.between(2, 0.055, 0.065), *self.between(3, -0.02, 0.015)], list(self.around(4, 0.006))
        for dx in ahead:
            hand.to(x + dx, y, GRASP + self.uniform(-0.005, 0.005)).grip(True).grip(False)
        for dz in high:
            hand.to(x - BACK).to(z=GRASP + dz, step=0.06).to(x + self.uniform(-0.004, 0.004), step=0.05)
            hand.grip(True).grip(False)
        for dy in aside:
            hand.to(x - 0.06, y + dy, GRASP).to(x).grip(True).grip(False)
        return start, hand.to(x - BACK)

    # At the inlet.

    def pour_all(self) -> tuple[DispenserStart, Teleoperation]:
        content = {"water": self.uniform(0.75, 0.95), "tank_amount": 0.0}
        return self._pour(content, [(-1.95, 9)])

    def pour_steps(self) -> tuple[DispenserStart, Teleoperation]:
        content = {"water": self.uniform(0.8, 0.95), "tank_amount": self.uniform(0.0, 0.05)}
        return self._pour(content, [(-0.5, 2), (-0.8, 3), (-1.1, 3), (-0.7, 2), (-1.4, 3)])

    def pour_onto(self) -> tuple[DispenserStart, Teleoperation]:
        content = {"water": self.uniform(0.6, 0.7), "tank_amount": self.uniform(0.15, 0.3)}
        return self._pour(content, [(-1.2, 4), (-0.6, 2), (-1.95, 8)])

    def _pour(
        self, content: dict[str, float], tilts: Sequence[tuple[float, int]]
    ) -> tuple[DispenserStart, Teleoperation]:
        # The two waters differ in temperature, so that one sees them mix.
        warm = self.uniform(0.6, 0.9)
        start = self.start(self.forward(), temperature=1.0 - warm, tank_temperature=warm, **content)  # type: ignore[arg-type]
        hand, off = Teleoperation(start.hand), self.slack()
        hand.fetch(start.cup, 0.0, off).carry_over_inlet(off)
        hand.by(self.uniform(-0.015, 0.015), self.uniform(-0.015, 0.015), self.uniform(0.0, 0.015))
        for roll, ticks in tilts:
            hand.tilt(roll, off).wait(ticks)
        goal = self.table()
        return start, hand.tilt(0.0, off).carry_back(*goal).put(*goal, off=off)

    def sweep_inlet(self) -> tuple[DispenserStart, Teleoperation]:
        """The cup's rim crosses the faces of the box over the inlet, upright and tilted: the gate of pouring."""
        start = self.start(self.forward(), water=self.uniform(0.05, 0.15))
        hand, off = Teleoperation(start.hand), self.slack()
        hand.fetch(start.cup, 0.0, off).carry_over_inlet(off)
        middle = hand.now.copy()
        for roll in (0.0, -0.8, -1.2):
            hand.tilt(roll, off)
            x, y, z = hand.now[:3]
            if roll > -1.0:
                far = self.between(5, 0.048, 0.064)
                hand.to(x - far[0]).to(x + far[1], step=0.008).to(x, y)
                hand.to(y=y - far[2]).to(y=y + far[3], step=0.008).to(y=y)
                hand.to(z=z + far[4] + 0.01, step=0.008).to(z=z, step=0.015)
            else:  # a tilted cup comes lower than an upright one
                hand.to(z=z - self._dip, step=0.008).to(z=z, step=0.015)
        goal = self.table()
        hand.tilt(0.0, off).to(*middle[:3]).carry_back(*goal)
        return start, hand.put(*goal, off=off)

    # At the outlet.

    def sweep_outlet(self) -> tuple[DispenserStart, Teleoperation]:
        """The cup crosses the faces of the box below the outlet and is left there: the gate of dispensing."""
        start = self.start(self.forward(), water=self.uniform(0.0, 0.3))
        hand, off = Teleoperation(start.hand), self.slack()
        hand.fetch(start.cup, 0.0, off).carry_below_outlet(off)
        x, y, z = hand.now[:3]
        z -= 0.006
        for _ in range(2):
            left, right, back, ahead, up = self.between(5, 0.6, 1.0) * (0.032, 0.032, 0.032, _COLUMN, 0.025)
            for far in (-back, ahead):
                hand.to(x + 0.4 * far, y, z, step=0.012).to(x + far, step=0.003).to(x + 0.4 * far, step=0.003)
            for far in (-right, left):
                hand.to(x, y + 0.4 * far, step=0.012).to(y=y + far, step=0.003).to(y=y + 0.4 * far, step=0.003)
            hand.to(x, y, step=0.012).to(z=z + up, step=0.003).to(z=z, step=0.005)
            x, y = x + self.uniform(-0.006, 0.006), y + self.uniform(-0.006, 0.006)
        hand.to(x, y)
        goal = self.tray()
        return start, hand.put(*goal, height=LAYOUT.tray.height, off=off)

    def place(self) -> tuple[DispenserStart, Teleoperation]:
        start = self.start(self.forward(), water=self.uniform(0.0, 0.3))
        hand, off = Teleoperation(start.hand), self.slack()
        hand.fetch(start.cup, 0.0, off).carry_below_outlet(off)
        return start, hand.put(*self.tray(), height=LAYOUT.tray.height, off=off).turn(0.0)

    def retrieve(self) -> tuple[DispenserStart, Teleoperation]:
        start = self.start(self.before_tray(), on_tray=True)
        hand, off, goal = Teleoperation(start.hand), self.slack(), self.table()
        hand.fetch(start.cup, LAYOUT.tray.height, off).carry_out().to(y=goal[1])
        return start, hand.put(*goal, off=off)

    # At the buttons.

    def heat_long(self) -> tuple[DispenserStart, Teleoperation]:
        hand_start = (*TURNING, 0.0, FORWARD, 0.0)
        start = self.start(hand_start, tank_amount=self.uniform(0.4, 0.9), tank_temperature=self.uniform(0.80, 0.86))
        hand = Teleoperation(start.hand).grip(True).to(pitch=0.0)
        return start, self._hold(hand, LAYOUT.power, 50)

    def heat_levels(self) -> tuple[DispenserStart, Teleoperation]:
        start = self.start(self.down(), tank_amount=self.uniform(0.3, 0.9), tank_temperature=self.uniform(0.1, 0.4))
        return start, self._levels(Teleoperation(start.hand), LAYOUT.power)

    def heat_edges(self) -> tuple[DispenserStart, Teleoperation]:
        start = self.start(self.down(), tank_amount=self.uniform(0.3, 0.9), tank_temperature=self.uniform(0.3, 0.7))
        return start, self._edges(Teleoperation(start.hand), LAYOUT.power)

    def dispense_long(self) -> tuple[DispenserStart, Teleoperation]:
        warm = {"temperature": self.uniform(0.0, 0.2), "tank_temperature": self.uniform(0.7, 0.95)}
        start = self.start(self.down(), True, water=self.uniform(0.0, 0.1), tank_amount=self.uniform(0.6, 0.75), **warm)
        return start, self._hold(Teleoperation(start.hand), LAYOUT.dispense, 38).turn(FORWARD)

    def dispense_levels(self) -> tuple[DispenserStart, Teleoperation]:
        start = self.start(
            self.down(),
            True,
            water=self.uniform(0.2, 0.3),
            temperature=self.uniform(0.7, 0.9),
            tank_amount=self.uniform(0.8, 0.95),
            tank_temperature=self.uniform(0.1, 0.3),
        )
        return start, self._levels(Teleoperation(start.hand), LAYOUT.dispense)

    def dispense_edges(self) -> tuple[DispenserStart, Teleoperation]:
        start = self.start(
            self.down(),
            True,
            water=self.uniform(0.1, 0.2),
            temperature=self.uniform(0.0, 0.3),
            tank_amount=self.uniform(0.8, 0.95),
            tank_temperature=self.uniform(0.6, 0.9),
        )
        return start, self._edges(Teleoperation(start.hand), LAYOUT.dispense)

    def _off(self, reach: float = 0.010) -> tuple[float, float]:
        return self.uniform(-reach, reach), self.uniform(-reach, reach)

    def _hold(self, hand: Teleoperation, button: Sequence[float], ticks: int) -> Teleoperation:
        hand.to(button[0], button[1], 0.12).press(button, -5.0, off := self._off())
        return hand.press(button, 6.0, off).wait(ticks).press(button, -20.0, off)

    def _levels(self, hand: Teleoperation, button: Sequence[float]) -> Teleoperation:
        """All levels, in an order that a person would not think of."""
        hand.to(button[0], button[1], 0.12)
        for level in (1.0, 3.0, 5.0, 2.0, 4.0, 6.0, 3.0, 4.0, 2.0, 5.0, 0.4, 6.0):
            hand.press(button, level, off := self._off(0.006)).wait(2)
            if self.uniform(0.0, 1.0) < 0.3:  # now and then lift off in between
                hand.press(button, -4.0, off)
        return hand.press(button, -20.0)

    def _edges(self, hand: Teleoperation, button: Sequence[float]) -> Teleoperation:
        """Taps beside the button and on its edge, and slow approaches from above: the gate of pressing."""
        hand.to(button[0], button[1], 0.12)
        for axis in (0, 1):
            for distance in self.around(11, _WIDE):
                aside = [0.0, 0.0]
                aside[axis], aside[1 - axis] = distance, self.uniform(-0.008, 0.008)
                hand.press(button, -5.0, aside).press(button, self.uniform(0.5, 6.0), aside).press(button, -5.0, aside)
        off = self._off()
        for level in (*self.between(12, -6.0, 2.0), 4.2, 6.0):
            hand.press(button, level, off)
        return hand.wait(6).press(button, -20.0, off)


_DIPPED, _LOWERED = 0.12, 0.05  # m below the pose in which one pours
_WIDE = 0.035  # m to either side of something in which a person tries whether it works there
_COLUMN = 0.026  # m that a cup under the outlet can go back before it meets the machine
_CONTENT = {
    "water": (0.3, 0.85),
    "temperature": (0.0, 1.0),
    "tank_amount": (0.0, 1.0),
    "tank_temperature": (0.0, 1.0),
}


def script_pieces(
    rng: np.random.Generator, *, bodies: bool = False, point: bool = False
) -> Iterator[ScriptedPiece[DispenserStart]]:
    """The pieces, unordered: at most 16, none the whole task.

    Args:
        rng: draws starts and the unsteadiness of the person's hand.
        bodies: whether the hand can push the cup over.
        point: whether the hand is a point that hits nothing, so that a tilted cup can be dipped into the inlet.
    """
    script = _Script(rng, bodies=bodies, dip=_DIPPED if point else _LOWERED)
    grasp, fill, catch = ("hand->cup",), ("hand->cup", "cup->tank"), ("hand->cup", "tank->cup")
    heat, dispense = ("hand->power", "power->tank"), ("hand->dispense", "dispense->tank", "tank->cup")
    pieces: dict[str, tuple[Callable[[], tuple[DispenserStart, Teleoperation]], tuple[str, ...]]] = {
        "dispense_levels": (script.dispense_levels, dispense),
        "pour_steps": (script.pour_steps, fill),
        "retrieve_1": (script.retrieve, catch),
        "heat_edges": (script.heat_edges, heat),
        "relocate": (script.relocate, grasp),
        "sweep_outlet": (script.sweep_outlet, catch),
        "pour_all": (script.pour_all, fill),
        "heat_long": (script.heat_long, heat),
        "dispense_edges": (script.dispense_edges, dispense),
        "miss_grasps": (script.miss_grasps, grasp),
        "place": (script.place, catch),
        "heat_levels": (script.heat_levels, heat),
        "sweep_inlet": (script.sweep_inlet, fill),
        "dispense_long": (script.dispense_long, dispense),
        "retrieve_2": (script.retrieve, catch),
        "pour_onto": (script.pour_onto, fill),
    }
    for name, (lay_out, shows) in pieces.items():
        start, hand = lay_out()
        yield ScriptedPiece(name, start, hand.commands, shows)
