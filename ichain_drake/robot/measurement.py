"""What the hand's own sensors report: its state with Gaussian noise, and a flag that it is valid."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from pydrake.systems.framework import BasicVector, Context, DiscreteValues, LeafSystem

from ichain_drake.noise import NoiseStream
from ichain_drake.robot.hand import HandSpec
from ichain_drake.state import FloatArray
from ichain_drake.timing import FRAME


class HandMeasurement(LeafSystem):
    """Adds noise to the hand's state, drawn anew each 1/30 s frame.

    A variable's id in the noise stream is its place in `HAND`, not in the exposed list: exposing another variable
    changes no stream. The context holds only the frame counter.

    Ports: input `state` (n_exposed); outputs `measured` (n_exposed), `valid` (1).
    """

    def __init__(self, spec: HandSpec, seed: int, object_id: int) -> None:
        super().__init__()
        n = len(spec.space)
        std = spec.noise_vector()
        self._noisy = np.flatnonzero(std)
        self._std = std[self._noisy]
        self.noise = NoiseStream(seed, object_id, "measurement", tuple(int(spec.indices[i]) for i in self._noisy))
        self._state = self.DeclareVectorInputPort("state", n)
        tickets = {self._state.ticket()}
        if len(self._noisy):
            self.DeclareDiscreteState(1)
            self.DeclarePeriodicDiscreteUpdateEvent(FRAME, 0.0, self._update)
            tickets.add(self.xd_ticket())
        self.DeclareVectorOutputPort("measured", n, self._calc, tickets)
        self.DeclareVectorOutputPort("valid", 1, lambda _, out: out.SetFromVector([1.0]), {self.nothing_ticket()})

    def set_hand(self, context: Context) -> None:
        """Let the frame counter follow the context's time."""
        if len(self._noisy):
            context.SetDiscreteState([math.ceil(context.get_time() / FRAME - 1e-6)])

    def _calc(self, context: Context, output: BasicVector) -> None:
        value = self._state.Eval(context)
        frame = int(context.get_discrete_state_vector().value()[0]) if len(self._noisy) else 0
        output.SetFromVector(self.read(value, self.noise.at(frame)))

    def read(self, state: FloatArray, noise: FloatArray) -> FloatArray:
        """What the sensors give, shape (..., n).

        Args:
            state: shape (..., n).
            noise: standard normal, of the variables that are read with any, shape (..., n_noisy).
        """
        value = state.copy()
        if len(self._noisy):
            value[..., self._noisy] += self._std * noise
        return value

    def readings(self, states: FloatArray, frames: Sequence[int]) -> FloatArray:
        """What `measured` showed at some frames of a run, to the last bit.

        Args:
            states: the hand's at these frames, shape (n, n_exposed).
            frames: their numbers from the start of the run.
        """
        return self.read(states, self.noise.rows(frames))

    def _update(self, context: Context, discrete: DiscreteValues) -> None:
        discrete.get_mutable_value()[0] += 1.0
