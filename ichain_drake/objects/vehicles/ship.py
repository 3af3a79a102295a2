"""A ship: three degrees of freedom (surge, sway, yaw) with momentum, drift, and a slow answer to the rudder.

A 1:100 model of a Mariner class cargo ship. Hydrodynamic derivatives, non-dimensional by length and speed through the
water: M. S. Chislett, J. Stroem-Tejsen, *Planar motion mechanism tests and full-scale steering and manoeuvring
predictions for a Mariner class vessel*, report Hy-5, Hydro- and Aerodynamics Laboratory, Lyngby 1965, as tabulated in
the Marine Systems Simulator (T. I. Fossen, T. Perez). Speeds are Froude-scaled. Engine, steering gear, current, noise
are ours.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ichain_drake.objects.base import ParentStates
from ichain_drake.objects.controls.wheel import TRAVEL
from ichain_drake.objects.vehicles.vehicle import Vehicle, joined, planar_pose, scaled_noise
from ichain_drake.state import FloatArray, StateSpace, Variable, columns, wrap_angle

SHIP_LENGTH = 160.93 / 100
"""Length of the ship [m]."""

_SLOWEST = 0.2  # of service speed: derivatives are scaled with no lower one, where they would be singular


@dataclass(frozen=True)
class ShipParameters:
    """Constants of the ship; derivatives non-dimensional, times 1e5.

    Attributes:
        length: [m].
        service: speed at which the derivatives were measured [m/s].
        mass: m - X_du, m - Y_dv, m x_G - Y_dr, m x_G - N_dv, I_z - N_dr.
        surge: X_u, X_vv, X_rr, X_rv, X_dd, X_vd; resistance is quadratic, with the slope X_u at service speed.
        sway: Y_v, Y_r, Y_vvv, Y_vvr, Y_d, Y_ddd, Y_vvd.
        yaw: N_v, N_r, N_vvv, N_vvr, N_d, N_ddd, N_vvd.
        full_ahead: engine speed at full travel of the column, over that of service.
        ratio: turn of the wheel over turn of the rudder.
        largest_rudder: [rad].
        rudder_lag, engine_lag: time constants [s].
        current: mean speed of the water along x and y [m/s].
        current_noise, current_time: standard deviation [m/s] and correlation time [s] of its change.
        noise: standard deviations per square-root second of surge, sway [m/s], yaw rate [rad/s], position along x and y
            [m]: waves.
    """

    length: float = SHIP_LENGTH
    service: float = 7.7175 / 10
    mass: tuple[float, ...] = (840.0, 1546.0, -9.0, -23.0, 83.0)
    surge: tuple[float, ...] = (-184.0, -899.0, 18.0, 798.0, -95.0, 93.0)
    sway: tuple[float, ...] = (-1160.0, -499.0, -8078.0, 15356.0, 278.0, -90.0, 1190.0)
    yaw: tuple[float, ...] = (-264.0, -166.0, 1636.0, -5483.0, -139.0, 45.0, -489.0)
    full_ahead: float = 1.8
    ratio: float = 3.6
    largest_rudder: float = math.radians(35.0)
    rudder_lag: float = 0.2
    engine_lag: float = 0.3
    current: tuple[float, float] = (0.03, -0.02)
    current_noise: float = 0.003
    current_time: float = 20.0
    noise: tuple[float, ...] = (0.006, 0.004, 0.005, 0.02, 0.02)


class Ship(Vehicle[ShipParameters]):
    """The ship. Its one parent is a wheel: angle [rad], counterclockwise turns left; slide [m], up is ahead.

    The bridge's instruments show rudder and engine; the current stays hidden.

    Args:
        parameters: constants.
        parents, initial, settings: see `WorldObject`.

    Raises:
        InputError: if there is not one parent with two observable variables.
    """

    state_space: ClassVar[StateSpace] = StateSpace(
        "ship",
        (
            *planar_pose("sea", "m"),
            Variable("surge", "m/s"),
            Variable("sway", "m/s"),
            Variable("rudder", "rad"),
            Variable("engine", "1"),
            Variable("yaw_rate", "rad/s"),
            Variable("current_x", "m/s", hidden=True),
            Variable("current_y", "m/s", hidden=True),
        ),
    )
    controls: ClassVar[tuple[str, str]] = ("angle", "slide")
    parameters_class: ClassVar[type[ShipParameters]] = ShipParameters
    process_noise_size: ClassVar[int] = 7
    reading_std: ClassVar[tuple[float, ...]] = (0.005, 0.005, 0.003, 0.005, 0.005, 0.005, 0.01, 0.003)

    def step(
        self, state: FloatArray, parents: ParentStates, active: Mapping[str, FloatArray], noise: FloatArray, dt: float
    ) -> FloatArray:
        """One frame."""
        p = self.parameters
        angle, slide = self.read_controls(parents, active)
        lever = p.full_ahead * np.maximum(np.minimum(slide / TRAVEL, 1.0), -1.0)
        x, y, heading, u, v, rudder, engine, r, cx, cy = columns(state)
        c, s = np.cos(heading), np.sin(heading)
        # The water's speed ahead and to the left; it does not turn with the ship.
        along, across = c * cx + s * cy, c * cy - s * cx
        u_rate, v_rate, r_rate = self._rates(u - along, v - across, r, rudder, engine)

        n = scaled_noise(noise, p.noise, dt)
        drift = p.current_noise * math.sqrt(2 * dt / p.current_time)
        wanted = np.maximum(np.minimum(angle / p.ratio, p.largest_rudder), -p.largest_rudder)
        values = (
            x + dt * (c * u - s * v) + n[3],
            y + dt * (s * u + c * v) + n[4],
            wrap_angle(heading + dt * r),
            u + dt * (u_rate + r * across) + n[0],
            v + dt * (v_rate - r * along) + n[1],
            rudder + dt * (wanted - rudder) / p.rudder_lag,
            engine + dt * (lever - engine) / p.engine_lag,
            r + dt * r_rate + n[2],
            cx + dt * (p.current[0] - cx) / p.current_time + drift * noise[..., 5],
            cy + dt * (p.current[1] - cy) / p.current_time + drift * noise[..., 6],
        )
        return joined(state, values)

    def _rates(
        self, u: FloatArray, v: FloatArray, r: FloatArray, rudder: FloatArray, engine: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Accelerations in surge and sway [m/s^2] and yaw [rad/s^2] at a velocity through the water."""
        p = self.parameters
        speed = np.sqrt(u * u + v * v)
        scale = np.maximum(speed, _SLOWEST * p.service)
        v_, r_ = v / scale, r * p.length / scale
        # The derivatives count a rudder positive that turns the ship the other way; it works by the flow from astern.
        d = -rudder * np.maximum(u, 0.0) / scale
        vv, dd = v_ * v_, d * d

        x_u, x_vv, x_rr, x_rv, x_dd, x_vd = p.surge
        force_u = x_vv * vv + x_rr * r_ * r_ + x_rv * r_ * v_ + x_dd * dd + x_vd * v_ * d
        drive = -x_u / 2 * (engine * np.abs(engine) - u * np.abs(u) / p.service**2)
        a = p.sway
        force_v = (a[0] + a[2] * vv) * v_ + (a[1] + a[3] * vv) * r_ + (a[4] + a[5] * dd + a[6] * vv) * d
        a = p.yaw
        moment = (a[0] + a[2] * vv) * v_ + (a[1] + a[3] * vv) * r_ + (a[4] + a[5] * dd + a[6] * vv) * d
        m11, m22, m23, m32, m33 = p.mass
        size = m22 * m33 - m23 * m32
        flow = scale * scale / p.length
        u_rate = (flow * force_u + p.service**2 / p.length * drive) / m11
        v_rate = flow * (m33 * force_v - m23 * moment) / size
        r_rate = flow / p.length * (m22 * moment - m32 * force_v) / size
        return u_rate, v_rate, r_rate
