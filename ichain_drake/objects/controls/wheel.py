"""A steering wheel on a sprung sliding column: the hand leads its knob round and up, it reports angle and slide."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from pydrake.geometry import Box, Capsule, Cylinder
from pydrake.math import RigidTransform, RotationMatrix

from ichain_drake.objects.base import ParentStates
from ichain_drake.objects.controls.knob import KnobControl
from ichain_drake.state import FloatArray, StateSpace, Variable

TRAVEL = 0.025
"""Slide of the column to each side, of full gas and full brake [m]."""

READ_NOISE = (0.002, 0.0001)
"""Standard deviations of the readings of angle [rad] and slide [m]."""

_RETURN_TIME = 0.03  # [s] a released column springs back; the angle stays
_LIMIT = math.radians(150.0)
_RIM, _SPOKES = 24, 3


@dataclass(frozen=True)
class WheelMount:
    """Where the wheel lies: geometry that a scenario gives.

    Attributes:
        center: of the rim at rest, in the robot's frame [m].
        radius: of the rim, on which the knob sits [m].
        knob: height of the knob's centre over the rim [m].
    """

    center: tuple[float, float, float] = (0.47, 0.0, 0.12)
    radius: float = 0.11
    knob: float = 0.045

    def knob_from_wheel(self, wheel: FloatArray) -> FloatArray:
        """Position of the knob's centre in the robot's frame [m], shape (..., 3), from angle and slide (..., 2)."""
        wheel = np.asarray(wheel, dtype=float)
        x = self.center[0] - self.radius * np.cos(wheel[..., 0])
        y = self.center[1] - self.radius * np.sin(wheel[..., 0])
        return np.stack([x, y, self.center[2] + self.knob + wheel[..., 1]], axis=-1)

    def wheel_from_knob(self, position: FloatArray) -> FloatArray:
        """Angle [rad] and slide [m] of a wheel whose knob is led to a place, shape (..., 3) -> (..., 2).

        The knob can't leave its circle: only the bearing counts. Clipped to the mechanical limits.
        """
        position = np.asarray(position, dtype=float)
        angle = np.arctan2(self.center[1] - position[..., 1], self.center[0] - position[..., 0])
        slide = position[..., 2] - (self.center[2] + self.knob)
        return np.stack([np.clip(angle, -_LIMIT, _LIMIT), np.clip(slide, -TRAVEL, TRAVEL)], axis=-1)


class Wheel(KnobControl[WheelMount]):
    """The wheel. Its one parent is an object that has a position (x, y, z): a hand that holds the knob.

    Args:
        mount: where it lies.
        parents, initial, settings: see `WorldObject`.

    Raises:
        InputError: if the parent has no position along x, y and z.
    """

    state_space: ClassVar[StateSpace] = StateSpace(
        "wheel",
        (
            # Not of kind angle: it ends at +-150 deg and never wraps.
            Variable("angle", "rad", -_LIMIT, _LIMIT, measured_in="plant"),
            Variable("slide", "m", -0.03, 0.03, measured_in="plant"),
        ),
    )
    mount_class: ClassVar[type[WheelMount]] = WheelMount
    knob_axes: ClassVar[tuple[str, ...]] = ("x", "y", "z")

    def step(
        self, state: FloatArray, parents: ParentStates, active: Mapping[str, FloatArray], noise: FloatArray, dt: float
    ) -> FloatArray:
        """Held: the knob is where the hand is. Released: the spring brings the column back, the angle stays."""
        held = self.mount.wheel_from_knob(parents[self._hand][..., self._knob])
        free = state * [1.0, math.exp(-dt / _RETURN_TIME)]
        on = np.asarray(active[self._hand])[..., None] > 0.5
        return np.where(on, held, free)

    def sample_body(self, body: FloatArray) -> FloatArray:
        """Angle and slide from the joints: slide, turn, and the knob's spin."""
        return body[..., [1, 0]]

    def measure(self, state: FloatArray, noise: FloatArray) -> FloatArray:
        """Angle and slide with read noise."""
        return state + np.array(READ_NOISE) * noise


class WheelDrawing:
    """Post, column, rim, spokes and knob, for physics in which no plant holds the wheel."""

    def __init__(self, mount: WheelMount) -> None:
        self._mount = mount

    def setup(self, scene: Any) -> None:
        """Create the shapes."""
        x, y, z = self._mount.center
        r, knob = self._mount.radius, self._mount.knob
        dark, steel = (0.12, 0.12, 0.14, 1.0), (0.45, 0.47, 0.50, 1.0)
        scene.shape("foot", Cylinder(0.055, 0.012), dark, RigidTransform([x, y, 0.006]))
        scene.shape(
            "sleeve", Cylinder(0.024, z - 0.05), (0.25, 0.27, 0.30, 1.0), RigidTransform([x, y, (z - 0.04) / 2])
        )
        scene.shape("wheel/column", Cylinder(0.014, 0.09), steel, RigidTransform([0, 0, -0.045]))
        scene.shape("wheel/hub", Cylinder(0.022, 0.024), dark)
        for i in range(_RIM):
            a = 2 * math.pi * i / _RIM
            turn = RotationMatrix.MakeZRotation(a) @ RotationMatrix.MakeXRotation(math.pi / 2)
            part = RigidTransform(turn, [r * math.cos(a), r * math.sin(a), 0.0])
            scene.shape(f"wheel/rim{i}", Capsule(0.009, 2 * math.pi * r / _RIM), dark, part)
        for i in range(_SPOKES):
            a = math.pi + 2 * math.pi * i / _SPOKES
            turn = RotationMatrix.MakeZRotation(a) @ RotationMatrix.MakeYRotation(math.pi / 2)
            spoke = RigidTransform(turn, [r / 2 * math.cos(a), r / 2 * math.sin(a), 0.0])
            scene.shape(f"wheel/spoke{i}", Cylinder(0.007, r), steel, spoke)
        scene.shape("wheel/mark", Box(0.022, 0.012, 0.012), (0.95, 0.70, 0.10, 1.0), RigidTransform([r, 0, 0.006]))
        scene.shape("wheel/stalk", Cylinder(0.006, knob - 0.011), steel, RigidTransform([-r, 0, knob / 2 - 0.002]))
        scene.shape("wheel/knob", Cylinder(0.016, 0.036), (0.80, 0.10, 0.10, 1.0), RigidTransform([-r, 0, knob]))

    def update(self, scene: Any, time: float, state: FloatArray) -> None:
        """Turn and slide."""
        center = np.array(self._mount.center) + [0.0, 0.0, state[1]]
        scene.pose("wheel", RigidTransform(RotationMatrix.MakeZRotation(state[0]), center), time)
