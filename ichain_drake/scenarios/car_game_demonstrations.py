"""Who demonstrates games with a joystick: a hand that plays with it, and a scripted driver in place of a person."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

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


def _cruise(speed: float) -> float:
    """Throttle at which the car of the car game keeps a speed [px/s]."""
    return (0.8 * speed + 0.8 * speed**2 / 90.0) / 90.0


@dataclass(frozen=True)
class DrivingStyle:
    """What a driver knows about a car; the values are those for the car game.

    Attributes:
        name: of the object.
        variables: how many of it are measured; the first four are x, y, heading and speed.
        speeds: lowest and highest speed that is wanted, in the game's unit a second.
        gains: lowest and highest steering per angle off [1/rad]; below 0 where the stick to the right turns the
            heading down.
        cruise: throttle that keeps a speed.
        throttle_gain: throttle per speed that is missing.
        near: a place counts as reached within this distance.
        patience: ticks after which a place is given up.
        tremble: standard deviation of the hand's unsteadiness, of an axis.
    """

    name: str = "car"
    variables: int = 5
    speeds: tuple[float, float] = (20.0, 68.0)
    gains: tuple[float, float] = (0.6, 2.2)
    cruise: Callable[[float], float] = _cruise
    throttle_gain: float = 0.03
    near: float = 35.0
    patience: int = 14
    tremble: float = 0.3


class Driver(LeafSystem):
    """A scripted driver: heads for random places at random speeds with an unsteady hand, correcting at every tick.

    Stands in for the paper's human demonstrator. Moves the stick as a hand in a tick does: there within four frames,
    then held.

    Args:
        hand_for_tilt: where the driver's hand is for a tilt of the stick.
        size: width and height of the screen [px].
        ticks: how many decisions.
        seed: of places, speeds and unsteadiness.
        style: how to drive.
    """

    def __init__(
        self,
        hand_for_tilt: HandForTilt,
        size: tuple[float, float],
        ticks: int,
        seed: Sequence[int],
        style: DrivingStyle | None = None,
    ) -> None:
        super().__init__()
        self.set_name("driver")
        self._hand_for_tilt = hand_for_tilt
        self._style = style = style or DrivingStyle()
        rng = np.random.default_rng(seed)
        width, height = size
        legs = ticks + 1
        self._places = rng.uniform([0.1 * width, 0.13 * height], [0.9 * width, 0.87 * height], (legs, 2))
        self._speeds = rng.uniform(*style.speeds, legs)
        self._gains = rng.uniform(*style.gains, legs)
        self._tremble = _correlated(rng.standard_normal((ticks + 1, 2)), 0.5, style.tremble)
        self._car = self.DeclareVectorInputPort(style.name, style.variables)
        self._command = self.DeclareDiscreteState(hand_for_tilt(tilt_from_axes(np.zeros(2))))
        self._memory = self.DeclareDiscreteState(3)  # frame, leg, ticks on this leg
        self.DeclareStateOutputPort("hand_command", self._command)
        self.DeclarePeriodicUnrestrictedUpdateEvent(FRAME, 0.0, self._decide)

    def _decide(self, context: Context, state: State) -> None:
        frame, leg, since = (int(v) for v in context.get_discrete_state(self._memory).value())
        discrete = state.get_mutable_discrete_state()
        if frame % FRAMES_PER_TICK == 0:
            x, y, heading, speed = self._car.Eval(context)[:4]
            since += 1
            place, style = self._places[leg], self._style
            if np.hypot(place[0] - x, place[1] - y) < style.near or since > style.patience:
                leg, since = min(leg + 1, len(self._places) - 1), 0
                place = self._places[leg]
            off = float(wrap_angle(np.arctan2(place[1] - y, place[0] - x) - heading))
            wanted = self._speeds[leg]
            throttle = style.cruise(wanted) + style.throttle_gain * (wanted - speed)
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
