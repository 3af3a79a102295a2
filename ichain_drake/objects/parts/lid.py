"""A lid on rails that a spring shuts: it stays open only while a hand holds it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import ClassVar, Unpack

import numpy as np

from ichain_drake.errors import InputError
from ichain_drake.objects.base import ObjectArguments, ParentStates, WorldObject
from ichain_drake.objects.hands import Hands
from ichain_drake.objects.region import GATE
from ichain_drake.state import FloatArray, Role, StateSpace, Variable

POSITION_NOISE = 0.001
"""Standard deviation of a reading of the handle's place [m]."""


@dataclass(frozen=True)
class LidMount:
    """Where a lid is: geometry that a scenario gives.

    Attributes:
        shut: place of its handle when it is shut, y, z in the robot's frame [m].
        travel: how far it opens, along y [m].
        reach: how far from the handle, along y and z, a hand that closes takes it [m].
        spring: speed at which it shuts [m/s].
    """

    shut: tuple[float, float] = (0.0, 0.19)
    travel: float = 0.16
    reach: tuple[float, float] = field(default=(0.02, 0.025), metadata={GATE: True})
    spring: float = 0.8


class Lid(WorldObject):
    """The lid, by the place of its handle. Its parents are hands with a position along y and z and a grip.

    Args:
        mount: where it is.
        parents, initial, settings: see `WorldObject`.

    Raises:
        InputError: if there is no parent, one is no hand, or the mount can't be.
    """

    state_space: ClassVar[StateSpace]
    immediate: ClassVar[bool] = True

    @staticmethod
    def space(hands: tuple[str, ...] = ("hand",)) -> StateSpace:
        """The state space of a lid that certain hands may hold."""
        place = [Variable(a, "m", -2.0, 2.0, role=Role("position", "robot", a)) for a in "yz"]
        return StateSpace("lid", (*place, *Hands.variables(hands)))

    def __init__(
        self,
        name: str,
        parents: Mapping[str, StateSpace],
        mount: LidMount | None = None,
        **given: Unpack[ObjectArguments],
    ) -> None:
        self.mount = mount or LidMount()
        if not (self.mount.travel > 0 and self.mount.spring > 0 and min(self.mount.reach) > 0):
            raise InputError(f"{name}: travel, reach and spring of a lid are above 0; got {self.mount}")
        self.state_space = self.space(tuple(parents))  # type: ignore[misc]
        self._hands = Hands(name, self.state_space, parents, self.mount.reach)
        super().__init__(name, parents, **given)

    def default_state(self) -> FloatArray:
        """Shut."""
        state = np.zeros(len(self.state_space))
        state[:2] = self.mount.shut
        return state

    def decide_active(
        self, state: FloatArray, parents: ParentStates, active: Mapping[str, bool], touch: float | None
    ) -> Mapping[str, bool]:
        """A hand, from closing around the handle until it opens."""
        return self._hands.holding(state, parents, active)

    def step(
        self, state: FloatArray, parents: ParentStates, active: Mapping[str, FloatArray], noise: FloatArray, dt: float
    ) -> FloatArray:
        """Where the hand has its handle; else the spring shuts it."""
        shut, travel = self.mount.shut[0], self.mount.travel
        new = np.array(state, dtype=float)
        y = np.maximum(new[..., 0] - self.mount.spring * dt, shut)
        for hand, (at, _) in self._hands.places.items():
            held = np.asarray(active[hand]) > 0.5  # noqa: PLR2004
            y = np.where(held, np.clip(parents[hand][..., at], shut, shut + travel), y)
        new[..., 0] = y
        self._hands.remember(new, parents)
        return new

    def measure(self, state: FloatArray, noise: FloatArray) -> FloatArray:
        """The handle's place with noise."""
        return state[..., self._observable] + POSITION_NOISE * noise


Lid.state_space = Lid.space()
