"""The hand as an object: its seven variables, and which of them a scenario lets its robot object show."""

# No `from __future__ import annotations`: Drake's typed YAML reader needs the fields' types themselves.

import math
from collections.abc import Collection
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ichain_drake.errors import InputError
from ichain_drake.settings import setting
from ichain_drake.state import FloatArray, Role, StateSpace, Variable

FRAME = "robot"

_ON_AXIS = 1e-9  # [m]


def _position(axis: str, lower: float, upper: float) -> Variable:
    return Variable(axis, "m", lower, upper, role=Role("position", FRAME, axis))


def _orientation(name: str, axis: str) -> Variable:
    return Variable(name, "rad", -math.pi, math.pi, "angle", Role("orientation", FRAME, axis))


#: All variables of a hand (see `ichain_drake.robot.pose` for what the angles mean); grip is 1 closed, 0 open.
HAND = StateSpace(
    "hand",
    (
        _position("x", -0.9, 0.9),
        _position("y", -0.9, 0.9),
        _position("z", 0.0, 1.1),
        _orientation("yaw", "z"),
        _orientation("pitch", "y"),
        _orientation("roll", "x"),
        Variable("grip", "1", 0.0, 1.0, "binary"),
    ),
)
X, Y, Z, YAW, PITCH, ROLL, GRIP = range(7)


@dataclass
class SphereSurface:
    """Given geometry: the hand's z follows x and y on the upper half of a sphere.

    Attributes:
        center: centre in the robot frame, 3 values [m].
        radius: [m].
    """

    center: list[float] = setting(lambda: [0.0, 0.0, 0.0], "m", size=3, lower=-10, upper=10)
    radius: float = setting(0.1, "m", above=0, upper=10)

    def height(self, x: ArrayLike, y: ArrayLike) -> FloatArray:
        """Height z [m] at x, y [m] of any one shape; outside the sphere's outline, that of its equator."""
        dx = np.asarray(x, dtype=float) - self.center[0]
        dy = np.asarray(y, dtype=float) - self.center[1]
        return self.center[2] + np.sqrt(np.maximum(self.radius * self.radius - dx * dx - dy * dy, 0.0))


@dataclass
class RingPath:
    """Given geometry: the hand keeps to a circle about a vertical axis; between two places it goes round, not across.

    Attributes:
        center: x, y of the axis in the robot frame, 2 values [m].
        radius: [m].
    """

    center: list[float] = setting(lambda: [0.0, 0.0], "m", size=2, lower=-10, upper=10)
    radius: float = setting(0.1, "m", above=0, upper=10)

    def check(self, exposed: Collection[str]) -> None:
        """Refuse a ring that can't be kept to.

        Raises:
            InputError: if x or y is not among the exposed variables, or it is no circle.
        """
        if not {"x", "y"} <= set(exposed):
            raise InputError("hand: x and y keep to the ring; expose both")
        if len(self.center) != 2 or not self.radius > 0:
            raise InputError("hand.ring: give center as [x, y] and a radius above 0, in metres")

    def nearest(self, xy: FloatArray) -> FloatArray:
        """Nearest points of the circle, shape (..., 2) in and out [m]; for the axis itself, the one in front (-x)."""
        away = xy - np.asarray(self.center, dtype=float)
        distance = np.hypot(away[..., 0], away[..., 1])[..., None]
        direction = np.where(distance > _ON_AXIS, away / np.maximum(distance, _ON_AXIS), [-1.0, 0.0])
        return np.asarray(self.center, dtype=float) + self.radius * direction


@dataclass
class HandSpec:
    """Which variables of the hand the robot object has, and what the others are held at.

    Attributes:
        exposed: names from `HAND`, in the order of the robot object's state.
        held: values of the others; an angle or grip that is not named is held at 0.
        surface: where given, z is not exposed but follows x and y.
        ring: where given, x and y are drawn onto its circle.
        bounds: bounds that replace those of `HAND`, by variable: `[lower, upper]`.
        noise_std: standard deviation of the sensor noise of `measured`, by variable; 0 where not named.
    """

    exposed: list[str] = field(default_factory=lambda: list(HAND.names))
    held: dict[str, float] = setting(dict, "m or rad")
    surface: SphereSurface | None = None
    bounds: dict[str, list[float]] = setting(dict, "m or rad")
    noise_std: dict[str, float] = setting(dict, "m or rad", lower=0, upper=1)
    ring: RingPath | None = None

    # Set up at first use, not in __post_init__: Drake's YAML reader fills the fields after construction.
    @cached_property
    def space(self) -> StateSpace:
        """State space of the robot object, shape of its state (n_exposed,).

        Raises:
            InputError: on a name that is not the hand's, one that is both exposed and held, a missing position, bad
                bounds, or a surface or ring that doesn't fit what is exposed.
        """
        for key, names in (("held", self.held), ("bounds", self.bounds), ("noise_std", self.noise_std)):
            for name in names:
                if name not in HAND.names:
                    raise InputError(f"hand.{key}: no variable {name!r}; a hand has {', '.join(HAND.names)}")
        if not self.exposed:
            raise InputError("hand.exposed is empty: name at least one variable")
        for name in ("x", "y", "z"):
            if name not in self.exposed and name not in self.held and not (name == "z" and self.surface):
                raise InputError(f"hand: {name} is neither exposed nor held; add it to one of the two")
        for name in self.exposed:
            if name in self.held:
                raise InputError(f"hand: {name} is both exposed and held; remove it from one of the two")
        variables = []
        for variable in HAND.subspace(self.exposed).variables:
            limits = self.bounds.get(variable.name)
            if limits is not None and len(limits) != 2:
                raise InputError(f"hand.bounds: {variable.name} needs [lower, upper], not {limits}")
            variables.append(replace(variable, lower=limits[0], upper=limits[1]) if limits else variable)
        if self.surface is not None and ("z" in self.exposed or "z" in self.held):
            raise InputError("hand: z follows the surface; remove it from exposed and held")
        if self.ring is not None:
            self.ring.check(self.exposed)
        return StateSpace("hand", tuple(variables))

    @cached_property
    def indices(self) -> NDArray[np.intp]:
        """Places of the exposed variables in the full hand state, shape (n_exposed,)."""
        return HAND.indices(self.space.names)

    @cached_property
    def _template(self) -> FloatArray:
        values = np.zeros(len(HAND))
        for name, value in self.held.items():
            values[HAND.index(name)] = value
        return values

    def full(self, exposed: ArrayLike) -> FloatArray:
        """The full hand state. Shape (..., n_exposed) in, (..., 7) out."""
        value = np.asarray(exposed, dtype=float)
        indices = self.indices
        out = np.empty((*value.shape[:-1], len(HAND)))
        out[...] = self._template
        out[..., indices] = value
        if self.ring is not None:
            out[..., :2] = self.ring.nearest(out[..., :2])
        if self.surface is not None:
            out[..., Z] = self.surface.height(out[..., X], out[..., Y])
        return out

    def reduce(self, full: ArrayLike) -> FloatArray:
        """The exposed variables of a full hand state. Shape (..., 7) in, (..., n_exposed) out."""
        return np.asarray(full, dtype=float)[..., self.indices]

    def noise_vector(self) -> FloatArray:
        """Standard deviations of the exposed variables' noise, shape (n_exposed,).

        Raises:
            InputError: if one is negative.
        """
        std = np.array([self.noise_std.get(name, 0.0) for name in self.space.names], dtype=float)
        if (std < 0).any():
            raise InputError(f"hand.noise_std: {self.space.names[int(np.argmin(std))]} is negative")
        return std
