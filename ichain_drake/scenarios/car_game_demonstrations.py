"""Who demonstrates the car game: a hand that plays with the joystick, and a scripted driver in place of a person."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from pydrake.systems.framework import Context, LeafSystem, State

from ichain_drake.objects.joystick import tilt_from_axes
from ichain_drake.scenarios.commands import Commands
from ichain_drake.state import FloatArray, wrap_angle
from ichain_drake.timing import FRAME, FRAMES_PER_TICK

HandForTilt = Callable[[FloatArray], FloatArray]


class Player(Commands):
    """Sends the hand to random places within reach, in steps that it can make within a tick.

    Args:
        middle: x, y of the joystick [m].
        reach: farthest from the middle along each axis [m].
        step: farthest in one tick along each axis [m].
        ticks: how many commands.
        seed: of the places.
    """

    def __init__(self, middle: FloatArray, reach: float, step: float, ticks: int, seed: Sequence[int]) -> None:
        super().__init__(middle + _random_walk(reach, step, ticks + 1, np.random.default_rng(seed)))
        self.set_name("player")


def _random_walk(reach: float, step: float, count: int, rng: np.random.Generator) -> FloatArray:
    """Places in a square of half-width `reach`, uniformly drawn and approached in steps, shape (count, 2)."""
    place, goal = np.zeros(2), rng.uniform(-reach, reach, 2)
    places = []
    for _ in range(count):
        if np.allclose(place, goal):
            goal = rng.uniform(-reach, reach, 2)
        place = place + np.clip(goal - place, -step, step)
        places.append(place)
    return np.array(places)


class Driver(LeafSystem):
    """A scripted driver: heads for random places at random speeds with an unsteady hand, correcting at every tick.

    Stands in for the paper's human demonstrator. Moves the stick as a hand in a tick does: there within four frames,
    then held.

    Args:
        hand_for_tilt: where the driver's hand is for a tilt of the stick.
        size: width and height of the screen [px].
        ticks: how many decisions.
        seed: of places, speeds and unsteadiness.
    """

    def __init__(self, hand_for_tilt: HandForTilt, size: tuple[float, float], ticks: int, seed: Sequence[int]) -> None:
        super().__init__()
        self.set_name("driver")
        self._hand_for_tilt = hand_for_tilt
        rng = np.random.default_rng(seed)
        width, height = size
        legs = ticks + 1
        self._places = rng.uniform([0.1 * width, 0.13 * height], [0.9 * width, 0.87 * height], (legs, 2))
        self._speeds = rng.uniform(20.0, 68.0, legs)
        self._gains = rng.uniform(0.6, 2.2, legs)
        self._tremble = _correlated(rng.standard_normal((ticks + 1, 2)), 0.5, 0.3)
        self._car = self.DeclareVectorInputPort("car", 5)
        self._command = self.DeclareDiscreteState(hand_for_tilt(tilt_from_axes(np.zeros(2))))
        self._memory = self.DeclareDiscreteState(3)  # frame, leg, ticks on this leg
        self.DeclareStateOutputPort("hand_command", self._command)
        self.DeclarePeriodicUnrestrictedUpdateEvent(FRAME, 0.0, self._decide)

    def _decide(self, context: Context, state: State) -> None:
        frame, leg, since = (int(v) for v in context.get_discrete_state(self._memory).value())
        discrete = state.get_mutable_discrete_state()
        if frame % FRAMES_PER_TICK == 0:
            x, y, heading, speed, _ = self._car.Eval(context)
            since += 1
            place = self._places[leg]
            if np.hypot(place[0] - x, place[1] - y) < 35 or since > 14:
                leg, since = min(leg + 1, len(self._places) - 1), 0
                place = self._places[leg]
            off = float(wrap_angle(np.arctan2(place[1] - y, place[0] - x) - heading))
            wanted = self._speeds[leg]
            throttle = (0.8 * wanted + 0.8 * wanted**2 / 90.0) / 90.0 + 0.03 * (wanted - speed)
            tremble = self._tremble[min(frame // FRAMES_PER_TICK, len(self._tremble) - 1)]
            axes = np.clip(np.array([self._gains[leg] * off, throttle]) + tremble, -1.0, 1.0)
            discrete.set_value(self._command, self._hand_for_tilt(tilt_from_axes(axes)))
        discrete.set_value(self._memory, [frame + 1, leg, since])


def _correlated(white: FloatArray, keep: float, size: float) -> FloatArray:
    """First-order correlated noise from white noise, shape (n, k)."""
    out = np.zeros_like(white)
    for i in range(1, len(white)):
        out[i] = keep * out[i - 1] + size * white[i]
    return out
