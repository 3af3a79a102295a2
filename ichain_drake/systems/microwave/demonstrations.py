"""Who demonstrates the microwave oven: a script that stands in for a person at the remote control.

Each piece is a list of hand commands, laid out from its own random start. Pieces show skills and the borders of
interactions, not the task: none holds more than two of its steps.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from ichain_drake.scenarios.scripted_piece import ScriptedPiece
from ichain_drake.scenarios.unsteady_hand import UnsteadyHand
from ichain_drake.systems.microwave.layout import LAYOUT, MicrowaveStart, Point
from ichain_drake.systems.microwave.teleoperation import HOLD, SAFE, OvenTeleoperation, part_point

OPEN, IN = LAYOUT.door.travel, LAYOUT.button.travel
_HALF = 0.5
_LONG = 0.003  # m of a pull or push beyond an end, along which the hand slips
_WIDE = 0.035  # m to either side of something in which a person tries whether it works there

Laid = tuple[MicrowaveStart, OvenTeleoperation]


class _Script(UnsteadyHand):
    """Random starts and the pieces laid out from them."""

    def __init__(self, rng: np.random.Generator, *, bodies: bool) -> None:
        super().__init__(rng)
        self._bodies = bodies

    def table(self) -> tuple[float, float]:
        """A place before and beside the oven."""
        return self.uniform(0.615, 0.645), self.uniform(-0.31, -0.25)

    def inside(self) -> tuple[float, float]:
        """A place in the cavity."""
        return self.uniform(0.735, 0.775), self.uniform(0.035, 0.05)

    def slack(self) -> Point:
        """How far off a person grasps [m]."""
        return self.uniform(-0.005, 0.005), self.uniform(-0.005, 0.005), self.uniform(-0.008, 0.008)

    def near(self) -> Point:
        """The same at a small part."""
        return self.uniform(-0.004, 0.004), self.uniform(-0.004, 0.004), self.uniform(-0.006, 0.006)

    def hand(self) -> tuple[float, ...]:
        """An open hand before the oven."""
        return self.uniform(SAFE - 0.02, SAFE), self.uniform(-0.15, 0.05), self.uniform(0.12, 0.22), 0.0, 0.0

    def start(self, *, inside: bool = False, **values: float) -> MicrowaveStart:
        """A start with random values where none are given."""
        place = self.inside() if inside else self.table()
        free = {"temperature": self.uniform(0.0, 0.9), "button": 0.0, "knob": self.uniform(0.0, 0.4)} | values
        return MicrowaveStart(place, hand=self.hand(), **free)  # type: ignore[arg-type]

    # Door.

    def open_door(self) -> Laid:
        start = self.start(door=0.0)
        hand = OvenTeleoperation(start.hand)
        return start, self._move_door(hand, 0.0, OPEN)

    def shut_door(self) -> Laid:
        start = self.start(door=OPEN)
        hand = OvenTeleoperation(start.hand)
        return start, self._move_door(hand, OPEN, 0.0)

    def _move_door(self, hand: OvenTeleoperation, start: float, end: float) -> OvenTeleoperation:
        """Grasp it, move it a little beyond an end, let go."""
        beyond = end + (_LONG if end > start else -_LONG)
        return hand.take_part("door", start, self.slack()).slide("door", beyond).leave()

    def miss_door(self) -> Laid:
        """The hand closes beside the handle, too far, too high and too low, and just so: the gate of the grasp."""
        at = self.uniform(0.05, 0.15)
        start = self.start(door=at)
        hand = self._misses(OvenTeleoperation(start.hand), part_point("door", at))
        return start, self._move_door(hand, at, 0.0)

    def _misses(self, hand: OvenTeleoperation, point: Point, roll: float = 0.0) -> OvenTeleoperation:
        """Closes before, behind, beside, over and under something; fingers between bodies only stay short of it."""
        for axis in (0,) if self._bodies else (0, 1, 2):
            for far in (*self.between(2, -0.06, -0.045), -0.01) if self._bodies else self.around(8, _WIDE):
                off = list(self.near())
                off[axis] = far
                goal = [p + o for p, o in zip(point, off, strict=True)]
                hand.to(goal[0], goal[1], goal[2], roll, step=0.05).grip(True).grip(False)
        return hand.to(SAFE)

    # Button.

    def press_button(self) -> Laid:
        """With the food outside, so that nothing comes of it."""
        start = self.start(button=0.0)
        hand = OvenTeleoperation(start.hand)
        for _ in range(2):
            hand.take_part("button", 0.0, self.near()).slide("button", IN + _LONG).wait(2).leave()
            hand.take_part("button", IN, self.near()).slide("button", -_LONG).wait(2).leave()
        return start, hand

    def press_by_and_by(self) -> Laid:
        """Small steps in and out: where the oven goes on and off, with the food inside and the door shut."""
        start = self.start(button=0.0, inside=True, knob=self.uniform(0.8, 1.2), temperature=self.uniform(0.1, 0.3))
        hand = OvenTeleoperation(start.hand).take_part("button", 0.0, self.near())
        for share in (*self.between(12, 0.0, 1.0), 1.0, 0.0):
            hand.slide("button", share * IN).wait(2)
        return start, hand.leave()

    def miss_button(self) -> Laid:
        at = IN * float(self._rng.integers(2))
        start = self.start(button=at)
        return start, self._misses(OvenTeleoperation(start.hand), part_point("button", at))

    # Knob.

    def turn_knob(self) -> Laid:
        """Several grasps, each with another roll of the hand."""
        angle = self.uniform(0.0, 0.4)
        start = self.start(knob=angle, door=OPEN if self.uniform(0.0, 1.0) < _HALF else 0.0)
        hand = OvenTeleoperation(start.hand)
        for goal in (self.uniform(0.7, 1.1), self.uniform(1.4, 1.7), self.uniform(0.2, 0.5), 0.0):
            roll = self.uniform(-0.2, 0.2) - 0.5 * angle
            hand.take(LAYOUT.knob.point, self.near(), roll).to(roll=roll - (goal - angle)).wait(1).leave()
            angle = goal
        return start, hand.to(roll=0.0)

    def miss_knob(self) -> Laid:
        start = self.start()
        return start, self._misses(OvenTeleoperation(start.hand), LAYOUT.knob.point)

    # Food. The door stands open while it is handled, in and out of the oven.

    def relocate(self) -> Laid:
        start = self.start(door=OPEN)
        hand, place = OvenTeleoperation(start.hand), start.food
        for _ in range(2):
            off, goal = self.slack(), self.table()
            hand.take_food(place, off).lift()
            hand.to(self.uniform(0.57, 0.60), self.uniform(-0.2, 0.0), self.uniform(0.1, 0.2)).carry_out(goal, off)
            place = goal
        return start, self._move_door(hand, OPEN, 0.0)

    def miss_food(self) -> Laid:
        start = self.start(door=OPEN)
        hand = self._misses(OvenTeleoperation(start.hand), (*start.food, HOLD))
        return start, self._move_door(hand, OPEN, 0.0)

    def in_and_out(self) -> Laid:
        """Across the doorstep to and fro: where the food is inside."""
        start = self.start(inside=True, door=OPEN)
        off, (_, y) = self.slack(), start.food
        hand = OvenTeleoperation(start.hand).take_food(start.food, off).to(z=LAYOUT.cavity[2] + HOLD + 0.01)
        for x in (*self.between(8, 0.66, 0.75), self.inside()[0]):
            hand.to(x, y + self.uniform(-0.01, 0.01), step=0.012)
        hand.to(z=LAYOUT.cavity[2] + HOLD + off[2] + 0.0015).leave()
        return start, self._move_door(hand, OPEN, 0.0)

    def shut_in(self) -> Laid:
        """Food behind a door that is shut, or half open, can't be taken; once it is open, it can."""
        at = self.uniform(0.0, 0.12)
        start = self.start(inside=True, door=at)
        hand, (x, y) = OvenTeleoperation(start.hand), start.food
        self._grab_in_vain(hand, (x, y), 4)
        self._move_door(hand, at, OPEN)
        off, goal = self.slack(), self.table()
        return start, hand.take_food((x, y), off).lift().carry_out(goal, off)

    def _grab_in_vain(self, hand: OvenTeleoperation, place: tuple[float, float], times: int) -> OvenTeleoperation:
        """The hand closes where the food is, but for the door; between bodies it stays before the door."""
        for _ in range(times):
            off = self.slack()
            ahead = 0.56 if self._bodies else place[0] + off[0]
            hand.to(ahead, place[1] + off[1], LAYOUT.cavity[2] + HOLD + off[2]).grip(True).wait(1)
            hand.to(SAFE if self._bodies else ahead - 0.05).grip(False)
        return hand.to(SAFE)

    # Heating: food, door and button each start and stop it, in the same pieces.

    def put_in(self) -> Laid:
        """The food is put into the open oven, whatever its button says."""
        start = self.start(door=OPEN, button=IN * float(self._rng.integers(2)))
        off, place = self.slack(), self.inside()
        return start, OvenTeleoperation(start.hand).take_food(start.food, off).lift().carry_in(place, off).wait(2)

    def heat_by_shutting(self) -> Laid:
        """The oven is on already, so that shutting the door starts it; its button stops it."""
        start = self.start(
            inside=True, door=OPEN, button=IN, knob=self.uniform(0.6, 1.6), temperature=self.uniform(0.05, 0.3)
        )
        hand = self._move_door(OvenTeleoperation(start.hand), OPEN, 0.0).wait(4)
        return start, hand.take_part("button", IN, self.near()).slide("button", -_LONG).wait(12).leave()

    def switch(self) -> Laid:
        """Switched on and off; behind the shut door the food can't be taken."""
        start = self.start(inside=True, button=0.0, knob=self.uniform(0.6, 1.6), temperature=self.uniform(0.1, 0.4))
        hand = OvenTeleoperation(start.hand)
        hand.take_part("button", 0.0, self.near()).wait(4).slide("button", IN + _LONG).wait(4)
        hand.slide("button", -_LONG).wait(10).slide("button", IN + _LONG).wait(4).leave()
        return start, self._grab_in_vain(hand, start.food, 2)

    def take_out(self) -> Laid:
        """Out of the open oven, which is then shut, and runs empty."""
        start = self.start(inside=True, door=OPEN, button=IN, knob=self.uniform(0.6, 1.6))
        off, goal = self.slack(), self.table()
        hand = OvenTeleoperation(start.hand).take_food(start.food, off).lift().carry_out(goal, off)
        return start, self._move_door(hand, OPEN, 0.0).wait(3)

    def heat_by_door(self) -> Laid:
        """The oven is on; opened the door stops it: where it counts as shut, in small steps."""
        start = self.start(
            inside=True, button=IN, knob=self.uniform(0.6, 1.5), door=0.10, temperature=self.uniform(0.05, 0.2)
        )
        hand = OvenTeleoperation(start.hand).take_part("door", 0.10, self.slack())
        for at in (*self.between(12, 0.0, 0.05), 0.10, -_LONG):
            hand.slide("door", at, step=0.025).wait(2)
        return start, hand.leave()

    def heat_by_knob(self) -> Laid:
        """The oven is on; the hand on the knob sets how fast it heats."""
        start = self.start(inside=True, button=IN, knob=0.0, temperature=self.uniform(0.05, 0.15))
        hand = OvenTeleoperation(start.hand).take(LAYOUT.knob.point, self.near(), self.uniform(-0.1, 0.1))
        at = float(hand.now[3])
        for angle in (0.4, 1.7, 0.9, 0.0, 1.3):
            goal = np.clip(angle + self.uniform(-0.1, 0.05), 0.0, LAYOUT.knob.travel)
            hand.to(roll=at - float(goal)).wait(8)
        return start, hand.to(roll=at).wait(3).leave().to(roll=0.0)

    def heat_long(self) -> Laid:
        """Fully turned up until it is hot."""
        start = self.start(inside=True, button=IN, knob=0.0, temperature=self.uniform(0.35, 0.45))
        hand = OvenTeleoperation(start.hand).take(LAYOUT.knob.point, self.near(), self.uniform(-0.1, 0.1))
        at = float(hand.now[3])
        hand.to(roll=at - self.uniform(1.6, 1.75)).wait(32).to(roll=at).leave()
        return start, hand.to(roll=0.0)

    def heat_nothing(self) -> Laid:
        """The oven runs, but the food is outside."""
        start = self.start(button=IN, knob=0.0)
        hand = OvenTeleoperation(start.hand).take(LAYOUT.knob.point, self.near(), 0.0)
        hand.to(roll=-1.5).wait(6).to(roll=0.0).leave()
        return start, hand.take_part("button", IN, self.near()).slide("button", -_LONG).leave()


def script_pieces(rng: np.random.Generator, *, bodies: bool = False) -> Iterator[ScriptedPiece[MicrowaveStart]]:
    """The pieces, unordered, none the whole task.

    Args:
        rng: draws starts and the unsteadiness of the person's hand.
        bodies: whether door and food are bodies that stop the hand.
    """
    script = _Script(rng, bodies=bodies)
    door, button, knob = ("hand->door",), ("hand->button",), ("hand->knob",)
    empty, through_door = (*button, *knob), (*door, "hand->food")
    shut_in = (*through_door, "door->food")
    heat = ("knob->food", "button->food", "door->food")
    turning_up, switching, shutting = (*knob, *heat), (*button, *heat), (*door, *button, *heat)
    pieces: dict[str, tuple[Callable[[], Laid], tuple[str, ...]]] = {
        "heat_by_knob_1": (script.heat_by_knob, turning_up),
        "switch_1": (script.switch, switching),
        "take_out_1": (script.take_out, shut_in),
        "miss_food": (script.miss_food, through_door),
        "press_by_and_by": (script.press_by_and_by, switching),
        "open_door": (script.open_door, door),
        "heat_nothing": (script.heat_nothing, empty),
        "miss_knob": (script.miss_knob, knob),
        "put_in_1": (script.put_in, ("hand->food", "door->food")),
        "heat_by_shutting_1": (script.heat_by_shutting, shutting),
        "heat_by_door_1": (script.heat_by_door, (*door, *heat)),
        "turn_knob_1": (script.turn_knob, knob),
        "shut_in_1": (script.shut_in, shut_in),
        "heat_long": (script.heat_long, turning_up),
        "miss_door": (script.miss_door, door),
        "press_button": (script.press_button, button),
        "switch_2": (script.switch, switching),
        "take_out_2": (script.take_out, shut_in),
        "relocate": (script.relocate, through_door),
        "shut_door": (script.shut_door, door),
        "heat_by_door_2": (script.heat_by_door, (*door, *heat)),
        "miss_button": (script.miss_button, button),
        "in_and_out": (script.in_and_out, shut_in),
        "turn_knob_2": (script.turn_knob, knob),
        "shut_in_2": (script.shut_in, shut_in),
        "put_in_2": (script.put_in, ("hand->food", "door->food")),
        "heat_by_shutting_2": (script.heat_by_shutting, shutting),
        "heat_by_knob_2": (script.heat_by_knob, turning_up),
    }
    for name, (lay_out, shows) in pieces.items():
        start, hand = lay_out()
        yield ScriptedPiece(name, start, hand.commands, shows)
