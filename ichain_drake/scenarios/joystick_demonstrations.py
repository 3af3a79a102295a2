"""Who demonstrates games with a joystick: a hand that plays with it, and a scripted driver in place of a person."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from pydrake.systems.framework import Context, DiscreteValues

from ichain_drake.objects.controls.joystick import tilt_from_axes
from ichain_drake.scenarios.scripted_driver import ScriptedDriver, Sight, WanderStyle, correlated
from ichain_drake.simulation.commands import Commands
from ichain_drake.state import FloatArray

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


@dataclass(frozen=True, kw_only=True)
class DrivingStyle(WanderStyle):
    """What a driver knows about a car; the values are those for the car game.

    Attributes:
        name: of the object.
        variables: how many of it are measured; the first four are x, y, heading and speed.
        gains: lowest and highest steering per angle off [1/rad]; below 0 where the stick to the right turns the
            heading down.
        cruise: throttle that keeps a speed.
        throttle_gain: throttle per speed that is missing.
        tremble: standard deviation of the hand's unsteadiness, of an axis.
        speeds, near, patience: see `WanderStyle`.
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


class Driver(ScriptedDriver):
    """A scripted driver with a joystick; see `ScriptedDriver`.

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
        self._hand_for_tilt = hand_for_tilt
        self._style = style = style or DrivingStyle()
        (width, height), size_of_tremble = size, style.tremble
        super().__init__(
            (style.name, style.variables),
            (np.array([0.1 * width, 0.13 * height]), np.array([0.9 * width, 0.87 * height])),
            style,
            lambda white: correlated(white, 0.5, size_of_tremble),
            ticks,
            seed,
            hand_for_tilt(tilt_from_axes(np.zeros(2))),
        )

    def steer(self, sight: Sight, context: Context, discrete: DiscreteValues) -> FloatArray:
        """Steering by the angle off, throttle by the missing speed."""
        style = self._style
        throttle = style.cruise(sight.speed) + style.throttle_gain * (sight.speed - sight.seen[3])
        axes = np.clip(np.array([sight.gain * sight.off, throttle]) + sight.tremble, -1.0, 1.0)
        return self._hand_for_tilt(tilt_from_axes(axes))
