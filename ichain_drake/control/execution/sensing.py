"""How noisy readings are in a run: what was learned of sensors is how they were as demonstrations were recorded."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ichain_drake.control.planning.plan import States
from ichain_drake.control.settings import EXECUTION
from ichain_drake.learning.model import InteractionModel
from ichain_drake.learning.noise import HALF_NORMAL
from ichain_drake.learning.settings import LEARNING
from ichain_drake.state import FloatArray

_SPREAD = 1.5  # standard error of a spread read off a median, times the root of the number of readings


@dataclass(frozen=True)
class SensorNoise:
    """What readings of a run tell of their noise.

    Second differences of what stands still, or moves evenly, are those of its noise alone, with six times the variance
    of a reading (the residuals of Gasser, Sroka and Jennen-Steinmetz, Biometrika 73, 1986); their median is hardly
    moved by what speeds up now and then.

    Attributes:
        steps: the last change of every variable of all objects, joined; empty before the second reading.
        bends: changes of these, the newest last.
    """

    steps: FloatArray = field(default_factory=lambda: np.zeros(0))
    bends: tuple[FloatArray, ...] = ()

    def seen(self, model: InteractionModel, before: States, now: States) -> SensorNoise:
        """The same with one more reading.

        Args:
            model: names the objects.
            before, now: successive readings, shape (n_variables,) each.

        Returns:
            What is known with it; this one is left as it is.
        """
        spaces = {n: s.observable for n, s in model.graph.objects.items()}
        steps = np.concatenate([s.difference(now[n], before[n]) for n, s in spaces.items()])
        if not self.steps.size:
            return SensorNoise(steps)
        return SensorNoise(steps, (*self.bends[1 - EXECUTION.noise_rows :], np.abs(steps - self.steps)))

    def in_force(self, model: InteractionModel) -> InteractionModel:
        """A model with the noise of this run where that is surely larger than was learned.

        Surely: by two standard errors of the estimate. What is read exactly, or in whole numbers, stays as learned.

        Args:
            model: as learned.

        Returns:
            The same model, the very object where nothing is louder.
        """
        if len(self.bends) < EXECUTION.readings:
            return model
        spread = np.median(self.bends, axis=0) / (HALF_NORMAL * np.sqrt(6.0))
        surely = spread * max(0.0, 1.0 - LEARNING.sure * _SPREAD / np.sqrt(len(self.bends)))
        noise, at = {}, 0
        for name, space in model.graph.objects.items():
            known = model.noise[name]
            part = slice(at, at + len(known))
            at += len(known)
            louder = (surely[part] > known) & (known > 0) & ~space.observable.jump_mask
            noise[name] = np.where(louder, spread[part], known)
        return model if all(np.array_equal(noise[n], model.noise[n]) for n in noise) else model.with_noise(noise)
