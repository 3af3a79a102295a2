"""The tank of a water dispenser: a cup is poured into it, it heats, it lets water out (paper sec. VI)."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import ClassVar, Unpack

import numpy as np

from ichain_drake.errors import InputError
from ichain_drake.objects.base import ObjectArguments, ParentStates, WorldObject
from ichain_drake.objects.camera import FRAME as CAMERA
from ichain_drake.objects.camera import CameraFrame
from ichain_drake.objects.parents import level_index, position_indices
from ichain_drake.objects.region import Region
from ichain_drake.objects.vessels.vessel import AMOUNT_NOISE, CAPACITY, Exchange, bookkeeping, contents, fill
from ichain_drake.state import BoolArray, FloatArray, Role, StateSpace, Variable, wrap_angle

_CONTENTS = 3  # variables
_POSE_NOISE = (0.0015, 0.0015, 0.0015, 0.01)  # as that of a cup's reading [m, rad]
_THRESHOLD = 3  # a level above it triggers (paper sec. VI)


@dataclass(frozen=True)
class TankSettings:
    """What a scenario gives about a tank.

    Attributes:
        inlet: where the mouth of a cup must be to pour into the tank, in the robot's frame.
        drain_rate: amount that leaves in a second while dispensing (paper sec. VI: 1/16).
        heat_rate: rise of temperature in a second while heating (paper sec. VI: 1/80).
        drain, heater: names of the two buttons among the parents; empty for none.
        camera: frame in which cups are seen.
        stands: x, y, z [m] and turn about the vertical [rad] of the machine in the robot's frame, where the camera sees
            it; None where it doesn't, so that nothing is measured of where it is.
    """

    inlet: Region = field(default_factory=lambda: Region((0.68, 0.06, 0.37), (0.04, 0.04, 0.07)))
    drain_rate: float = 1.0 / 16.0
    heat_rate: float = 1.0 / 80.0
    drain: str = "dispense"
    heater: str = "power"
    camera: CameraFrame = field(default_factory=CameraFrame)
    stands: tuple[float, float, float, float] | None = None


class Tank(WorldObject):
    """The tank. Its parents: cups that pour into it, and two buttons.

    Args:
        tank: see `TankSettings`.
        parents, initial, settings: see `WorldObject`.

    Raises:
        InputError: if a button that `tank` names is no parent or has no level, or a parent is neither button nor cup.
    """

    state_space: ClassVar[StateSpace]

    @staticmethod
    def space(givers: Sequence[str] = ("cup",), *, seen: bool = False) -> StateSpace:
        """The state space of a tank that certain cups pour into; with its place and turn where these are seen."""
        hidden = (Variable("heat_added", hidden=True), *bookkeeping(givers))
        pose = [Variable(a, "m", role=Role("position", CAMERA, a)) for a in "xyz"] if seen else []
        if seen:
            pose.append(Variable("turn", "rad", -math.pi, math.pi, "angle", Role("orientation", CAMERA, "z")))
        return StateSpace("tank", (*contents("amount"), *hidden, *pose))

    def __init__(
        self,
        name: str,
        parents: Mapping[str, StateSpace],
        tank: TankSettings | None = None,
        **given: Unpack[ObjectArguments],
    ) -> None:
        self.tank = tank or TankSettings()
        buttons = {self.tank.drain, self.tank.heater} - {""}
        self._levels = {b: level_index(parents, b, name, "a button that acts on it") for b in sorted(buttons)}
        cups = [p for p in parents if p not in buttons]
        for cup in cups:
            if "flow" not in parents[cup].names:
                raise InputError(f"{name}: its parent {cup} is neither one of its buttons nor a vessel")
        self.state_space = self.space(cups, seen=self.tank.stands is not None)  # type: ignore[misc]
        super().__init__(name, parents, **given)
        self._exchange = Exchange(name, self.state_space, parents)
        self._heat = self.state_space.index("heat_added")
        self._cups = {c: position_indices(parents[c], "xyz", name, c) for c in cups}

    def state_at(self, amount: float, temperature: float) -> FloatArray:
        """A state with this content, at rest, shape (n_variables,).

        Raises:
            InputError: if a value is outside 0..1.
        """
        state = self.default_state()
        fill(self.state_space, state, amount, temperature, self.get_name())
        return state

    def default_state(self) -> FloatArray:
        """Empty and cold, where it stands."""
        state = np.zeros(len(self.state_space))
        if self.tank.stands is not None:
            state[-len(_POSE_NOISE) :] = *self.tank.camera.from_robot(np.array(self.tank.stands[:3])), self._turned()
        return state

    def _turned(self) -> float:
        """Its turn in the camera's frame [rad]."""
        assert self.tank.stands is not None
        return float(wrap_angle(self.tank.stands[3] + self.tank.camera.yaw))

    def step(
        self, state: FloatArray, parents: ParentStates, active: Mapping[str, FloatArray], noise: FloatArray, dt: float
    ) -> FloatArray:
        """Take what is poured, let out, then heat what is there."""
        s = np.asarray(state, dtype=float).T
        out = np.zeros_like(s[0])
        if self.tank.drain:
            out = np.asarray(active[self.tank.drain]).T * np.minimum(dt * self.tank.drain_rate, s[0])
        new = self._exchange.step(s, parents, out)
        if self.tank.heater:
            heated = np.minimum(new[1] + np.asarray(active[self.tank.heater]).T * dt * self.tank.heat_rate, 1.0)
            new[self._heat] += new[0] * (heated - new[1])
            new[1] = heated
        return new.T

    def settle(self, state: FloatArray, parents: ParentStates, active: Mapping[str, bool]) -> FloatArray:
        """Tell the cups whether it takes what they give."""
        new = np.array(state, dtype=float)
        self._exchange.show(new, active)
        return new

    def decide_active(
        self, state: FloatArray, parents: ParentStates, active: Mapping[str, bool], touch: float | None
    ) -> Mapping[str, bool]:
        """A cup while its mouth is above the inlet; a button while its level is above 3 (paper sec. VI)."""
        on = {}
        for parent in self.parents:
            if parent in self._cups:
                mouth = self.tank.camera.to_robot(parents[parent][self._cups[parent]])
                on[parent] = self.tank.inlet.holds(mouth.tolist(), active[parent])
            else:  # the level itself has hysteresis
                on[parent] = bool(parents[parent][self._levels[parent]] > _THRESHOLD)
        return on

    def decide_rows(
        self, state: FloatArray, parents: ParentStates, active: Mapping[str, BoolArray]
    ) -> Mapping[str, BoolArray]:
        """See `DecidesRows`."""
        on = {}
        for parent, values in parents.items():
            if parent in self._cups:
                mouth = self.tank.camera.to_robot(values[:, self._cups[parent]])
                on[parent] = self.tank.inlet.holds_rows(mouth.T, active[parent])
            else:
                on[parent] = values[:, self._levels[parent]] > _THRESHOLD
        return on

    def measure(self, state: FloatArray, noise: FloatArray) -> FloatArray:
        """Amount, temperature and change with noise; its place too where it is seen."""
        std = np.full(noise.shape[-1], AMOUNT_NOISE)
        std[_CONTENTS:] = _POSE_NOISE[: len(std) - _CONTENTS]
        read = state[..., self._observable] + std * noise
        read[..., :_CONTENTS] = np.clip(read[..., :_CONTENTS], [0.0, 0.0, -CAPACITY], CAPACITY)
        return read


Tank.state_space = Tank.space()
