"""Who demonstrates the lidded pot: a script that stands in for a person at two remote controls.

Each piece is a list of commands for both hands, laid out from its own random start. None shows more than two of the
task's steps (hold the lid open, pour, let go of the lid): pieces show skills, not their order. Each is shown with the
hands in either part.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence

import numpy as np

from ichain_drake.scenarios.hand_commands import HandCommands, SeveralHands
from ichain_drake.scenarios.scripted_piece import ScriptedPiece
from ichain_drake.scenarios.unsteady_hand import UnsteadyHand
from ichain_drake.systems.lidded_pot.layout import JUG, LAYOUT, LID, POT, PotStart

_NAMES = ("y", "z", "roll", "grip")
_ABOVE = 0.08  # from where a hand comes down on what it takes [m]
_WIDE = 0.055  # how far off a hand closes that shows where nothing is taken [m]
_SHUT, _HANDLE = LAYOUT.lid.shut
_OVER = LAYOUT.pot.middle[1] + LAYOUT.pot.height  # height of a rim that is poured from [m]
_STANDS = LAYOUT.jug.height


_LAID = tuple[PotStart, SeveralHands]


class _Script(UnsteadyHand):
    """Random starts and the pieces laid out from them, for a hand and, where there is one, another."""

    def __init__(self, rng: np.random.Generator, hand: str, other: str, home: Mapping[str, Sequence[float]]) -> None:
        super().__init__(rng)
        self._hand, self._other, self._home = hand, other, home

    def start(self, lid: float | None = None, *, held: bool = False, **given: float) -> PotStart:
        """A start with random places where none are given.

        Args:
            lid: how far the other hand holds it open; None for shut and left alone.
            held: whether the hand holds the jug over the pot.
            given: see `PotStart`.
        """
        hands = {n: (y + self.uniform(-0.04, 0.04), z + self.uniform(-0.04, 0.04), 0.0, 0.0) for n, (y, z) in
                 self._home.items()}  # fmt: skip
        if lid is not None:
            roll = self.uniform(-0.5, 0.5)
            hands[self._other] = (_SHUT + lid, _HANDLE + self.uniform(-0.01, 0.01), roll, 1.0)
        values: dict[str, float] = {
            "jug": self.stand(),
            "water": self.uniform(0.3, 0.95),
            "pot_water": self.uniform(0.0, 0.5),
        }
        if held:
            hands[self._hand] = (self.uniform(-0.015, 0.015), _OVER + self.uniform(-0.02, 0.04), 0.0, 1.0)
            values["jug"] = hands[self._hand][0]
        return PotStart(hands, **(values | given), lid=_SHUT + (lid or 0.0), held=self._hand if held else "")  # type: ignore[arg-type]

    def stand(self) -> float:
        """A place of the jug on the table."""
        return self.uniform(-0.38, -0.20)

    def wide_open(self) -> float:
        """How far a person holds the lid open."""
        return self.uniform(0.125, 0.155)

    # The lid by itself.

    def miss_lid(self) -> _LAID:
        start = self.start()
        both = SeveralHands(_NAMES, start.hands)
        self._misses(both[self._hand], (_SHUT, _HANDLE), 0.05)
        return start, both

    def slide_lid(self) -> _LAID:
        start = self.start()
        both = SeveralHands(_NAMES, start.hands)
        hand = both[self._hand]
        for _ in range(3):
            y, z = _SHUT + self.uniform(-0.008, 0.008), _HANDLE + self.uniform(-0.01, 0.01)
            hand.to(y=y, z=z + _ABOVE)
            hand.to(z=z, roll=self.uniform(-0.5, 0.5)).grip(True)
            for place in self.around(4, 0.08) + 0.08:
                hand.to(y=_SHUT + place, step=self.uniform(0.012, 0.04)).wait(1)
            hand.to(y=_SHUT + self.wide_open()).wait(2).grip(False).to(z=z + _ABOVE).wait(2)
        return start, both

    def release_lid(self) -> _LAID:
        """The lid is opened widely and let go of, again and again: whether it stays."""
        start = self.start()
        both = SeveralHands(_NAMES, start.hands)
        hand = both[self._hand]
        for _ in range(6):
            y, z = _SHUT + self.uniform(-0.008, 0.008), _HANDLE + self.uniform(-0.01, 0.01)
            hand.to(y=y, z=z + _ABOVE).to(z=z, roll=self.uniform(-0.5, 0.5)).grip(True)
            hand.to(y=_SHUT + self.wide_open()).wait(1).grip(False).to(z=z + _ABOVE).wait(1)
        return start, both

    def _misses(self, hand: HandCommands, place: tuple[float, float], moved: float) -> None:
        """The hand closes here and there around something, and moves a little."""
        for dy, dz in self._off_by():
            y, z = place[0] + dy, place[1] + dz
            hand.to(y=y, z=place[1] + _ABOVE, roll=self.uniform(-0.5, 0.5)).to(z=z)
            hand.grip(True).to(y=y + moved).grip(False)
            hand.to(z=place[1] + _ABOVE)

    def _off_by(self) -> list[tuple[float, float]]:
        """How far off a hand closes, along y and z [m]: far along one of them at a time."""
        along_y = [(float(d), self.uniform(-0.008, 0.008)) for d in self.around(7, _WIDE)]
        return along_y + [(self.uniform(-0.006, 0.006), float(d)) for d in self.around(7, _WIDE)]

    # The jug by itself.

    def miss_jug(self) -> _LAID:
        start = self.start()
        both = SeveralHands(_NAMES, start.hands)
        hand = both[self._hand]
        for dy, dz in self._off_by():
            y, z = start.jug + dy, max(_STANDS + dz, 0.0)
            hand.to(y=y, z=_STANDS + _ABOVE).to(z=z).grip(True).wait(1).grip(False).to(z=_STANDS + _ABOVE)
        return start, both

    def move_jug(self) -> _LAID:
        start = self.start(water=self.uniform(0.2, 0.6))
        both = SeveralHands(_NAMES, start.hands)
        hand, place = both[self._hand], start.jug
        for _ in range(3):
            goal = self.stand()
            self._take(hand, place)
            hand.to(y=self.uniform(-0.35, 0.1), z=self.uniform(0.27, 0.46))
            hand.to(roll=self.uniform(-0.25, 0.25)).to(roll=0.0)
            place = self._put(hand, goal)
        return start, both

    def _take(self, hand: HandCommands, place: float) -> float:
        """Take a jug that stands somewhere; returns how far off along y [m]."""
        off = self.uniform(-0.008, 0.008)
        hand.to(y=place + off, z=_STANDS + _ABOVE).to(z=_STANDS + self.uniform(-0.01, 0.01)).grip(True)
        hand.by(z=0.1)
        self._off = off
        return off

    def _put(self, hand: HandCommands, place: float) -> float:
        """Put it down; returns where it stands then."""
        hand.to(y=place + self._off, z=_STANDS + 0.1).to(z=_STANDS + 0.002, step=0.03).wait(1).grip(False)
        hand.by(z=_ABOVE)
        return place

    # Both.

    def pour_all(self) -> _LAID:
        return self._pour([(-1.9, 9)], self.uniform(0.7, 0.95), 0.0)

    def pour_steps(self) -> _LAID:
        tilts = [(-0.5, 2), (-0.8, 3), (-1.1, 3), (-0.7, 2), (-1.4, 3)]
        return self._pour(tilts, self.uniform(0.8, 0.95), self.uniform(0.0, 0.05))

    def pour_onto(self) -> _LAID:
        return self._pour([(-1.2, 4), (-0.6, 2), (-1.9, 8)], self.uniform(0.5, 0.7), self.uniform(0.15, 0.3))

    def _pour(self, tilts: Sequence[tuple[float, int]], water: float, pot_water: float) -> _LAID:
        """The other hand holds the lid open, this one pours and puts the jug back."""
        start = self.start(self.wide_open(), water=water, pot_water=pot_water)
        both = SeveralHands(_NAMES, start.hands)
        hand = both[self._hand].wait(1)
        self._take(hand, start.jug)
        hand.to(z=_OVER + self.uniform(-0.02, 0.04)).to(y=self.uniform(-0.02, 0.02))
        for roll, ticks in tilts:
            hand.to(roll=roll).wait(ticks)
        hand.to(roll=0.0).to(y=start.jug)
        self._put(hand, start.jug)
        return start, both

    def sweep_open(self) -> _LAID:
        return self._sweep(self.wide_open())

    def sweep_shut(self) -> _LAID:
        return self._sweep(None)

    def _sweep(self, lid: float | None) -> _LAID:
        """The jug crosses the faces of the place over the pot, upright and tilted: the gate of pouring."""
        start = self.start(lid, held=True, water=self.uniform(0.5, 0.9))
        both = SeveralHands(_NAMES, start.hands)
        hand = both[self._hand].wait(2)
        for roll in (0.0, -0.6, -1.0):
            hand.to(roll=roll)
            y, z = 0.0, _OVER
            far = self.between(4, 0.06, 0.1)
            hand.to(y=y - far[0], step=0.03).to(y=y + far[1], step=0.012).to(y=y, z=z)
            up, down = self.uniform(0.1, 0.14), self.uniform(0.095, 0.105)
            hand.to(z=z + up, step=0.02).to(z=z - down, step=0.012).to(z=z, step=0.03)
        hand.to(roll=0.0)
        self._off = 0.0
        self._put(hand, self.stand())
        return start, both

    def work_lid(self) -> _LAID:
        """The jug is held over the pot, a little tilted, while the lid goes to and fro under it."""
        start = self.start(self.wide_open(), held=True, water=self.uniform(0.85, 0.95), pot_water=self.uniform(0, 0.1))
        both = SeveralHands(_NAMES, start.hands)
        for roll in (0.0, -0.7, -1.1):
            both[self._hand].to(roll=roll)
            lid = both[self._other]
            for place in self.around(4, 0.075) + 0.075:
                lid.to(y=_SHUT + place, step=self.uniform(0.01, 0.03)).wait(2)
        both[self._hand].to(roll=0.0).wait(1)
        return start, both


def script_pieces(rng: np.random.Generator, home: Mapping[str, Sequence[float]]) -> Iterator[ScriptedPiece[PotStart]]:
    """The pieces, each with the hands in either part.

    Args:
        rng: draws starts and the unsteadiness of the person's hands.
        home: where each hand usually is, y, z [m]; where there is one alone, nobody can show how to pour.
    """
    for number, hand in enumerate(home):
        other = next((h for h in home if h != hand), "")
        script = _Script(rng, hand, other, home)
        holds = {what: (f"{hand}->{what}",) for what in (LID, JUG)}
        plan: list[tuple[Callable[[], _LAID], tuple[str, ...]]] = [
            (script.miss_lid, (*holds[LID], f"{LID}->{POT}")),
            (script.slide_lid, (*holds[LID], f"{LID}->{POT}")),
            (script.miss_jug, holds[JUG]),
            (script.move_jug, holds[JUG]),
        ]
        if other:
            every = (*holds[JUG], f"{other}->{LID}", f"{LID}->{POT}", f"{JUG}->{POT}")
            pours = [script.pour_all, script.pour_steps, script.pour_onto]
            gates = [script.sweep_open, script.sweep_shut, script.work_lid]
            plan += [(lay_out, every) for lay_out in (*pours, *gates)]
        for lay_out, shows in plan:
            start, hands = lay_out()
            yield ScriptedPiece(f"{lay_out.__name__}_{number}", start, hands.commands, shows)
    for number, hand in enumerate(home):
        start, hands = _Script(rng, hand, "", home).release_lid()
        yield ScriptedPiece(f"release_lid_{number}", start, hands.commands, (f"{hand}->{LID}", f"{LID}->{POT}"))
