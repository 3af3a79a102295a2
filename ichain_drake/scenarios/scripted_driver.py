"""What scripted drivers share who stand in for a person: they head for random places with an unsteady hand."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from pydrake.systems.framework import Context, DiscreteValues, State

from ichain_drake.control.ticks import TickSystem
from ichain_drake.state import FloatArray, wrap_angle


@dataclass(frozen=True, kw_only=True)
class WanderStyle:
    """How a scripted driver chooses where to go.

    Attributes:
        speeds: range that the wanted speed of a leg is drawn from, in the path's unit a second.
        gains: range of steering per angle off, drawn for each leg.
        near: a place counts as reached within this distance.
        patience: ticks after which a place is given up.
    """

    speeds: tuple[float, float]
    gains: tuple[float, float]
    near: float
    patience: int


@dataclass(frozen=True)
class Sight:
    """What a driver goes by at one tick.

    Attributes:
        seen: what is measured of what is driven.
        off: angle from its heading to the place it heads for [rad].
        gain, speed: of this leg.
        tremble: of the hand, shape (2,).
    """

    seen: FloatArray
    off: float
    gain: float
    speed: float
    tremble: FloatArray


class ScriptedDriver(TickSystem):
    """Heads for random places at random speeds, correcting at every tick. Stands in for a person who is watched.

    Ports: input named after what is driven, for its `measured`; output `hand_command`. A subclass implements `steer`.

    Args:
        driven: name of what is driven, and how many of its variables are measured: a pose in the plane first.
        field: lowest and highest place that is headed for, shape (2,) each.
        style: see `WanderStyle`.
        tremble: from white noise, shape (n_ticks, 2), to how the hand trembles at each tick.
        ticks: how many decisions.
        seed: of places, speeds, gains and unsteadiness.
        initial_command: before the first decision, shape (n_hand,).
    """

    def __init__(
        self,
        driven: tuple[str, int],
        field: tuple[FloatArray, FloatArray],
        style: WanderStyle,
        tremble: Callable[[FloatArray], FloatArray],
        ticks: int,
        seed: Sequence[int],
        initial_command: FloatArray,
    ) -> None:
        super().__init__("driver")
        self._near, self._patience = style.near, style.patience
        rng = np.random.default_rng(seed)
        legs = ticks + 1
        self._places = rng.uniform(*field, (legs, 2))
        self._speeds = rng.uniform(*style.speeds, legs)
        self._gains = rng.uniform(*style.gains, legs)
        self._tremble = tremble(rng.standard_normal((ticks + 1, 2)))
        self._driven = self.DeclareVectorInputPort(*driven)
        self._command = self.DeclareDiscreteState(initial_command)
        self._memory = self.DeclareDiscreteState(2)  # leg, ticks on this leg
        self.DeclareStateOutputPort("hand_command", self._command)

    @abstractmethod
    def steer(self, sight: Sight, context: Context, discrete: DiscreteValues) -> FloatArray:
        """The hand command of a tick, shape (n_hand,).

        Args:
            sight: what to go by.
            context: as it is at t.
            discrete: state to be changed, where a subclass keeps any.
        """

    def decide(self, context: Context, state: State, tick: int) -> None:
        """Head for the place of this leg, or of the next."""
        leg, since = (int(v) for v in context.get_discrete_state(self._memory).value())
        discrete = state.get_mutable_discrete_state()
        seen = self._driven.Eval(context)
        since += 1
        away = self._places[leg] - seen[:2]
        if np.hypot(*away) < self._near or since > self._patience:
            leg, since = min(leg + 1, len(self._places) - 1), 0
            away = self._places[leg] - seen[:2]
        off = float(wrap_angle(np.arctan2(away[1], away[0]) - seen[2]))
        tremble = self._tremble[min(tick, len(self._tremble) - 1)]
        sight = Sight(seen, off, self._gains[leg], self._speeds[leg], tremble)
        discrete.set_value(self._command, self.steer(sight, context, discrete))
        discrete.set_value(self._memory, [leg, since])


def correlated(white: FloatArray, keep: float, size: float) -> FloatArray:
    """First-order correlated noise from white noise, shape (n, k).

    Args:
        white: shape (n, k).
        keep: what is left of a value in the next row.
        size: what a row of white noise adds to it.
    """
    out = np.zeros_like(white)
    for i in range(1, len(white)):
        out[i] = keep * out[i - 1] + size * white[i]
    return out
