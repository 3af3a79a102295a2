"""Who demonstrates scenarios with a steering wheel: a hand that plays with it, and a scripted driver for a person."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from pydrake.systems.framework import Context, DiscreteValues

from ichain_drake.scenarios.scripted_driver import ScriptedDriver, Sight, WanderStyle, correlated
from ichain_drake.simulation.commands import Commands
from ichain_drake.state import FloatArray, StateSpace

HandForWheel = Callable[[FloatArray], FloatArray]
"""From angle [rad] and slide [m], shape (..., 2), to the hand that leads the knob there, (..., n_hand)."""

_KEEP = 0.6  # of a tremble, from one tick to the next


class WheelPlayer(Commands):
    """Leads the knob to random places within reach, in steps that the hand can make within a tick.

    Args:
        hand_for_wheel: where the hand is for a state of the wheel.
        reach: farthest from the middle: angle [rad], slide [m].
        step: farthest in one tick.
        ticks: how many commands.
        seed: of the places.
    """

    def __init__(
        self, hand_for_wheel: HandForWheel, reach: FloatArray, step: FloatArray, ticks: int, seed: Sequence[int]
    ) -> None:
        super().__init__(hand_for_wheel(random_walk(reach, step, ticks + 1, np.random.default_rng(seed))))
        self.set_name("player")


def random_walk(reach: FloatArray, step: FloatArray, count: int, rng: np.random.Generator) -> FloatArray:
    """Places in a box around 0, uniformly drawn and approached in steps, both axes straight at once, (count, n)."""
    place, goal = np.zeros(len(reach)), rng.uniform(-reach, reach)
    places = []
    for _ in range(count):
        if np.allclose(place, goal):
            goal = rng.uniform(-reach, reach)
        needed = float(np.max(np.abs(goal - place) / step))
        place = place + (goal - place) / max(1.0, needed)
        places.append(place)
    return np.array(places)


@dataclass(frozen=True, kw_only=True)
class DriverStyle(WanderStyle):
    """How a scripted driver drives with a wheel.

    Attributes:
        gains: range of the wheel's angle per bearing error [1], drawn for each leg.
        damping: wheel's angle per yaw rate [s].
        slide_per_speed, slide_gain: of the column per wanted speed, and per missing speed [s].
        tremble: standard deviation of an unsteady hand: angle [rad], slide [m].
        reach, step: most angle [rad] and slide [m], and most change in a tick.
        speeds, near, patience: see `WanderStyle`; in metres.
    """

    damping: float
    slide_per_speed: float
    slide_gain: float
    tremble: tuple[float, float]
    reach: tuple[float, float]
    step: tuple[float, float]


class WheelDriver(ScriptedDriver):
    """A scripted driver or helmsman; see `ScriptedDriver`. Moves the wheel as a hand in a tick does.

    Args:
        hand_for_wheel: where the driver's hand is for a state of the wheel.
        driven: name and observable state space of what is driven: a pose in the plane, then its speed; the last
            variable is its yaw rate.
        size: extent of the plane [m].
        style: see `DriverStyle`.
        ticks: how many decisions.
        seed: of places, speeds and unsteadiness.
    """

    def __init__(
        self,
        hand_for_wheel: HandForWheel,
        driven: tuple[str, StateSpace],
        size: tuple[float, float],
        style: DriverStyle,
        ticks: int,
        seed: Sequence[int],
    ) -> None:
        self._hand_for_wheel = hand_for_wheel
        self._style = style
        (name, space), extent = driven, np.array(size)
        super().__init__(
            (name, len(space)),
            (0.12 * extent, 0.88 * extent),
            style,
            lambda white: correlated(white, _KEEP, math.sqrt(1 - _KEEP * _KEEP)) * style.tremble,
            ticks,
            seed,
            hand_for_wheel(np.zeros(2)),
        )
        self._wheel = self.DeclareDiscreteState(2)

    def steer(self, sight: Sight, context: Context, discrete: DiscreteValues) -> FloatArray:
        """The wheel by the angle off, the column by the missing speed, both no faster than a hand."""
        style = self._style
        angle = sight.gain * sight.off - style.damping * sight.seen[-1]
        slide = style.slide_per_speed * sight.speed + style.slide_gain * (sight.speed - sight.seen[3])
        wanted = np.clip(np.array([angle, slide]) + sight.tremble, np.negative(style.reach), style.reach)
        last = context.get_discrete_state(self._wheel).value()
        wheel = last + np.clip(wanted - last, np.negative(style.step), style.step)
        discrete.set_value(self._wheel, wheel)
        return self._hand_for_wheel(wheel)
