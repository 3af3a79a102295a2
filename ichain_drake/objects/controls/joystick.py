"""A sprung two-axis joystick: the hand tilts it, it reports two axes (paper sec. IV)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from pydrake.geometry import Box, Cylinder, Sphere
from pydrake.math import RigidTransform, RotationMatrix

from ichain_drake.objects.base import ParentStates
from ichain_drake.objects.controls.knob import KnobControl
from ichain_drake.state import FloatArray, StateSpace, Variable, columns

FULL_TILT = math.radians(25.0)
"""Tilt at which an axis is near its end [rad]."""

READ_NOISE = 0.004
"""Standard deviation of an axis reading."""

AXIS_STEPS = 127
"""An axis is rounded to 1/127, as an 8-bit device does."""

_CURVE = 1.5
_RETURN_TIME = 0.04  # [s] a released stick springs back


def axes_from_tilt(tilt: FloatArray) -> FloatArray:
    """The axis values that a tilt gives: non-linear, coupled, off centre.

    Args:
        tilt: the two tilt angles [rad], shape (..., 2).

    Returns:
        The two axes in [-1, 1], shape (..., 2).
    """
    tilt = np.asarray(tilt, dtype=float)
    a, b = (t / FULL_TILT for t in columns(tilt))
    x = 0.98 * a + 0.08 * b + 0.03
    y = b - 0.06 * a - 0.02
    axes = np.empty_like(tilt)
    axes[..., 0] = x * (1 - 0.06 * y * y)
    axes[..., 1] = y * (1 - 0.06 * x * x)
    axes = np.tanh(_CURVE * axes) / math.tanh(_CURVE)
    return np.minimum(np.maximum(axes, -1.0), 1.0)


def tilt_from_axes(axes: FloatArray) -> FloatArray:
    """The tilt that gives wanted axes, by fixed-point iteration of `axes_from_tilt`'s inverse.

    Used where a scenario sets up a start state, and by the oracle; never by learning.

    Args:
        axes: shape (..., 2), clipped to +-0.999.

    Returns:
        Tilt angles [rad], shape (..., 2).
    """
    wanted = np.arctanh(np.clip(np.asarray(axes, dtype=float), -0.999, 0.999) * math.tanh(_CURVE)) / _CURVE
    x, y = np.moveaxis(wanted, -1, 0)
    for _ in range(60):
        x, y = wanted[..., 0] / (1 - 0.06 * y**2), wanted[..., 1] / (1 - 0.06 * x**2)
    # Solve the linear part for the two angles.
    mixed = np.stack([x - 0.03, y + 0.02], axis=-1)
    inverse = np.linalg.inv(np.array([[0.98, 0.08], [-0.06, 1.0]]))
    return mixed @ inverse.T * FULL_TILT


@dataclass(frozen=True)
class JoystickMount:
    """Where the joystick stands: geometry that a scenario gives.

    Attributes:
        pivot: the two tilt axes meet here, in the robot's frame [m].
        yaw: rotation of the joystick about the vertical [rad].
        handle: distance from the pivot to the knob's centre [m].
        limit: mechanical end of each tilt axis [rad].
    """

    pivot: tuple[float, float, float] = (0.5, 0.0, 0.05)
    yaw: float = 0.0
    handle: float = 0.10
    limit: float = 0.6

    def tilt_from_knob(self, xy: FloatArray) -> FloatArray:
        """Tilt of the stick when the knob's centre is over a point of the table.

        Args:
            xy: horizontal position of the knob's centre in the robot's frame [m], shape (..., 2).

        Returns:
            Tilt angles [rad], shape (..., 2), clipped to the mechanical limit.
        """
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        d = (np.asarray(xy, dtype=float) - np.array(self.pivot[:2])) / self.handle
        east, north = columns(d)
        dx, dy = c * east + s * north, -s * east + c * north
        b = np.arcsin(np.clip(dy, -0.99, 0.99))
        tilt = np.empty_like(d)
        tilt[..., 0] = np.arcsin(np.clip(dx / np.cos(b), -0.99, 0.99))
        tilt[..., 1] = b
        return np.clip(tilt, -self.limit, self.limit)

    def knob_from_tilt(self, tilt: FloatArray) -> FloatArray:
        """Position of the knob's centre in the robot's frame [m], shape (..., 3), for tilt angles (..., 2) [rad]."""
        a, b = np.moveaxis(np.asarray(tilt, dtype=float), -1, 0)
        local = self.handle * np.stack([np.cos(b) * np.sin(a), np.sin(b), np.cos(b) * np.cos(a)], axis=-1)
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        rotation = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        return local @ rotation.T + np.array(self.pivot)


class Joystick(KnobControl[JoystickMount]):
    """The joystick. Its one parent is an object that has a position (x, y): a hand that holds the knob.

    Args:
        mount: where it stands.
        parents, initial, settings: see `WorldObject`.

    Raises:
        InputError: if the parent has no position along x and y.
    """

    state_space: ClassVar[StateSpace] = StateSpace(
        "joystick",
        (
            Variable("tilt_x", "rad", -0.7, 0.7, hidden=True, measured_in="plant"),
            Variable("tilt_y", "rad", -0.7, 0.7, hidden=True, measured_in="plant"),
            Variable("x_axis", "1", -1.0, 1.0, measured_in="plant"),
            Variable("y_axis", "1", -1.0, 1.0, measured_in="plant"),
        ),
    )
    mount_class: ClassVar[type[JoystickMount]] = JoystickMount
    knob_axes: ClassVar[tuple[str, ...]] = ("x", "y")

    def default_state(self) -> FloatArray:
        """Upright, with the axes that this gives."""
        return self.state_at_tilt(np.zeros(2))

    @staticmethod
    def state_at_tilt(tilt: FloatArray) -> FloatArray:
        """The full state at a tilt [rad], shape (..., 2) -> (..., 4)."""
        return np.concatenate([tilt, axes_from_tilt(tilt)], axis=-1)

    def step(
        self, state: FloatArray, parents: ParentStates, active: Mapping[str, FloatArray], noise: FloatArray, dt: float
    ) -> FloatArray:
        """Held: the knob is where the hand is. Released: the spring brings the stick back."""
        held = self.mount.tilt_from_knob(parents[self._hand][..., self._knob])
        free = state[..., :2] * math.exp(-dt / _RETURN_TIME)
        on = np.asarray(active[self._hand])[..., None] > 0.5
        return self.state_at_tilt(np.where(on, held, free))

    def sample_body(self, body: FloatArray) -> FloatArray:
        """Tilt from the two joint angles, and the axes that it gives."""
        return self.state_at_tilt(body[..., :2])

    def measure(self, state: FloatArray, noise: FloatArray) -> FloatArray:
        """Axes with read noise, rounded to 1/127."""
        read = state[..., self._observable] + READ_NOISE * noise
        return np.clip(np.round(read * AXIS_STEPS) / AXIS_STEPS, -1.0, 1.0)


class JoystickDrawing:
    """Base, stick and knob, for physics in which no plant holds the joystick."""

    def __init__(self, mount: JoystickMount) -> None:
        self._mount = mount

    def setup(self, scene: Any) -> None:
        """Create the shapes."""
        pivot = np.array(self._mount.pivot)
        turn = RotationMatrix.MakeZRotation(self._mount.yaw)
        base = RigidTransform(turn, [pivot[0], pivot[1], pivot[2] / 2])
        scene.shape("base", Box(0.12, 0.12, pivot[2]), (0.25, 0.27, 0.30, 1.0), base)
        handle = self._mount.handle
        scene.shape("stick/rod", Cylinder(0.006, handle), (0.1, 0.1, 0.1, 1.0), RigidTransform([0, 0, handle / 2]))
        scene.shape("stick/knob", Sphere(0.015), (0.75, 0.12, 0.12, 1.0), RigidTransform([0, 0, handle]))

    def update(self, scene: Any, time: float, state: FloatArray) -> None:
        """Tilt the stick."""
        turn = RotationMatrix.MakeZRotation(self._mount.yaw)
        tilt = RotationMatrix.MakeYRotation(state[0]) @ RotationMatrix.MakeXRotation(-state[1])
        scene.pose("stick", RigidTransform(turn @ tilt, np.array(self._mount.pivot)), time)
