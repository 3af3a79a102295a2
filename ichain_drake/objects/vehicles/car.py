"""The car of the video game: noisy, non-linear, 30 Hz (paper sec. IV; the paper gives no equations, these are ours)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ichain_drake.objects.base import ParentStates
from ichain_drake.objects.vehicles.vehicle import Vehicle, joined, planar_pose, scaled_noise
from ichain_drake.state import FloatArray, StateSpace, Variable, columns, wrap_angle

SCREEN = (800.0, 600.0)
"""Width and height of the game screen [px]."""


@dataclass(frozen=True)
class CarParameters:
    """Constants of the game.

    Attributes:
        acceleration: at full throttle [px/s^2].
        brake_gain: extra acceleration when the stick is pulled back, as a fraction.
        drag_linear, drag_quadratic, drag_turn: drag [1/s], [1/px], [1/rad].
        turn_radius: smallest radius at low speed [px].
        understeer_speed: speed at which the turn rate has halved [px/s].
        turn_lag, slip_lag: time constants of yaw rate and slip [s].
        slip_gain: slip per speed and yaw rate.
        camber: heading-dependent drift [px/s].
        wind: drift of a moving car [px/s].
        noise: standard deviations per square-root second of speed [px/s], yaw rate [rad/s], slip [px/s], position
            along x and y [px].
    """

    acceleration: float = 90.0
    brake_gain: float = 0.25
    drag_linear: float = 0.8
    drag_quadratic: float = 0.006
    drag_turn: float = 0.075
    turn_radius: float = 22.0
    understeer_speed: float = 80.0
    turn_lag: float = 0.15
    slip_lag: float = 0.12
    slip_gain: float = 0.07
    camber: float = 3.0
    wind: tuple[float, float] = (3.0, -2.0)
    noise: tuple[float, ...] = (10.0, 0.35, 3.0, 0.5, 0.5)


class Car(Vehicle[CarParameters]):
    """The car. Its one parent has two observable variables in [-1, 1]: steering, then throttle.

    Args:
        parameters: the game's constants.
        parents, initial, settings: see `WorldObject`.

    Raises:
        InputError: if there is not one parent with two observable variables.
    """

    state_space: ClassVar[StateSpace] = StateSpace(
        "car",
        (
            *planar_pose("screen", "px"),
            Variable("speed", "px/s"),
            Variable("yaw_rate", "rad/s"),
            Variable("slip", "px/s", hidden=True),
        ),
    )
    controls: ClassVar[tuple[str, str]] = ("steering", "throttle")
    parameters_class: ClassVar[type[CarParameters]] = CarParameters
    process_noise_size: ClassVar[int] = 5
    reading_std: ClassVar[tuple[float, ...]] = (0.5, 0.5, 0.01, 1.0, 0.02)

    def default_state(self) -> FloatArray:
        """At rest in the middle of the screen."""
        return np.array([SCREEN[0] / 2, SCREEN[1] / 2, 0.0, 0.0, 0.0, 0.0])

    def step(
        self, state: FloatArray, parents: ParentStates, active: Mapping[str, FloatArray], noise: FloatArray, dt: float
    ) -> FloatArray:
        """One frame of the game."""
        p = self.parameters
        jx, jy = (np.maximum(np.minimum(c, 1.0), -1.0) for c in self.read_controls(parents, active))
        x, y, heading, v, w, u = columns(state)
        n = scaled_noise(noise, p.noise, dt)

        steer = jx * (0.65 + 0.35 * jx**2)
        throttle = jy * (0.75 + 0.25 * np.abs(jy))
        acceleration = p.acceleration * throttle * (1 + p.brake_gain * (1 - np.tanh(4 * jy)))
        turn = steer * v / p.turn_radius / (1 + (v / p.understeer_speed) ** 2)
        drag = p.drag_linear * v + p.drag_quadratic * v * np.abs(v) + p.drag_turn * np.abs(v * w)
        v1 = v + dt * (acceleration - drag) + n[0]
        w1 = w + dt * (turn - w) / p.turn_lag + n[1]
        u1 = u + dt * (-p.slip_gain * v * w - u) / p.slip_lag + n[2]
        lateral = u1 + p.camber * np.sin(2 * heading + 0.7)
        moving = np.tanh(np.abs(v1) / 8)
        c, s = np.cos(heading), np.sin(heading)
        x1 = x + dt * (v1 * c - lateral * moving * s + p.wind[0] * moving) + n[3]
        y1 = y + dt * (v1 * s + lateral * moving * c + p.wind[1] * moving) + n[4]
        return joined(state, (x1, y1, wrap_angle(heading + dt * w1), v1, w1, u1))
