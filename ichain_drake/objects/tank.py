"""The tank of a water dispenser: a cup is poured into it, it heats, it lets water out (paper sec. VI)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
from pydrake.geometry import Box, Cylinder
from pydrake.math import RigidTransform

from ichain_drake.errors import InputError
from ichain_drake.objects.base import ObjectSettings, ParentStates, WorldObject
from ichain_drake.objects.camera import CameraFrame
from ichain_drake.objects.region import Region
from ichain_drake.objects.vessel import AMOUNT_NOISE, CAPACITY, Exchange, bookkeeping, contents, fill
from ichain_drake.state import FloatArray, StateSpace, Variable

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
    """

    inlet: Region = field(default_factory=lambda: Region((0.68, 0.06, 0.37), (0.04, 0.04, 0.07)))
    drain_rate: float = 1.0 / 16.0
    heat_rate: float = 1.0 / 80.0
    drain: str = "dispense"
    heater: str = "power"
    camera: CameraFrame = field(default_factory=CameraFrame)


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
    def space(givers: Sequence[str] = ("cup",)) -> StateSpace:
        """The state space of a tank that certain cups pour into."""
        hidden = (Variable("heat_added", hidden=True), *bookkeeping(givers))
        return StateSpace("tank", (*contents("amount"), *hidden))

    def __init__(
        self,
        name: str,
        parents: Mapping[str, StateSpace],
        initial: FloatArray | None = None,
        settings: ObjectSettings | None = None,
        tank: TankSettings | None = None,
    ) -> None:
        self.tank = tank or TankSettings()
        buttons = {self.tank.drain, self.tank.heater} - {""}
        for button in sorted(buttons):
            if button not in parents or not len(parents[button].role_indices("level")):
                raise InputError(f"{name}: {button!r} is to be a button that acts on it, but is no parent with a level")
        cups = [p for p in parents if p not in buttons]
        for cup in cups:
            if "flow" not in parents[cup].names:
                raise InputError(f"{name}: its parent {cup} is neither one of its buttons nor a vessel")
        self.state_space = self.space(cups)  # type: ignore[misc]
        super().__init__(name, parents, initial, settings)
        self._exchange = Exchange(name, self.state_space, parents)
        self._heat = self.state_space.index("heat_added")
        self._cups = {c: [int(i) for i in _position(parents[c], name, c)] for c in cups}
        self._levels = {b: int(parents[b].role_indices("level")[0]) for b in buttons}

    def state_at(self, amount: float, temperature: float) -> FloatArray:
        """A state with this content, at rest, shape (n_variables,).

        Raises:
            InputError: if a value is outside 0..1.
        """
        state = np.zeros(len(self.state_space))
        fill(self.state_space, state, amount, temperature, self.get_name())
        return state

    def default_state(self) -> FloatArray:
        """Empty and cold."""
        return np.zeros(len(self.state_space))

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

    def measure(self, state: FloatArray, noise: FloatArray) -> FloatArray:
        """Amount, temperature and change with noise."""
        read = state[..., self._observable] + AMOUNT_NOISE * noise
        return np.clip(read, [0.0, 0.0, -CAPACITY], CAPACITY)


Tank.state_space = Tank.space()


def _position(space: StateSpace, name: str, parent: str) -> list[int]:
    found = {v.role.axis: i for i, v in enumerate(space.variables) if v.role and v.role.kind == "position"}
    for axis in ("x", "y", "z"):
        if axis not in found:
            raise InputError(f"{name}: its parent {parent} has no position along {axis}")
    return [found[a] for a in ("x", "y", "z")]


class TankDrawing:
    """A gauge: a column of water whose height is the amount and whose colour the temperature.

    Args:
        foot: lower end of the gauge in the robot's frame [m].
        radius, height: of the gauge when full [m].
        outlet: of the dispenser, in the robot's frame [m].
        fall: how far its jet falls [m].
        boxes: lower and upper corners of the machine's parts [m], where no plant draws them.
    """

    def __init__(
        self,
        foot: tuple[float, float, float],
        radius: float,
        height: float,
        outlet: tuple[float, float, float],
        fall: float,
        boxes: Sequence[Sequence[float]] = (),
    ) -> None:
        self._foot, self._radius, self._height = foot, radius, height
        self._outlet, self._fall = outlet, fall
        self._flow = Tank.state_space.index("flow")
        self._boxes = [np.array(b).reshape(2, 3) for b in boxes]

    def setup(self, scene: Any) -> None:
        """Create gauge, water, jet and machine."""
        for k, (low, high) in enumerate(self._boxes):
            scene.shape(f"part_{k}", Box(*(high - low)), (0.75, 0.78, 0.82, 1.0), RigidTransform(0.5 * (low + high)))
        scene.place("gauge", RigidTransform(np.array(self._foot)))
        tube = RigidTransform([0, 0, self._height / 2])
        scene.shape("gauge/tube", Cylinder(self._radius * 1.25, self._height), (0.85, 0.9, 0.95, 0.25), tube)
        scene.shape("gauge/water/column", Cylinder(self._radius, self._height), water_color(0.0), tube)
        x, y, z = self._outlet
        jet = RigidTransform([x, y, z - self._fall / 2])
        scene.shape("jet", Box(0.006, 0.006, self._fall), water_color(0.0), jet)

    def update(self, scene: Any, time: float, state: FloatArray) -> None:
        """Level, colour, and the jet while water leaves."""
        color = water_color(float(state[1]))
        scene.scale("gauge/water", (1.0, 1.0, float(state[0])), time)
        scene.color("gauge/water/column", color, time)
        scene.visible("jet", bool(state[self._flow] > 0), time)
        scene.color("jet", color, time)


def water_color(temperature: float) -> tuple[float, float, float]:
    """Linear RGB from blue (cold) to red (hot)."""
    t = min(max(temperature, 0.0), 1.0)
    return (0.02 + 0.75 * t, 0.12 * (1 - t) + 0.02, 0.75 * (1 - t) + 0.02)
