"""A kettle: a vessel that a hand moves and pours by its spout, and that heats while it stands on its plate."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import ClassVar, Unpack

import numpy as np

from ichain_drake.errors import InputError
from ichain_drake.objects.base import ObjectArguments, ParentStates
from ichain_drake.objects.parents import level_index
from ichain_drake.objects.region import Region
from ichain_drake.objects.vessels.cup import UPRIGHT, Cup, inclination
from ichain_drake.objects.vessels.cup_settings import CupSettings
from ichain_drake.objects.vessels.vessel import CAPACITY
from ichain_drake.state import FloatArray, StateSpace, Variable

_THRESHOLD = 3  # a level above it heats, as in the dispenser (paper sec. VI)


@dataclass(frozen=True)
class KettleSettings:
    """What a scenario gives about a kettle, beside what it gives about any vessel (`CupSettings`).

    Attributes:
        plate: where the spout's tip is while the kettle stands on its plate, in the robot's frame.
        switch: name of the switch among the parents; empty for none.
        heat_rate: rise of temperature in a second [1/s].
        spout_from: tilt towards the spout at which a full kettle begins to pour [rad].
        spout_emptying: how much more until nothing stays in [rad].
    """

    plate: Region = field(default_factory=lambda: Region((0.735, 0.045, 0.135), (0.02, 0.02, 0.01)))
    switch: str = "switch"
    heat_rate: float = 1.0 / 40.0
    spout_from: float = 0.3
    spout_emptying: float = 0.8


class Kettle(Cup):
    """The kettle. Its parents: one hand, vessels that are poured into it, and a switch.

    Its position is that of the tip of its spout, which it pours over while it is tilted about x by a positive angle;
    tilted otherwise, it runs over its rim later, as a cup does. The switch heats what is in it while its level is above
    3 and the kettle stands on its plate.

    Args:
        kettle: see `KettleSettings`.
        parents, initial, settings, cup: see `Cup`.

    Raises:
        InputError: as `Cup`; if the switch is no parent with a level, or a rate can't be.
    """

    state_space: ClassVar[StateSpace]

    @staticmethod
    def space(givers: Sequence[str] = ("bottle",)) -> StateSpace:
        """The state space of a kettle that certain vessels are poured into."""
        return StateSpace("kettle", (*Cup.space(givers).variables, Variable("heat_added", hidden=True)))

    def __init__(
        self,
        name: str,
        parents: Mapping[str, StateSpace],
        cup: CupSettings | None = None,
        kettle: KettleSettings | None = None,
        **given: Unpack[ObjectArguments],
    ) -> None:
        self.kettle = kettle or KettleSettings()
        switch = self.kettle.switch
        self._level = level_index(parents, switch, name, "the switch that heats it") if switch else -1
        if not (self.kettle.heat_rate > 0 and self.kettle.spout_emptying > 0):
            raise InputError(f"{name}: heat_rate and spout_emptying must be above 0; correct KettleSettings")
        self._heaters = (switch,) if switch else ()
        super().__init__(name, parents, cup, **given)
        self._heat = self.state_space.index("heat_added")

    def step(
        self, state: FloatArray, parents: ParentStates, active: Mapping[str, FloatArray], noise: FloatArray, dt: float
    ) -> FloatArray:
        """Give and take as a cup does, then heat what is there."""
        new = super().step(state, parents, active, noise, dt).T
        if self.kettle.switch:
            water, warm = new[self._water], new[self._water + 1]
            heated = np.minimum(warm + np.asarray(active[self.kettle.switch]).T * dt * self.kettle.heat_rate, 1.0)
            new[self._heat] += water * (heated - warm)
            new[self._water + 1] = heated
        return new.T

    def stays(self, s: FloatArray) -> FloatArray:
        """How much it holds as it is tilted, by the spout or over the rim, shape (n_variables, ...) -> (...)."""
        over = (s[3] - self.kettle.spout_from) / self.kettle.spout_emptying
        return np.minimum(super().stays(s), np.minimum(np.maximum(1.0 - over, 0.0), 1.0) * CAPACITY)

    def decide_active(
        self, state: FloatArray, parents: ParentStates, active: Mapping[str, bool], touch: float | None
    ) -> Mapping[str, bool]:
        """As a cup; the switch while its level is above 3 and the kettle stands on its plate."""
        on = dict(super().decide_active(state, parents, active, touch))
        switch = self.kettle.switch
        if switch:
            tip = self.cup.camera.to_robot(state[:3]).tolist()
            stands = float(inclination(state[3], state[self._lean])) < UPRIGHT
            stands = stands and self.kettle.plate.holds(tip, active[switch])
            on[switch] = stands and bool(parents[switch][self._level] > _THRESHOLD)
        return on


Kettle.state_space = Kettle.space()
