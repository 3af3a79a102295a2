"""Who demonstrates scenarios with a steering wheel: a hand that plays with it, and a scripted driver for a person."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from pydrake.systems.framework import Context, LeafSystem, State

from ichain_drake.scenarios.commands import Commands
from ichain_drake.state import FloatArray, StateSpace, wrap_angle
from ichain_drake.timing import FRAME, FRAMES_PER_TICK

HandForWheel = Callable[[FloatArray], FloatArray]
"""From angle [rad] and slide [m], shape (..., 2), to the hand that leads the knob there, (..., n_hand)."""


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


@dataclass(frozen=True)
class DriverStyle:
    """How a scripted driver drives.

    Attributes:
        speeds: range that the speed of a leg is drawn from [m/s].
        arrival: a place counts as reached this far away [m].
        leg: ticks after which another place is headed for.
        gains: range of the wheel's angle per bearing error [1], drawn for each leg.
        damping: wheel's angle per yaw rate [s].
        slide_per_speed, slide_gain: of the column per wanted speed, and per missing speed [s].
        tremble: standard deviation of an unsteady hand: angle [rad], slide [m].
        reach, step: most angle [rad] and slide [m], and most change in a tick.
    """

    speeds: tuple[float, float]
    arrival: float
    leg: int
    gains: tuple[float, float]
    damping: float
    slide_per_speed: float
    slide_gain: float
    tremble: tuple[float, float]
    reach: tuple[float, float]
    step: tuple[float, float]


class WheelDriver(LeafSystem):
    """A scripted driver or helmsman: heads for random places at random speeds with an unsteady hand.

    Stands in for a person who is watched. Corrects at every tick, and moves the wheel as a hand in a tick does.

    Ports: input named after the object driven, for its `measured`; output `hand_command`.

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
        super().__init__()
        self.set_name("driver")
        self._hand_for_wheel = hand_for_wheel
        self._style = style
        rng = np.random.default_rng(seed)
        legs = ticks + 1
        extent = np.array(size)
        self._places = rng.uniform(0.12 * extent, 0.88 * extent, (legs, 2))
        self._speeds = rng.uniform(*style.speeds, legs)
        self._gains = rng.uniform(*style.gains, legs)
        self._tremble = _correlated(rng.standard_normal((ticks + 1, 2)), 0.6) * style.tremble
        name, space = driven
        self._driven = self.DeclareVectorInputPort(name, len(space))
        self._command = self.DeclareDiscreteState(hand_for_wheel(np.zeros(2)))
        self._memory = self.DeclareDiscreteState(3)  # frame, leg, ticks on this leg
        self._wheel = self.DeclareDiscreteState(2)
        self.DeclareStateOutputPort("hand_command", self._command)
        self.DeclarePeriodicUnrestrictedUpdateEvent(FRAME, 0.0, self._decide)

    def _decide(self, context: Context, state: State) -> None:
        frame, leg, since = (int(v) for v in context.get_discrete_state(self._memory).value())
        discrete = state.get_mutable_discrete_state()
        if frame % FRAMES_PER_TICK == 0:
            style = self._style
            seen = self._driven.Eval(context)
            since += 1
            away = self._places[leg] - seen[:2]
            if np.hypot(*away) < style.arrival or since > style.leg:
                leg, since = min(leg + 1, len(self._places) - 1), 0
                away = self._places[leg] - seen[:2]
            off = float(wrap_angle(np.arctan2(away[1], away[0]) - seen[2]))
            angle = self._gains[leg] * off - style.damping * seen[-1]
            speed = self._speeds[leg]
            slide = style.slide_per_speed * speed + style.slide_gain * (speed - seen[3])
            wanted = np.array([angle, slide]) + self._tremble[min(frame // FRAMES_PER_TICK, len(self._tremble) - 1)]
            wanted = np.clip(wanted, np.negative(style.reach), style.reach)
            last = context.get_discrete_state(self._wheel).value()
            wheel = last + np.clip(wanted - last, np.negative(style.step), style.step)
            discrete.set_value(self._wheel, wheel)
            discrete.set_value(self._command, self._hand_for_wheel(wheel))
        discrete.set_value(self._memory, [frame + 1, leg, since])


def _correlated(white: FloatArray, keep: float) -> FloatArray:
    """First-order correlated noise of unit spread from white noise, shape (n, k)."""
    out = np.zeros_like(white)
    for i in range(1, len(white)):
        out[i] = keep * out[i - 1] + np.sqrt(1 - keep * keep) * white[i]
    return out
